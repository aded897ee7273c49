"""Where every part of the display is: each distinct solid once, and the places it stands at.

Millimetres, as in :mod:`geometry.device.parts`.  z = 0 is the ground plate's underside; the
generators' field is centred on the z axis, rows along y, columns along x.  A generator's own
parts keep their frame (z = 0 at the rod's top face) and are put up by its places.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tactgen.geometry.device.parameters import Device, Display, Scatter
from tactgen.geometry.device.parts import (
    MM,
    Box,
    Part,
    Turned,
    below_head,
    layout,
    rod_base,
    total_height,
)

#: A place: where a part's own origin stands (mm).
Place = tuple[float, float, float]
#: Distance of the spacers' axes from the plate's and boards' edges, in spacer diameters.
_INSET = 1.0
#: Springs on the spacers: gap to the spacer and thickness of their envelope (m).
_AROUND, _ENVELOPE = 0.1e-3, 0.4e-3
#: Lengths are rounded to 1e-9 mm, as a generator's are.
_DIGITS = 9


@dataclass(frozen=True)
class Plate:
    """A box with round holes (x, y, radius) and rectangular windows right through it (mm)."""

    body: Box
    holes: tuple[tuple[float, float, float], ...] = ()
    windows: tuple[tuple[float, float, float, float], ...] = ()


@dataclass(frozen=True)
class Placed:
    """One distinct solid and where it stands."""

    name: str  #: What people call it
    body: Part | Plate  #: The solid in its own frame
    places: tuple[Place, ...]  #: One for each copy


@dataclass(frozen=True)
class Levels:
    """Heights above the ground plate's underside (m), from the bottom up."""

    sleeve_bottom: float
    lower_board: float
    sleeve_top: float
    rod_top: float
    support_top: float
    tip: float

    @property
    def total(self) -> float:
        """Height of the display."""
        return max(self.tip, self.support_top)


def as_built(device: Device, display: Display) -> Device:
    """Device with the tab that is built, where the scene's support stands for it."""
    if device.bimorph.tab_length > 0.0:
        return device
    bimorph = device.bimorph.model_copy(update={"tab_length": display.tab_length})
    return device.model_copy(update={"bimorph": bimorph})


def levels(device: Device, display: Display) -> Levels:
    """Heights that the parts add up to, without current (the rod at its upper stop)."""
    built = as_built(device, display)
    bottom = display.plate_thickness
    rod_top = bottom + below_head(built)
    sleeve_top = rod_top - device.rod.head_thickness - device.gap
    tip = bottom + total_height(built)
    return Levels(
        sleeve_bottom=sleeve_top - device.sleeve.length,
        lower_board=sleeve_top - display.sleeve_protrusion - display.board_thickness,
        sleeve_top=sleeve_top,
        rod_top=rod_top,
        support_top=tip - display.tip_protrusion,
        tip=tip,
    )


def axes(display: Display) -> tuple[tuple[float, float], ...]:
    """Generators' axes (x, y) in m, row by row."""
    x, y = (
        [display.pitch * (i - 0.5 * (count - 1)) for i in range(count)]
        for count in (display.columns, display.rows)
    )
    return tuple((across, along) for along in y for across in x)


def unit_names(display: Display) -> tuple[str, ...]:
    """Generators' names, ``r1c1`` and so on, in the order of :func:`axes`."""
    return tuple(
        f"r{row + 1}c{column + 1}"
        for row in range(display.rows)
        for column in range(display.columns)
    )


def spacer_axes(width: float, length: float, display: Display) -> tuple[tuple[float, float], ...]:
    """Axes (m) of four spacers near the corners of a plate."""
    inset = _INSET * display.spacer_diameter
    x, y = 0.5 * width - inset, 0.5 * length - inset
    return ((-x, -y), (x, -y), (-x, y), (x, y))


def support_spacer_axes(display: Display) -> tuple[tuple[float, float], ...]:
    """Axes (m) of the support plate's spacers, in the strip beyond the boards."""
    y = 0.25 * (display.length + display.board_length)
    x = 0.5 * display.width - _INSET * display.spacer_diameter
    return ((-x, -y), (x, -y), (-x, y), (x, y))


def return_spring_length(device: Device, display: Display) -> float:
    """Length (m) of a return spring, from the rod's end to the ground plate."""
    built = as_built(device, display)
    return float(below_head(built) + rod_base(built))


def display_parts(device: Device, display: Display) -> tuple[Placed, ...]:
    """Every distinct part of the display with its places.

    Raises InputError if a generator's own parts cannot be put together.
    """
    built = as_built(device, display)
    units = layout(built, "rod")
    level = levels(device, display)
    field = axes(display)
    stood = tuple((_mm(x), _mm(y), _mm(level.rod_top)) for x, y in field)
    return (
        *(Placed(name, part, stood) for name, part in units.items()),
        *_below_units(device, display),
        *_boards(built, display, level),
        *_spacers(display, level),
    )


