"""The reconstructed normal actuator in the half plane: which iron and winding lies where.

The slot for the shim's tab is left out, since it has no rotational symmetry.
"""

from __future__ import annotations

from dataclasses import replace

from tactgen.geometry.device.checks import check_gap
from tactgen.geometry.device.parameters import NOMINAL_GAP, Device
from tactgen.geometry.device.steel_table import magnetisation_curve
from tactgen.geometry.errors import InputError
from tactgen.geometry.reluctance.section_grid import Region

#: Rounding of coordinates (m), so that edges meant to be level are so.
_DIGITS = 12
#: A moving edge level with a fixed one is lifted by this (m), since a line follows one part.
_APART = 1e-10


def actuator_regions(device: Device, gap: float) -> tuple[Region, ...]:
    """Return the parts of the normal actuator at a gap; z = 0 is the sleeve's top face.

    Raises
    ------
    InputError
        If parts overlap at this gap, or a moving one meets a fixed one, or the gap is not open.
    """
    rod, coil, sleeve = device.rod, device.coil, device.sleeve
    if not gap > 0.0:
        raise InputError(f"gap = {gap * 1e3:g} mm is not open; use a gap above 0 mm")
    check_gap(device, gap)
    steel = magnetisation_curve(device.steel)
    head = (NOMINAL_GAP, NOMINAL_GAP + rod.head_thickness)
    flange = -rod.flange_position
    moving = (
        Region("rod", (0.0, rod.radius), (-rod.length, head[1]), steel),
        Region("flange", (0.0, rod.flange_radius), (flange - rod.flange_thickness, flange), steel),
        Region("head", (0.0, rod.head_radius), head, steel),
        Region(
            "coil",
            (coil.inner_radius, coil.outer_radius),
            (-coil.position - coil.length, -coil.position),
            turns=coil.turns,
        ),
    )
    fixed = [
        Region("sleeve", (sleeve.inner_radius, sleeve.outer_radius), (-sleeve.length, 0.0), steel)
    ]
    if sleeve.collar_radius < sleeve.inner_radius:  # else there is none
        collar = (sleeve.collar_radius, sleeve.outer_radius), (-sleeve.collar_thickness, 0.0)
        fixed.append(Region("collar", *collar, steel))
    carried = [_rounded(replace(part, moves=True).displaced(gap - NOMINAL_GAP)) for part in moving]
    still = [_rounded(part) for part in fixed]
    _refuse_overlap(carried, still, gap)
    level = {z for part in still for z in part.heights}
    if any(z in level for part in carried for z in part.heights):
        carried = [part.displaced(_APART) for part in carried]
    return (*carried, *still)


def _rounded(part: Region) -> Region:
    (inner, outer), (low, high) = part.radii, part.heights
    return replace(
        part,
        radii=(round(inner, _DIGITS), round(outer, _DIGITS)),
        heights=(round(low, _DIGITS), round(high, _DIGITS)),
    )


def _refuse_overlap(carried: list[Region], still: list[Region], gap: float) -> None:
    """Refuse parts that touch although one moves, and a winding inside the iron it moves with."""
    for one in carried:
        for other in still:
            across, along = _shared(one, other)
            # a common edge is no contact of faces
            if min(across, along) >= 0.0 and max(across, along) > 0.0:
                raise InputError(
                    f"gap = {gap * 1e3:g} mm drives the {one.name} into the {other.name} by "
                    f"{min(across, along) * 1e3:.3g} mm; use a smaller gap or other radii"
                )
        if one.turns:
            for other in carried:
                if other is not one and min(_shared(one, other)) > 0.0:
                    raise InputError(
                        f"the {one.name} runs into the {other.name} by "
                        f"{min(_shared(one, other)) * 1e3:.3g} mm; make it shorter or move it"
                    )


def _shared(one: Region, other: Region) -> tuple[float, float]:
    """Return the lengths (m) shared across and along the axis; negative is a distance."""
    return (
        min(one.radii[1], other.radii[1]) - max(one.radii[0], other.radii[0]),
        min(one.heights[1], other.heights[1]) - max(one.heights[0], other.heights[0]),
    )
