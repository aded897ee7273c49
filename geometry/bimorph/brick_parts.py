"""Bricks cut at sections: stretches of a grid, and the parts of a bimorph joined at two sections.

The foot is what holds the bimorph and its first bit, the tip its last; between them nothing but
the length changes.  All have the same lines across the section, so that their polynomials agree
there.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from tactgen.geometry.arrays import Floats, Ints
from tactgen.geometry.bimorph.bricks import Axis, Bricks, Slab

#: Bricks along z to each side of the section: short enough for what decays to do so.
_STEPS = 4
#: Degree of the polynomials along the stretch, …
_DEGREE = 6
#: … their first and longest interval, as shares of the sections' distance from the ends, and the
#: ratio of neighbours: what still decays at a section does so within the first ones.
_FIRST, _LONGEST, _GROWTH = 0.5, 4.0, 2.0
#: Digits (m) that tell lengths apart: the same end of another bimorph is the same to the last bit.
_DIGITS = 13


@dataclass(frozen=True)
class BrickParts:
    """A bimorph in three parts.

    Attributes
    ----------
    foot : Bricks
        From the held end to the lower section.
    tip : Bricks
        From the upper section to the tip; z starts at 0.
    stretch : Axis
        Along z from one section to the other; z starts at 0.
    middle : Bricks
        The bimorph to both sides of a section, as long above as below it: what fields at the
        section may look like is found there.
    share : float
        Fields that the section sees less of than this share of the strongest are left out.
    """

    foot: Bricks
    tip: Bricks
    stretch: Axis
    middle: Bricks
    share: float

    @property
    def regions(self) -> tuple[str, ...]:
        """Names of the materials, each once."""
        return tuple(dict.fromkeys((*self.foot.regions, *self.tip.regions)))

    @property
    def values(self) -> int:
        """Number of displacements and potentials at the nodes of foot and tip."""
        return 4 * sum(int(part.used().sum()) for part in (self.foot, self.tip))


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


def uniform(bricks: Bricks, breaks: Floats, degree: int) -> Bricks:
    """Return bricks of one cross-section on another axis along z, with electrodes all along it."""
    count = breaks.size - 1
    slabs: tuple[Slab, ...] = tuple(replace(slab, z=(0, count)) for slab in bricks.slabs)
    return replace(bricks, z=Axis(breaks, degree), slabs=slabs, electrode=(0, count))


def in_parts(bricks: Bricks, below: int, sections: tuple[int, int], share: float) -> BrickParts:
    """Cut bricks at two break points along z.

    Parameters
    ----------
    below : int
        Break point along z from which on the cross-section does not change up to the tip.
    sections : (int, int)
        Break points of the lower and of the upper section.
    share : float
        See :class:`BrickParts`.
    """
    lower, upper = sections
    foot, _ = between(bricks, 0, lower)
    tip, _ = between(bricks, upper, bricks.z.intervals)
    tip = replace(tip, z=Axis(np.round(tip.z.breaks, _DIGITS), tip.z.degree))
    short, _ = between(bricks, below, lower)
    height = round(float(short.z.breaks[-1]), _DIGITS)
    both = np.linspace(0.0, 2.0 * height, 2 * _STEPS + 1)
    length = float(bricks.z.breaks[upper] - bricks.z.breaks[lower])
    return BrickParts(
        foot,
        tip,
        Axis(_graded(length, height), _DEGREE),
        uniform(short, both, short.z.degree),
        share,
    )


def _graded(length: float, height: float) -> Floats:
    """Divide a stretch, intervals growing from both ends; `height` is that of foot and tip."""
    half, step = [0.0], _FIRST * height
    while half[-1] < 0.5 * length:
        half.append(half[-1] + step)
        step = min(_GROWTH * step, _LONGEST * height)
    lower = 0.5 * length * np.array(half) / half[-1]
    return np.concatenate([lower, length - lower[-2::-1]])
