"""One division into bricks for a range of bimorphs: stretched piece by piece along its axes.

A piece is what one dimension of the device is as long as: half the shim, a layer, the bare tab.
Members of a family have the same pieces with the same intervals in each, and differ in how
long the pieces are.  Then all matrices of the solid are sums of fixed ones, times powers of the
lengths.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from tactgen.geometry.arrays import Floats
from tactgen.geometry.bimorph.bimorph_bricks import BrickMeshing, bimorph_bricks
from tactgen.geometry.bimorph.bricks import Axis, Bricks
from tactgen.geometry.device.parameters import Bimorph, Device
from tactgen.geometry.errors import InputError

#: Dimensions that say how long pieces are; the longer, the more bricks a piece must have.
LENGTHS = ("length", "width", "tab_length", "bare_below", "bare_above")
#: Those across the layers: the thinner, the more bricks everything else must have.
THICKNESSES = ("piezo_thickness", "shim_thickness", "glue_thickness")

#: Divisions like those of :data:`geometry.bimorph.bimorph_bricks.LEVELS`, about as accurate, with
#: polynomials of nodes and all their products: the sums of a family are products along the axes
#: (about 2, 5, 13, 27 and 52 thousand unknowns for a plain bimorph).
LEVELS = (
    BrickMeshing((2, 2, 3), side=0.4, smallest=0.4, tip=1.0, longest=8.0, pieces=(4.0, 10.0)),
    BrickMeshing((3, 3, 4), side=0.65, smallest=0.2, tip=1.0, pieces=(4.0, 10.0)),
    BrickMeshing((3, 3, 4), (0.35, 0.65), 2, 0.25, 0.07, tip=0.5, pieces=(4.0, 10.0)),
    BrickMeshing((4, 4, 4), (0.15, 0.85), 2, 0.15, 0.03, longest=5.0, pieces=(5.0, 10.0)),
    BrickMeshing((4, 4, 4), (0.15, 0.7, 0.15), 3, 0.1, 0.015, tip=0.1, longest=5.0, growth=5.0),
)


@dataclass(frozen=True)
class Pieces:
    """Lengths (m) of the pieces along each axis of the quarter, for n bimorphs.

    Attributes
    ----------
    x : (n, layers) array
        From the plane of symmetry: half the shim, the glue if there is any, the ceramic.
    y : (n, 1) array
        Half the width.
    z : (n, stretches) array
        Upwards: tab, ceramic without electrode, with, without; those that there are.
    """

    x: Floats
    y: Floats
    z: Floats

    @property
    def axes(self) -> tuple[Floats, Floats, Floats]:
        """The three axes."""
        return self.x, self.y, self.z


def piece_lengths(bimorph: Bimorph, values: Mapping[str, Any]) -> Pieces:
    """Return the pieces of bimorphs that differ from one in some dimensions.

    Parameters
    ----------
    values : mapping of str to (n,) array
        Of fields of the bimorph; others are ignored.

    Raises
    ------
    InputError
        If a piece that there is has no length, or one is there in some bimorphs only.
    """

    def of(name: str) -> Floats:
        return np.atleast_1d(np.asarray(values.get(name, getattr(bimorph, name)), dtype=float))

    below, above = of("bare_below"), of("bare_above")
    covered = of("length") - below - above
    return Pieces(
        _together({"shim": 0.5 * of("shim_thickness"), "glue": of("glue_thickness"),
                   "piezo": of("piezo_thickness")}),
        _together({"width": 0.5 * of("width")}),
        _together({"tab": of("tab_length"), "bare_below": below, "electrode": covered,
                   "bare_above": above}),
    )  # fmt: skip


def _together(named: dict[str, Floats]) -> Floats:
    optional = ("glue", "tab", "bare_below", "bare_above")
    there = {
        name: size for name, size in named.items() if name not in optional or np.any(size != 0.0)
    }
    for name, size in there.items():
        if not (size > 0.0).all():
            raise InputError(
                f"the piece {name} of the bimorph is {1e3 * size.min():.4g} mm long somewhere in "
                "the range; let it be longer than 0 everywhere, or 0 everywhere"
            )
    return np.column_stack(np.broadcast_arrays(*there.values()))


def dividing(members: Sequence[Device], meshing: BrickMeshing) -> Bricks:
    """Return a division that is fine enough for all members of a range, by its corners.

    It is that of the longest and widest bimorph with the thinnest layers: stretched to any
    other, bricks at edges and ends become finer beside the layers, and nowhere coarser.
    """
    bimorphs = [device.bimorph for device in members]
    extreme = {
        name: pick(getattr(bimorph, name) for bimorph in bimorphs)
        for names, pick in ((LENGTHS, max), (THICKNESSES, min))
        for name in names
    }
    device = members[0].model_copy(update={"bimorph": bimorphs[0].model_copy(update=extreme)})
    return bimorph_bricks(device, meshing)


def piece_breaks(bricks: Bricks) -> tuple[list[int], list[int], list[int]]:
    """Return at which break points along each axis the pieces begin and end."""
    across = {i for slab in bricks.slabs for i in slab.x}
    along = {i for slab in bricks.slabs for i in slab.z} | set(bricks.electrode)
    return sorted(across), [0, bricks.y.intervals], sorted(along)


def stretched(bricks: Bricks, bimorph: Bimorph) -> Bricks:
    """Return the division with its pieces as long as a bimorph has them.

    Raises
    ------
    InputError
        If the bimorph has other pieces.
    """
    lengths = piece_lengths(bimorph, {}).axes
    axes = []
    for axis, breaks, new in zip(bricks.axes, piece_breaks(bricks), lengths, strict=True):
        if new.shape[1] != len(breaks) - 1:
            raise InputError(
                "a bimorph with other pieces (tab, glue, bare ends) is not of this family of bricks"
            )
        old = np.diff(axis.breaks[breaks])
        factors = np.repeat(new[0] / old, np.diff(breaks))
        moved = np.concatenate([[0.0], np.cumsum(np.diff(axis.breaks) * factors)])
        axes.append(Axis(moved, axis.degree))
    return replace(bricks, x=axes[0], y=axes[1], z=axes[2])
