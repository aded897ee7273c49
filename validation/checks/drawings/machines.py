"""The devices of this suite, and the simple machines that its motions are held against."""

from __future__ import annotations

from typing import TYPE_CHECKING

from tactgen.geometry.reluctance import team20
from tactgen.validation.checks.drawings.bodies import ellipse, rings
from tactgen.validation.checks.drawings.drawing import Area, Drawing, Line, Mark, Point, rectangle
from tactgen.validation.checks.drawings.strips import Root, strip

if TYPE_CHECKING:
    from tactgen.geometry.device.parameters import Device
    from tactgen.validation.scene.scene import Scene

_MM = 1e3
#: A winding around the left leg, from 0 to 1, of a core without a size.
_ON_THE_LEG = (
    rectangle((-0.5, 1.2), (0.0, 2.8), "winding"),
    rectangle((1.0, 1.2), (1.5, 2.8), "winding"),
)


def bimorph(scene: str, *, root: Root, finger: str = "") -> Drawing:
    """Return a built-in scene's bimorph from the side; `finger` names what its tip touches."""
    body = _scene(scene).device.bimorph
    piezo, shim = body.piezo_thickness * _MM, body.shim_thickness * _MM
    layers = (("piezo", piezo), ("shim", shim), ("piezo", piezo))
    length, height = body.length * _MM, 2.0 * piezo + shim
    touched = Mark("mass", (length, 0.5 * height), 90.0, finger)
    return strip(length, layers, root=root, tip=(touched,) if finger else ())


def actuator(device: Device | None = None, gap: float | None = None) -> Drawing:
    """Return a normal actuator's half section at a gap (m): the built-in one, or another."""
    from tactgen.geometry.reluctance.section_grid import actuator_regions

    body = _scene("reluctance").device if device is None else device
    return rings(actuator_regions(body, body.gap if gap is None else gap))


def collared_actuator() -> Drawing:
    """Return the half section of the actuator with a collar that was solved elsewhere."""
    from tactgen.validation.checks.cases.magnetics.collared_actuator import COLLARED, GAP

    return actuator(COLLARED, GAP)


def ring_coils() -> Drawing:
    """Return the half section of the two ring coils in air."""
    from tactgen.validation.checks.cases.magnetics.coaxial_coils import HIGH, LOW

    return rings((LOW, HIGH))


def solenoid() -> Drawing:
    """Return the half section of the endless solenoid with its core."""
    from tactgen.validation.checks.cases.magnetics.infinite_solenoid import CORE, INNER, OUTER

    spans = ((0.0, CORE, "core"), (INNER, OUTER, "winding"))
    areas = tuple(rectangle((r0 * _MM, -20.0), (r1 * _MM, 20.0), name) for r0, r1, name in spans)
    axis = Line(((0.0, -20.0), (0.0, 20.0)), "axis")
    return Drawing(areas, (axis,), (), ("r (mm)", "z"))


def conductors() -> Drawing:
    """Return two long strips whose currents run against each other, from their ends."""
    from tactgen.validation.checks.cases.magnetics.long_conductors import APART, TALL, THICK

    areas = tuple(
        rectangle(
            ((side * 0.5 * APART - 0.5 * THICK) * _MM, -0.5 * TALL * _MM),
            ((side * 0.5 * APART + 0.5 * THICK) * _MM, 0.5 * TALL * _MM),
            name,
        )
        for side, name in ((-1, "current away"), (1, "current back"))
    )
    return Drawing(areas, (), (), ("x (mm)", "y (mm)"))


def team_20() -> Drawing:
    """Return the section of TEAM problem 20 through the middle of pole, coil and yoke."""
    x, _, bottom, top = team20.POLE
    wide, _, low, high = team20.YOKE
    window, sill, lintel = team20.WINDOW
    yoke = [
        rectangle((-wide, low), (wide, sill), "yoke"),
        *(rectangle(*_either(side, window, wide, sill, high), "yoke") for side in (-1, 1)),
        *(rectangle(*_either(side, team20.SLOT, window, lintel, high), "yoke") for side in (-1, 1)),
    ]
    coil = [
        rectangle(
            *_either(side, team20.INSIDE, team20.OUTSIDE, team20.COIL_BOTTOM, team20.COIL_TOP),
            "winding",
        )
        for side in (-1, 1)
    ]
    pole = rectangle((-x, bottom), (x, top), "pole")
    pull = Mark("force", (0.0, bottom), -90.0)
    return Drawing((*yoke, *coil, pole), (), (pull,), ("x (mm)", "z (mm)"))


def _either(side: int, inner: float, outer: float, low: float, high: float) -> tuple[Point, Point]:
    """Return two corners of a rectangle on one side of the middle."""
    return (side * inner, low), (side * outer, high)


