"""The display as CAD: each distinct solid built once and placed many times."""

from __future__ import annotations

from typing import TYPE_CHECKING

from tactgen.geometry.cad.solids import COLOURS, solid_of
from tactgen.geometry.cad.system_libraries import require_cad_kernel
from tactgen.geometry.device.parameters import Device, Display
from tactgen.geometry.display.clearances import check_display
from tactgen.geometry.display.layout import Placed, Plate, display_parts, unit_names

if TYPE_CHECKING:
    import cadquery as cq

#: Colour of each part of the display besides a generator's own (red, green, blue; 0 to 1).
DISPLAY_COLOURS: dict[str, tuple[float, float, float]] = {
    **COLOURS,
    "return_spring": (0.75, 0.77, 0.80),
    "grub_screw": (0.35, 0.36, 0.38),
    "ground_plate": (0.92, 0.91, 0.87),
    "lower_board": (0.12, 0.42, 0.25),
    "upper_board": (0.16, 0.50, 0.30),
    "support_plate": (0.86, 0.85, 0.80),
    "board_spacer": (0.80, 0.68, 0.34),
    "adjusting_spring": (0.70, 0.72, 0.75),
    "support_spacer": (0.80, 0.68, 0.34),
}


def display_assembly(device: Device, display: Display) -> cq.Assembly:
    """Display; copies of a part share one solid (mm).

    Raises InputError if parts do not fit, or the CAD kernel's system library is missing.
    """
    check_display(device, display)
    require_cad_kernel()
    import cadquery as cq

    assembly = cq.Assembly(name="tactile_display")
    units = unit_names(display)
    for placed in display_parts(device, display):
        solid = _solid(placed)
        colour = cq.Color(*DISPLAY_COLOURS[placed.name], 1.0)
        of_unit = len(placed.places) == len(units) and placed.places[0] != (0.0, 0.0, 0.0)
        for number, place in enumerate(placed.places):
            suffix = units[number] if of_unit else str(number + 1)
            name = f"{placed.name}_{suffix}" if len(placed.places) > 1 else placed.name
            assembly.add(solid, name=name, color=colour, loc=cq.Location(cq.Vector(*place)))
    return assembly


def display_solids(device: Device, display: Display) -> dict[str, cq.Shape]:
    """Each distinct solid of the display in its own frame (mm)."""
    check_display(device, display)
    require_cad_kernel()
    return {placed.name: _solid(placed) for placed in display_parts(device, display)}


def _solid(placed: Placed) -> cq.Shape:
    body = placed.body
    return _plate(body) if isinstance(body, Plate) else solid_of(body)


def _plate(plate: Plate) -> cq.Shape:
    """Plate as one extrusion of its outline with everything that goes through it."""
    import cadquery as cq

    (x0, y0, z0), (x1, y1, z1) = plate.body.low, plate.body.high
    outer = _rectangle((x0, y0, x1, y1), z0)
    inner = [_rectangle(window, z0) for window in plate.windows]
    inner += [
        cq.Wire.makeCircle(r, cq.Vector(x, y, z0), cq.Vector(0, 0, 1)) for x, y, r in plate.holes
    ]
    return cq.Solid.extrudeLinear(outer, inner, cq.Vector(0, 0, z1 - z0))


def _rectangle(corners: tuple[float, float, float, float], z: float) -> cq.Wire:
    import cadquery as cq

    x0, y0, x1, y1 = corners
    points = [cq.Vector(x, y, z) for x, y in ((x0, y0), (x1, y0), (x1, y1), (x0, y1))]
    return cq.Wire.makePolygon(points, close=True)
