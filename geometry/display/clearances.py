"""Clearances between the display's parts, in closed form."""

from __future__ import annotations

from dataclasses import dataclass

from tactgen.geometry.device.parameters import Device, Display
from tactgen.geometry.device.parts import MM
from tactgen.geometry.display.layout import (
    as_built,
    axes,
    levels,
    return_spring_length,
    spacer_axes,
    support_spacer_axes,
)
from tactgen.geometry.errors import InputError

#: What counts as touching (m).
_ROUNDING = 1e-12
#: Outer radius of a spring on a spacer beyond the spacer's (m); see geometry.display.layout.
_SPRING_AROUND = 0.5e-3


@dataclass(frozen=True)
class Clearance:
    """Distance of two parts, or width left between two holes."""

    #: The parts, and the direction
    between: str
    where: str
    gap: float  #: m; 0 or less is an interference
    key: str  #: Scene key that widens it
    larger: bool = True  #: Whether a larger value of the key widens it


def footprint(device: Device) -> tuple[float, float]:
    """Sizes (m) along x and y of the box round a generator."""
    rod, sleeve = device.rod, device.sleeve
    round_parts = 2.0 * max(rod.head_radius, sleeve.outer_radius)
    b = device.bimorph
    return max(round_parts, b.thickness), max(round_parts, b.width)


def clearances(device: Device, display: Display) -> tuple[Clearance, ...]:
    """All distances that could close, the narrowest first."""
    built = as_built(device, display)
    found = (
        *_between_units(built, display),
        *_in_units(built, display),
        *_around_units(built, display),
    )
    return tuple(sorted(found, key=lambda c: c.gap))


def _between_units(device: Device, display: Display) -> list[Clearance]:
    b, pitch = device.bimorph, display.pitch
    found = []
    if display.rows > 1:
        slot = b.width + 2.0 * display.slot_clearance
        found += [
            Clearance("bimorph - bimorph", "y", pitch - b.width, "display.pitch"),
            Clearance("upper board's web", "y, between slots", pitch - slot, "display.pitch"),
        ]
    if display.columns > 1:
        slot = b.thickness + 2.0 * display.slot_clearance
        found += [
            Clearance("bimorph - bimorph", "x", pitch - b.thickness, "display.pitch"),
            Clearance("upper board's web", "x, between slots", pitch - slot, "display.pitch"),
        ]
    if display.rows * display.columns > 1:
        sleeve, head = 2.0 * device.sleeve.outer_radius, 2.0 * device.rod.head_radius
        found += [
            Clearance("sleeve - sleeve", "x or y", pitch - sleeve, "display.pitch"),
            Clearance("head - head", "x or y", pitch - head, "display.pitch"),
            Clearance("lower board's web", "between sleeves", pitch - sleeve, "display.pitch"),
            Clearance("ground plate's web", "between screws", pitch - display.screw_diameter,
                      "display.pitch"),
        ]  # fmt: skip
    return found


def _in_units(device: Device, display: Display) -> list[Clearance]:
    rod, coil, sleeve, b = device.rod, device.coil, device.sleeve, device.bimorph
    spring = 0.5 * (display.spring_diameter + display.spring_wire)
    turns = spring_turns(device, display)
    solid = (turns + 2.0) * display.spring_wire
    stroke = device.gap - device.spring.stop_gap
    bore = "sleeve.inner_radius"
    return [
        Clearance("rod - sleeve", "radial, flange", sleeve.inner_radius - rod.flange_radius, bore),
        Clearance("coil - sleeve", "radial", sleeve.inner_radius - coil.outer_radius, bore),
        Clearance("head - sleeve", "z, working gap", device.gap, "gap"),
        Clearance("head - sleeve", "z, at the lower stop", device.spring.stop_gap,
                  "spring.stop_gap"),
        Clearance("return spring - sleeve", "radial", sleeve.inner_radius - spring,
                  "display.spring_diameter", larger=False),
        Clearance("grub screw - sleeve", "radial",
                  sleeve.inner_radius - 0.5 * display.screw_diameter,
                  "display.screw_diameter", larger=False),
        Clearance("return spring", "z, above solid length",
                  return_spring_length(device, display) - solid - stroke, "sleeve.length"),
        Clearance("grub screw - ground plate", "z, within the plate",
                  display.plate_thickness - display.screw_length, "display.screw_length",
                  larger=False),
        Clearance("bimorph - upper board", "x and y", display.slot_clearance,
                  "display.slot_clearance"),
        Clearance("ceramic - head", "z", device.ceramic_base, "display.tab_length"),
        Clearance("return spring's coil", "radial, inside",
                  0.5 * display.spring_diameter - display.spring_wire,
                  "display.spring_diameter"),
        Clearance("shim - upper board", "x", 0.5 * (b.thickness - b.shim_thickness)
                  + display.slot_clearance, "display.slot_clearance"),
    ]  # fmt: skip