def core() -> Drawing:
    """Return a closed core with a winding on one leg, without a size."""
    outer, inner = ((0.0, 0.0), (4.0, 4.0)), ((1.0, 1.0), (3.0, 3.0))
    (x0, y0), (x1, y1) = outer
    (a0, b0), (a1, b1) = inner
    frame = (
        rectangle((x0, y0), (x1, b0), "iron"), rectangle((x0, b1), (x1, y1), "iron"),
        rectangle((x0, b0), (a0, b1), "iron"), rectangle((a1, b0), (x1, b1), "iron"),
    )  # fmt: skip
    return Drawing((*frame, *_ON_THE_LEG))


def ideal_gap() -> Drawing:
    """Return a yoke without resistance, a rod across a gap, and the spring that holds it."""
    yoke = (
        rectangle((0.0, 0.0), (1.0, 4.0), "iron"), rectangle((1.0, 0.0), (4.0, 1.0), "iron"),
        rectangle((1.0, 3.0), (2.2, 4.0), "iron"),
    )  # fmt: skip
    rod = rectangle((3.0, 1.6), (4.0, 3.0), "iron, moves")
    spring = Line(((3.5, 3.0), (3.5, 4.6)), "spring")
    wall = Line(((4.2, 4.6), (2.8, 4.6)), "held")
    gap = Mark("text", (4.0, 1.3), 0.0, "gap")
    return Drawing((*yoke, rod, *_ON_THE_LEG), (spring, wall), (gap,))


def oscillator(*, law: str, drive: str = "P cos Ωt") -> Drawing:
    """Return a mass between a wall with spring, law and damper and the force that drives it."""
    mass = rectangle((2.0, 0.0), (3.2, 2.0), "mass")
    wall = Line(((0.0, 2.2), (0.0, -0.2)), "held")
    return Drawing(
        (mass,),
        (wall, Line(((0.0, 1.4), (2.0, 1.4)), "spring"), Line(((0.0, 0.5), (2.0, 0.5)), "damper")),
        (Mark("text", (1.0, 1.55), 90.0, law), Mark("force", (3.2, 1.0), 180.0, drive)),
    )


def rocking_head() -> Drawing:
    """Return the head that is pressed on its stop and may rock, with the bimorph on it."""
    stop = (
        rectangle((-1.6, -1.0), (-0.5, 0.0), "stop"),
        rectangle((0.5, -1.0), (1.6, 0.0), "stop"),
    )
    head = rectangle((-1.2, 0.0), (1.2, 0.5), "head, moves")
    rod = rectangle((-0.4, -1.6), (0.4, 0.0), "head, moves")
    blade = rectangle((-0.12, 0.5), (0.12, 4.0), "bimorph")
    return Drawing(
        (*stop, head, rod, blade),
        (),
        (
            Mark("force", (0.0, -2.4), 90.0, "pressed"),
            Mark("turning spring", (0.0, 0.1), text="rocks"),
            Mark("force", (0.6, 4.0), 0.0, "bends"),
        ),
    )


def display(rows: int, columns: int, *, driven: bool = False) -> Drawing:
    """Return so many heads of the display from above, at its pitch; perhaps one of them driven."""
    from tactgen.geometry.display.layout import axes

    device, whole = _scene("display").device, _scene("display").display
    places = axes(whole.model_copy(update={"rows": rows, "columns": columns}))
    half, body = device.rod.head_radius * _MM, device.bimorph
    middle = len(places) // 2
    wide, thick = body.width * _MM, (2.0 * body.piezo_thickness + body.shim_thickness) * _MM
    heads, blades = [], []
    for at, (x, y) in enumerate((x * _MM, y * _MM) for x, y in places):
        outline = ellipse(half, half, centre=(x, y))
        heads.append(Area(outline, "head, driven" if driven and at == middle else "head"))
        corners = (x - 0.5 * thick, y - 0.5 * wide), (x + 0.5 * thick, y + 0.5 * wide)
        blades.append(rectangle(*corners, "bimorph"))
    return Drawing((*heads, *blades), (), (), ("x (mm)", "y (mm)"))


def stack() -> Drawing:
    """Return the display's heights: what stands on what, from the ground plate to the tips."""
    from tactgen.geometry.display.layout import levels

    device, whole = _scene("display").device, _scene("display").display
    level = levels(device, whole)
    parts = (
        ("ground plate", 0.0, whole.plate_thickness),
        ("sleeves", level.sleeve_bottom, level.sleeve_top),
        ("lower board", level.lower_board, level.lower_board + whole.board_thickness),
        ("bimorphs", level.rod_top, level.tip),
    )
    widths = (1.0, 0.5, 0.9, 0.25)
    areas = tuple(
        rectangle(
            (-0.5 * share * whole.width * _MM, low * _MM),
            (0.5 * share * whole.width * _MM, high * _MM),
            name,
        )
        for (name, low, high), share in zip(parts, widths, strict=True)
    )
    top = Line(
        tuple((side * 0.5 * whole.width * _MM, level.support_top * _MM) for side in (-1, 1)),
        "division",
    )
    return Drawing(areas, (top,), (), ("", "z (mm)"))


def _scene(name: str) -> Scene:
    from tactgen.validation.scene.scene import load_scene

    return load_scene(name)[0]
