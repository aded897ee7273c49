"""Bricks cut at sections: stretches of a grid, and the parts of a bimorph joined at one section.

The foot is what holds the bimorph and its first bit, the free part is the rest.  Both have the
same lines across the section, so that their polynomials agree there.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from tactgen.geometry.arrays import Ints
from tactgen.geometry.bimorph.bricks import Axis, Bricks

#: Bricks along z to each side of the section: short enough for what decays to do so.
_STEPS = 4


@dataclass(frozen=True)
class BrickParts:
    """A bimorph in two parts.

    Attributes
    ----------
    foot : Bricks
        From the held end to the section.
    free : Bricks
        From the section to the tip.
    middle : Bricks
        The bimorph to both sides of the section, as long above as below it: what fields at the
        section may look like is found there.
    share : float
        Fields that the section sees less of than this share of the strongest are left out.
    """

    foot: Bricks
    free: Bricks
    middle: Bricks
    share: float

    @property
    def regions(self) -> tuple[str, ...]:
        """Names of the materials, each once."""
        return tuple(dict.fromkeys((*self.foot.regions, *self.free.regions)))


def between(bricks: Bricks, low: int, high: int) -> tuple[Bricks, Ints]:
    """Return the bricks between two break points along z, and which nodes of the grid they have.

    The grid is cut to what these bricks need of it; z starts at 0.

    Returns
    -------
    bricks : Bricks
        The stretch.
    nodes : (n,) int array
        Flat positions of its nodes among all of the grid, ascending.
    """
    here = [slab for slab in bricks.slabs if slab.z[0] < high and slab.z[1] > low]
    columns = [column for slab in here for column in bricks.columns(slab)]
    wide, deep = (max(column[axis][1] for column in columns) for axis in (0, 1))
    slabs = tuple(
        replace(
            slab,
            x=(slab.x[0], min(slab.x[1], wide)),
            y=slab.y and (slab.y[0], min(slab.y[1], deep)),
            z=(max(slab.z[0], low) - low, min(slab.z[1], high) - low),
        )
        for slab in here
    )
    first, last = (int(np.clip(k, low, high)) - low for k in bricks.electrode)
    z = bricks.z.breaks[low : high + 1]
    cut = Bricks(
        Axis(bricks.x.breaks[: wide + 1], bricks.x.degree),
        Axis(bricks.y.breaks[: deep + 1], bricks.y.degree),
        Axis(z - z[0], bricks.z.degree),
        slabs=slabs,
        electrode=(first, last),
        held=bricks.held,
    )
    nx, ny, _ = cut.shape
    numbers = np.arange(int(np.prod(bricks.shape))).reshape(bricks.shape)
    return cut, numbers[:nx, :ny, bricks.z.nodes_of(low, high)].ravel()


def in_parts(bricks: Bricks, below: int, section: int, share: float) -> BrickParts:
    """Cut bricks at a break point along z.

    Parameters
    ----------
    below, section : int
        Break points along z between which the cross-section does not change; the second is the
        section.
    share : float
        See :class:`BrickParts`.
    """
    foot, _ = between(bricks, 0, section)
    free, _ = between(bricks, section, bricks.z.intervals)
    lower, _ = between(bricks, below, section)
    both = np.linspace(0.0, 2.0 * lower.z.breaks[-1], 2 * _STEPS + 1)
    middle = replace(
        lower,
        z=Axis(both, lower.z.degree),
        slabs=tuple(replace(slab, z=(0, 2 * _STEPS)) for slab in lower.slabs),
        electrode=(0, 2 * _STEPS),
    )
    return BrickParts(foot, free, middle, share)