def _below_units(device: Device, display: Display) -> tuple[Placed, ...]:
    field = axes(display)
    places = _upright(field)
    wire, mean = display.spring_wire, display.spring_diameter
    thickness = display.plate_thickness
    screw = 0.5 * display.screw_diameter
    return (
        Placed(
            "return_spring",
            _tube(0.5 * (mean - wire), 0.5 * (mean + wire),
                  thickness, thickness + return_spring_length(device, display)),
            places,
        ),
        Placed(
            "grub_screw",
            _tube(0.0, screw, thickness - display.screw_length, thickness),
            places,
        ),
        Placed(
            "ground_plate",
            Plate(_slab(display.width, display.length, 0.0, thickness), _holes(field, screw)),
            ((0.0, 0.0, 0.0),),
        ),
    )  # fmt: skip


def _boards(device: Device, display: Display, level: Levels) -> tuple[Placed, ...]:
    field, origin = axes(display), ((0.0, 0.0, 0.0),)
    thick, spacer = display.board_thickness, 0.5 * display.spacer_diameter
    posts = spacer_axes(display.width, display.board_length, display)
    slot = (
        0.5 * device.bimorph.thickness + display.slot_clearance,
        0.5 * device.bimorph.width + display.slot_clearance,
    )
    reach = (
        0.5 * (display.columns - 1) * display.pitch + 0.5 * device.bimorph.thickness,
        0.5 * (display.rows - 1) * display.pitch + 0.5 * device.bimorph.width,
    )
    opening = tuple(_mm(half + display.support_clearance) for half in reach)
    support = level.support_top - display.support_thickness
    return (
        Placed(
            "lower_board",
            Plate(
                _slab(display.width, display.board_length, level.lower_board,
                      level.lower_board + thick),
                _holes(field, device.sleeve.outer_radius) + _holes(posts, spacer),
            ),
            origin,
        ),
        Placed(
            "upper_board",
            Plate(
                _slab(display.width, display.board_length, level.rod_top, level.rod_top + thick),
                windows=tuple((_mm(x - slot[0]), _mm(y - slot[1]), _mm(x + slot[0]),
                               _mm(y + slot[1])) for x, y in field),
            ),
            origin,
        ),
        Placed(
            "support_plate",
            Plate(
                _slab(display.width, display.length, support, level.support_top),
                windows=((-opening[0], -opening[1], opening[0], opening[1]),),
            ),
            origin,
        ),
    )  # fmt: skip


def _spacers(display: Display, level: Levels) -> tuple[Placed, ...]:
    radius, plate = 0.5 * display.spacer_diameter, display.plate_thickness
    posts = _upright(spacer_axes(display.width, display.board_length, display))
    inner = radius + _AROUND
    above_board = level.lower_board + display.board_thickness
    return (
        Placed("board_spacer", _tube(0.0, radius, plate, level.rod_top), posts),
        Placed(
            "adjusting_spring", _tube(inner, inner + _ENVELOPE, above_board, level.rod_top), posts
        ),
        Placed(
            "support_spacer",
            _tube(0.0, radius, plate, level.support_top - display.support_thickness),
            _upright(support_spacer_axes(display)),
        ),
    )


def _upright(positions: tuple[tuple[float, float], ...]) -> tuple[Place, ...]:
    return tuple((_mm(x), _mm(y), 0.0) for x, y in positions)


def _holes(
    positions: tuple[tuple[float, float], ...], radius: float
) -> tuple[tuple[float, float, float], ...]:
    return tuple((_mm(x), _mm(y), _mm(radius)) for x, y in positions)


def _slab(width: float, length: float, low: float, high: float) -> Box:
    return Box(
        (_mm(-0.5 * width), _mm(-0.5 * length), _mm(low)),
        (_mm(0.5 * width), _mm(0.5 * length), _mm(high)),
    )


def _tube(inner: float, outer: float, low: float, high: float) -> Part:
    corners = ((inner, low), (outer, low), (outer, high), (inner, high))
    return Part(Turned(tuple((_mm(r), _mm(z)) for r, z in corners)))


def _mm(length: float) -> float:
    return round(length * MM, _DIGITS) + 0.0


#: A draw farther out than this many deviations is not mounted.
_SORTED_OUT = 2.5
#: What is drawn of each unit, in this order: a key added at the end leaves the others' draws.
_DRAWN = (
    ("bimorph", "length", "length"),
    ("bimorph", "piezo_thickness", "thickness"),
    ("contact", "decay_length", "roughness"),
    ("spring", "preload", "preload"),
)


def drawn_units(device: Device, display: Display, scatter: Scatter) -> tuple[Device, ...]:
    """Device of each unit, row by row; the same seed gives the same units.

    Sizes are normally distributed about the device's; of a scatter of 0 none differs.  A larger
    display keeps the draws of the smaller one's first units.
    """
    found = []
    for number in range(display.rows * display.columns):
        draws = np.random.default_rng([scatter.seed, number]).standard_normal(len(_DRAWN))
        clipped = np.clip(draws, -_SORTED_OUT, _SORTED_OUT)
        unit = device
        for (group, name, deviation), draw in zip(_DRAWN, clipped.tolist(), strict=True):
            inner = getattr(unit, group)
            value = getattr(inner, name) * (1.0 + getattr(scatter, deviation) * draw)
            unit = unit.model_copy(update={group: inner.model_copy(update={name: value})})
        found.append(unit)
    return tuple(found)
