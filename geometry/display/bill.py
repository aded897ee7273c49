"""The bill of parts: each distinct part with count, material, volume and mass, in closed form.

Springs and windings are weighed by what is in their envelope: wire, and copper by its share.
Enamel, solder, traces and the threads' profile are left out.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from tactgen.geometry.device.parameters import Device, Display
from tactgen.geometry.device.parts import MM, Part, Turned, closed_form_volumes
from tactgen.geometry.device.winding import winding
from tactgen.geometry.display.clearances import spring_turns
from tactgen.geometry.display.layout import Plate, as_built, display_parts

#: Unworked end turns of a compression spring with closed ends.
_END_TURNS = 2.0
#: Steel of screws and springs (kg/m³).
_STEEL = 7850.0
#: What part of an adjusting spring's envelope is wire: stock springs, a wire of the envelope's
#: thickness wound with twice its pitch fills pi / 8 of it.
_WIRE_SHARE = math.pi / 8.0


@dataclass(frozen=True)
class Line:
    """One part in the bill: volume (m³) and mass (kg) are of one piece."""

    name: str
    count: int
    material: str
    volume: float
    mass: float

    @property
    def total_mass(self) -> float:
        """Of all pieces (kg)."""
        return self.count * self.mass


def bill_of_parts(device: Device, display: Display) -> tuple[Line, ...]:
    """Bill, the generators' own parts first.

    Raises InputError if the parts of a generator cannot be put together.
    """
    materials = _materials(device, display)
    volumes = closed_form_volumes(as_built(device, display), "rod")
    lines = []
    for placed in display_parts(device, display):
        name = placed.name
        material, density, share = materials[name]
        volume = volumes[name] if name in volumes else _volume(placed.body)
        if name == "return_spring":
            volume, share = _wire_volume(device, display), 1.0
        lines.append(Line(name, len(placed.places), material, volume, density * share * volume))
    return tuple(lines)


def total_mass(lines: tuple[Line, ...]) -> float:
    """Mass of all parts (kg)."""
    return sum(line.total_mass for line in lines)


def _materials(device: Device, display: Display) -> dict[str, tuple[str, float, float]]:
    """Material, density (kg/m³) and the share of the volume that it fills, by part."""
    ceramic = (device.piezo.material, device.piezo.ceramic().density, 1.0)
    steel = ("steel", device.rod.density, 1.0)
    hard = ("spring steel", _STEEL, 1.0)
    plate = ("polyoxymethylene", display.plate_density, 1.0)
    board = ("glass-fibre epoxy", display.board_density, 1.0)
    brass = ("brass", display.spacer_density, 1.0)
    return {
        "piezo_top": ceramic,
        "piezo_bottom": ceramic,
        "shim": (device.shim.material, device.shim.density, 1.0),
        "glue": ("glue", device.glue.density, 1.0),
        "rod": steel,
        "coil": ("copper wire", device.coil.copper_density, device.coil.fill_factor),
        "sleeve": steel,
        "return_spring": hard,
        "grub_screw": ("steel", _STEEL, 1.0),
        "ground_plate": plate,
        "lower_board": board,
        "upper_board": board,
        "support_plate": plate,
        "board_spacer": brass,
        "adjusting_spring": ("spring steel", _STEEL, _WIRE_SHARE),
        "support_spacer": brass,
    }


def _wire_volume(device: Device, display: Display) -> float:
    turns = spring_turns(device, display) + _END_TURNS
    section = 0.25 * math.pi * display.spring_wire**2
    return float(section * turns * math.pi * display.spring_diameter)


def _volume(body: Part | Plate) -> float:
    """Volume (m³) of a plate, or of a turned part without a cut."""
    if isinstance(body, Plate):
        dx, dy, height = (b - a for a, b in zip(body.body.low, body.body.high, strict=True))
        area = dx * dy - sum(math.pi * radius**2 for _, _, radius in body.holes)
        area -= sum((x1 - x0) * (y1 - y0) for x0, y0, x1, y1 in body.windows)
        return area * height / MM**3
    assert isinstance(body.body, Turned)
    assert body.cut is None
    corners = body.body.outline
    # Pappus by the shoelace: V = pi/3 sum (r1² + r1 r2 + r2²)(z2 - z1) round the outline
    volume = sum(
        (r1 * r1 + r1 * r2 + r2 * r2) * (z2 - z1)
        for (r1, z1), (r2, z2) in zip(corners, (*corners[1:], corners[0]), strict=True)
    )
    return math.pi / 3.0 * volume / MM**3


#: Vacuum's permittivity (F/m).
_EPS0 = 8.8541878128e-12
#: Enamelled over bare diameter of fine wire, grade 1 (IEC 60317-0-1: 0.03 mm wire is 0.038 mm).
_ENAMEL = 1.27
#: Leads of a coil.
_LEADS = 2


@dataclass(frozen=True)
class Wiring:
    """Room and need of leads."""

    channel: float  #: Width between two columns of slots in the upper board (m)
    #: In one channel, all layers together
    traces_fit: int
    traces_needed: int
    most_rows: int  #: Rows at which the channel would be full
    wire_diameter: float  #: Of the coils' enamelled wire (m)
    wire_gap: float  #: Between two sleeves (m)
    #: Side by side and on top of each other in one gap between sleeves; the innermost gap's need
    wires_fit: int
    wires_needed: int
    trace_length: float  #: Of the longest trace, from the field's middle to the board's edge (m)
    trace_capacitance: float  #: Of that trace to the shims' trace beside it (F)

    @property
    def fits(self) -> bool:
        """Whether all leads have room."""
        return self.traces_fit >= self.traces_needed and self.wires_fit >= self.wires_needed


def wiring(device: Device, display: Display) -> Wiring:
    """Wiring: leads needed and room on the boards."""
    thick = device.bimorph.thickness + 2.0 * display.slot_clearance
    channel = display.pitch - thick if display.columns > 1 else 0.5 * (display.width - thick)
    step = display.trace_width + display.trace_spacing
    per_layer = max(0, math.floor((channel - display.trace_spacing) / step + 1e-9))
    fit = per_layer * display.layers
    wire = _ENAMEL * winding(device.coil).wire_diameter
    gap = display.pitch - 2.0 * device.sleeve.outer_radius
    side, high = (math.floor(size / wire + 1e-9) for size in (gap, display.sleeve_protrusion))
    length = 0.5 * display.board_length
    return Wiring(
        channel=channel,
        traces_fit=fit,
        traces_needed=math.ceil(display.rows / 2) + 1,
        most_rows=max(0, 2 * (fit - 1)),
        wire_diameter=wire,
        wire_gap=gap,
        wires_fit=side * high,
        # half a row's coils leave at either side, each gap beside a row takes that row's
        wires_needed=_LEADS * math.ceil(display.columns / 2),
        trace_length=length,
        trace_capacitance=length * coplanar_capacitance(display),
    )


def coplanar_capacitance(display: Display) -> float:
    """Capacitance per length (F/m) of two traces beside each other on the board.

    C' = eps0 (1 + eps_r) / 2 · K(k') / K(k), k = s / (s + 2 w): two strips of width w at a
    distance s on a half space (C. R. Paul, Analysis of Multiconductor Transmission Lines).
    """
    from scipy.special import ellipk  # slow to import

    s, w = display.trace_spacing, display.trace_width
    square = (s / (s + 2.0 * w)) ** 2
    ratio = ellipk(1.0 - square) / ellipk(square)
    return float(_EPS0 * 0.5 * (1.0 + display.board_permittivity) * ratio)