def _around_units(device: Device, display: Display) -> list[Clearance]:
    level, radius = levels(device, display), 0.5 * display.spacer_diameter
    x_field, y_field = (max(c) for c in zip(*axes(display), strict=True))
    reach = device.sleeve.outer_radius
    x_post, y_post = spacer_axes(display.width, display.board_length, display)[-1]
    _, y_far = support_spacer_axes(display)[-1]
    spring = radius + _SPRING_AROUND
    support = level.support_top - display.support_thickness
    upper_top = level.rod_top + display.board_thickness
    opening = (
        x_field + 0.5 * device.bimorph.thickness + display.support_clearance,
        y_field + 0.5 * device.bimorph.width + display.support_clearance,
    )
    return [
        Clearance("sleeve - spring on spacer", "x", x_post - x_field - reach - spring,
                  "display.width"),
        Clearance("sleeve - spring on spacer", "y", y_post - y_field - reach - spring,
                  "display.board_length"),
        Clearance("support spacer - boards", "y", y_far - radius - 0.5 * display.board_length,
                  "display.length"),
        Clearance("support spacer - plate's edge", "y", 0.5 * display.length - y_far - radius,
                  "display.length"),
        Clearance("support spacer - opening", "y", y_far - radius - opening[1], "display.length"),
        Clearance("tips - support plate", "x and y", display.support_clearance,
                  "display.support_clearance"),
        Clearance("support plate's rim", "x", 0.5 * display.width - opening[0], "display.width"),
        Clearance("upper board - support plate", "z", support - upper_top, "bimorph.length"),
        Clearance("lower board - ground plate", "z", level.lower_board - display.plate_thickness,
                  "display.sleeve_protrusion", larger=False),
        Clearance("lower board - upper board", "z",
                  level.rod_top - level.lower_board - display.board_thickness,
                  "display.sleeve_protrusion"),
    ]  # fmt: skip


def spring_turns(device: Device, display: Display) -> float:
    """Return spring's active turns, n = G d⁴ / (8 D³ R) (EN 13906-1)."""
    wire, mean = display.spring_wire, display.spring_diameter
    rate = device.spring.stiffness
    if rate <= 0.0:
        raise InputError(
            f"spring.stiffness = {rate:g} N/m has no turns; give the return spring a stiffness"
        )
    return float(display.spring_shear_modulus * wire**4 / (8.0 * mean**3 * rate))


def check_display(device: Device, display: Display) -> None:
    """Refuse a display whose parts run into each other.

    Raises InputError in one sentence, with both sizes and the key to change.
    """
    across, along = footprint(device)
    size = max(across if display.columns > 1 else 0.0, along if display.rows > 1 else 0.0)
    if display.pitch <= size + _ROUNDING:
        raise InputError(
            f"display.pitch = {display.pitch * MM:g} mm is no more than a generator's footprint of "
            f"{size * MM:g} mm; set display.pitch to more than that, or make sleeve.outer_radius, "
            "rod.head_radius and bimorph.width smaller"
        )
    tightest = clearances(device, display)[0]
    if tightest.gap <= _ROUNDING:
        remedy = "larger" if tightest.larger else "smaller"
        raise InputError(
            f"{tightest.between} ({tightest.where}) leaves {tightest.gap * MM:.3g} mm in the "
            f"display; make {tightest.key} {remedy}"
        )
