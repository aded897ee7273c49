"""How the bimorph glued into its rod is divided into bricks.

One tensor grid for all: its lines are the faces of tab, bond and layers, and the round rod
ends within its bricks.  Bricks shrink towards the tab's faces in the bond, towards its ends in
and above the slot and towards the ceramic's lower edge, where the solution is singular.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from tactgen.geometry.arrays import Floats
from tactgen.geometry.bimorph.bimorph_bricks import BrickParts, in_parts
from tactgen.geometry.bimorph.bricks import Axis, Bricks, Slab
from tactgen.geometry.device.checks import check_constant_section, check_fit, check_plain_layers
from tactgen.geometry.device.layout import ceramic_base, rod_base, shim_base
from tactgen.geometry.device.parameters import NOMINAL_GAP, Device, Support

#: Distance of the sections from the ceramic's ends, in thicknesses of the bimorph: its edges are
#: then seen through a few smooth fields.
_SECTION = 2.0
#: Longest brick along z, in thicknesses of the bimorph, and ratio of neighbouring lengths; and of
#: neighbouring widths: bending across the width tells them.
_LONGEST, _GROWTH, _GROWTH_ACROSS = 3.0, 4.0, 3.0
#: Longest brick along z below the slot, in radii of the rod: flange, stem and head bend as one.
_LONGEST_BELOW = 1.0
#: Widest brick of the rod beside the slot (m): a smooth field in stiff steel.
_WIDEST = 0.8e-3
#: Lengths below this (m) are rounding.
_ROUNDING = 1e-12


@dataclass(frozen=True)
class RodMeshing:
    """How finely the bimorph on its rod is divided.

    Attributes
    ----------
    degree : (int, int, int)
        Degree of the polynomials along x, y and z.
    smallest : float
        Length of the bricks at the tab's ends and at the ceramic's lower end, as a share of the
        shim's thickness.
    tip : float
        The same at the upper end, where the singularity is weak.
    side : float
        Interval at the side edge, as a share of the shim's thickness.
    core, bond, layer : tuple of float
        Intervals along x of half the shim, of the bond line and of what is left of a piezo layer
        beside it, outwards, as shares of each.
    share : float
        Least share of a field at the section, see :class:`BrickParts`.
    """

    degree: tuple[int, int, int]
    smallest: float
    side: float
    tip: float = 1.0
    core: tuple[float, ...] = (1.0,)
    bond: tuple[float, ...] = (1.0,)
    layer: tuple[float, ...] = (1.0,)
    share: float = 1e-4


#: A family of divisions for refinement studies, see :data:`geometry.bimorph.bimorph_bricks.LEVELS`.
#: What tells most is the shim near the bond and the bond itself, across both: a lower degree on
#: more intervals there is worth more than a higher one on few.
ROD_LEVELS = (
    RodMeshing((2, 2, 3), 0.4, 0.8, 2.0, core=(0.6, 0.4)),
    RodMeshing((3, 3, 3), 0.2, 0.8, core=(0.75, 0.25), bond=(0.5, 0.5)),
    RodMeshing((3, 3, 4), 0.1, 0.4, core=(0.6, 0.3, 0.1), bond=(0.5, 0.5)),
    RodMeshing((3, 3, 4), 0.07, 0.3, core=(0.66, 0.26, 0.08), bond=(0.15, 0.7, 0.15)),
    RodMeshing((3, 3, 4), 0.04, 0.2, 1.0, (0.68, 0.24, 0.06, 0.02), (0.15, 0.7, 0.15), (0.3, 0.7)),
)


def rod_parts(device: Device, meshing: RodMeshing) -> Bricks | BrickParts:
    """Divide the bimorph on its rod, in three parts where it is long enough for that.

    Foot, tip and all that is known of the sections are the same for any length.
    """
    bricks = rod_bricks(device, meshing)
    if not _has_sections(device):
        return bricks
    z, (ceramic, _), height = bricks.z.breaks, bricks.electrode, _SECTION * device.bimorph.thickness
    lower, upper = (int(np.argmin(np.abs(z - at))) for at in (z[ceramic] + height, z[-1] - height))
    return in_parts(bricks, ceramic, (lower, upper), meshing.share)


def rod_bricks(device: Device, meshing: RodMeshing, *, filled: bool = False) -> Bricks:
    """Divide a quarter of the bimorph and its rod, z = 0 at the rod's bottom face.

    Parameters
    ----------
    filled : bool
        Let the rod take the place of the tab in its slot, on the same bricks: in a rigid rod the
        tab then is held by its whole section at the slot's mouth.

    Raises
    ------
    InputError
        If the parts do not fit together, or the bimorph is no three plain layers.
    """
    check_plain_layers(device)
    check_constant_section(device)
    check_fit(device, Support(kind="rod"))
    b, bond = device.bimorph, device.glue.thickness
    half, width = 0.5 * b.shim_thickness, 0.5 * b.width
    outer = half + b.piezo_thickness
    reach = max(device.rod.radius, device.rod.flange_radius, device.rod.head_radius)
    lines: dict[float, Sequence[float] | Floats] = {
        half: meshing.core,
        half + bond: meshing.bond,
        outer: meshing.layer,
    }
    x = _lines(lines, reach)
    side = meshing.side * b.shim_thickness
    inside = _graded(width, None, side, width, _GROWTH_ACROSS) / width
    y = _lines({width: np.diff(inside), width + bond: (1.0,)}, reach)
    z, at = _along(device, meshing)
    nx, ny = x.size - 1, y.size - 1
    shim, slot, piezo = (int(np.argmin(np.abs(x - end))) for end in (half, half + bond, outer))
    tab, wall = (int(np.argmin(np.abs(y - end))) for end in (width, width + bond))
    deep = (at["slot"], at["head"])
    slabs = [
        Slab("rod" if filled else "shim", (0, shim), (at["tab"], at["head"]), (0, tab)),
        Slab("shim", (0, shim), (at["head"], at["tip"]), (0, tab)),
        Slab("piezo", (shim, piezo), (at["ceramic"], at["tip"]), (0, tab)),
        Slab("glue", (0, slot), (at["slot"], at["tab"]), (0, wall)),
        Slab("glue", (shim, slot), (at["tab"], at["head"]), (0, wall)),
        Slab("glue", (0, shim), (at["tab"], at["head"]), (tab, wall)),
        *(
            Slab("rod", (0, nx), (at[low], at[high]), None, radius)
            for low, high, radius in (
                ("bottom", "flange's bottom", device.rod.radius),
                ("flange's bottom", "flange", device.rod.flange_radius),
                ("flange", "head's bottom", device.rod.radius),
                ("head's bottom", "slot", device.rod.head_radius),
            )
        ),
        Slab("rod", (slot, nx), deep, None, device.rod.head_radius),
        Slab("rod", (0, slot), deep, (wall, ny), device.rod.head_radius),
    ]
    along_x, along_y, along_z = meshing.degree
    return Bricks(
        Axis(x, along_x),
        Axis(y, along_y),
        Axis(z, along_z),
        slabs=tuple(slab for slab in slabs if slab.z[1] > slab.z[0]),
        electrode=(at["ceramic"], at["tip"]),
    )


def _has_sections(device: Device) -> bool:
    """Return whether the bimorph is long enough to be cut in three of some length each."""
    return bool(device.bimorph.length > 3.0 * _SECTION * device.bimorph.thickness)


def _along(device: Device, meshing: RodMeshing) -> tuple[Floats, dict[str, int]]:
    """Divide the height; also return at which break points things begin or end."""
    b, rod = device.bimorph, device.rod
    fine = meshing.smallest * b.shim_thickness
    bottom, ceramic = rod_base(device), ceramic_base(device, "rod")
    flange = -rod.head_thickness - NOMINAL_GAP - rod.flange_position
    # each height with the length of the bricks there, None where nothing is singular
    marks: list[tuple[str, float, float | None]] = [
        ("bottom", bottom, None),
        ("flange's bottom", flange - rod.flange_thickness, None),
        ("flange", flange, None),
        ("head's bottom", -rod.head_thickness, None),
        ("slot", -rod.slot_depth, None),
        ("tab", shim_base(device, "rod"), fine),
        ("head", 0.0, fine),
        ("ceramic", ceramic, fine),
        ("tip", ceramic + b.length, max(meshing.smallest, meshing.tip) * b.shim_thickness),
    ]
    if _has_sections(device):
        height = _SECTION * b.thickness
        marks[-1:-1] = [
            ("lower section", ceramic + height, None),
            ("upper section", ceramic + b.length - height, None),
        ]
    below, above = _LONGEST_BELOW * rod.radius, _LONGEST * b.thickness
    z, at = np.array([bottom]), {"bottom": 0}
    for (_, low, first), (name, high, last) in pairwise(marks):
        longest = below if high <= -rod.slot_depth else above
        if high - low > _ROUNDING:
            z = np.concatenate([z, low + _graded(high - low, first, last, longest)[1:]])
            z[-1] = high
        at[name] = z.size - 1
    return z - bottom, at


def _lines(ends: dict[float, Sequence[float] | Floats], reach: float) -> Floats:
    """Return 0, the ends with shares of what is between them, and lines out to `reach`."""
    lines = np.zeros(1)
    for end in sorted(ends):
        steps = (end - lines[-1]) * np.asarray(ends[end])
        lines = np.concatenate([lines, lines[-1] + np.cumsum(steps)])
        lines[-1] = end
    rest = reach - lines[-1]
    if rest > _ROUNDING:
        pieces = int(np.ceil(rest / _WIDEST))
        lines = np.concatenate([lines, np.linspace(lines[-1], reach, pieces + 1)[1:]])
    return lines


def _graded(
    length: float,
    first: float | None,
    last: float | None,
    longest: float,
    growth: float = _GROWTH,
) -> Floats:
    """Divide [0, length], intervals growing from `first` below and `last` above, if given."""
    lower, upper = ([] if end is None else [min(end, longest)] for end in (first, last))
    while sum(lower) + sum(upper) < length:
        ends = [side for side in (lower, upper) if side]
        if not ends:
            pieces = int(np.ceil(length / longest - 1e-9))
            return np.linspace(0.0, length, pieces + 1)
        side = min(ends, key=lambda steps: steps[-1])
        side.append(min(side[-1] * growth, longest))
    steps = np.array(lower + upper[::-1])
    return np.concatenate([[0.0], np.cumsum(steps)]) * float(length / steps.sum())
