"""Room for the leads of 16 + 16 channels: how many traces fit, how many are needed, what they add.

The upper board carries the bimorphs' leads.  Between two columns of slots is a channel along y;
each unit's driven electrode has a trace of its own, to the nearer end, and all shims share one
trace a channel.  The coils' leads are wires that run above the lower board between the sleeves,
to pads outside the field: between neighbouring holes no trace fits.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from tactgen.geometry.device.parameters import Device, Display
from tactgen.geometry.device.winding import winding

#: Vacuum's permittivity (F/m).
_EPS0 = 8.8541878128e-12
#: Enamelled over bare diameter of fine wire, grade 1 (IEC 60317-0-1: 0.03 mm wire is 0.038 mm).
_ENAMEL = 1.27
#: Leads of a coil.
_LEADS = 2


@dataclass(frozen=True)
class Wiring:
    """Room and need of leads.

    Attributes
    ----------
    channel : float
        Width between two columns of slots in the upper board (m).
    traces_fit, traces_needed : int
        In one channel, all layers together.
    most_rows : int
        Rows at which the channel would be full.
    wire_diameter : float
        Of the coils' enamelled wire (m).
    wire_gap : float
        Between two sleeves (m).
    wires_fit, wires_needed : int
        Side by side and on top of each other in one gap between sleeves; the innermost gap's need.
    trace_length : float
        Of the longest trace, from the field's middle to the board's edge (m).
    trace_capacitance : float
        Of that trace to the shims' trace beside it (F).
    """

    channel: float
    traces_fit: int
    traces_needed: int
    most_rows: int
    wire_diameter: float
    wire_gap: float
    wires_fit: int
    wires_needed: int
    trace_length: float
    trace_capacitance: float

    @property
    def fits(self) -> bool:
        """Whether all leads have room."""
        return self.traces_fit >= self.traces_needed and self.wires_fit >= self.wires_needed


def wiring(device: Device, display: Display) -> Wiring:
    """Return what the boards have room for and what the display needs."""
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
    """Return the capacitance per length (F/m) of two traces beside each other on the board.

    C' = eps0 (1 + eps_r) / 2 · K(k') / K(k), k = s / (s + 2 w): two strips of width w at a
    distance s on a half space (C. R. Paul, Analysis of Multiconductor Transmission Lines).
    """
    s, w = display.trace_spacing, display.trace_width
    k = s / (s + 2.0 * w)
    ratio = _quarter_period(math.sqrt(1.0 - k * k)) / _quarter_period(k)
    return float(_EPS0 * 0.5 * (1.0 + display.board_permittivity) * ratio)


def _quarter_period(modulus: float) -> float:
    """Return the complete elliptic integral K by the arithmetic-geometric mean."""
    a, b = 1.0, math.sqrt(1.0 - modulus * modulus)
    while abs(a - b) > 1e-15 * a:
        a, b = 0.5 * (a + b), math.sqrt(a * b)
    return math.pi / (a + b)
