"""Pictures of the generator in motion: the body enlarged, and its curves with the instant on them.

Lift and lateral motion differ by an order of magnitude, so each has a factor of its own, which the
picture says.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from tactgen.geometry.arrays import Floats
from tactgen.geometry.meshing.mesh import surface_of
from tactgen.validation.show.fields.moving import MovingBody
from tactgen.validation.show.pictures import off_screen
from tactgen.validation.show.shading import COLOURS
from tactgen.validation.show.stills import surface_part, typeface

if TYPE_CHECKING:
    from PIL.Image import Image
import io
from collections.abc import Iterator
from pathlib import Path

from tactgen.validation.models.generator.transient import Simulation, phases
from tactgen.validation.show.field_files import write_steps
from tactgen.validation.show.fields.gather import body_of
from tactgen.validation.show.fields.result import Array
from tactgen.validation.show.stills import save_film

#: Width and height of the body's picture and the width of the curves beside it (pixels).
_BODY, _HEIGHT, _CURVES = 400, 640, 400
#: Part of the body's height that the largest lateral motion and the largest lift are drawn as.
_FAR, _LIFTED = 0.12, 0.06
_EYE, _UP = np.array([0.45, -1.0, 0.3]), (0.0, 0.0, 1.0)
_INK, _DIM, _LINE = (29, 39, 51), (91, 103, 118), (0, 114, 178)
_MM = 1e3
#: What a phase's name says of the contact.
CONTACTS = {
    "pressed": "on its upper stop", "held": "on its lower stop",
    "rising": "between the stops, rising", "falling": "between the stops, falling",
}  # fmt: skip


@dataclass(frozen=True)
class Instant:
    """A run at one time: s, coordinates, lift and tip (m), coil current (A), phase."""

    time: float
    position: Floats
    lift: float
    tip: float
    current: float
    phase: str


def run_frames(
    body: MovingBody, instants: Sequence[Instant], announce: Callable[[str], None] = lambda _: None
) -> list[Image]:
    """Picture for each instant, all to one scale.

    Raises InputError if the system has no OpenGL library.
    """
    stage = _Stage(body, instants)
    made = []
    for number, instant in enumerate(instants, start=1):
        announce(f"picture {number} of {len(instants)}")
        made.append(_picture(stage, instants, instant))
    stage.close()
    return made


def run_still(body: MovingBody, instants: Sequence[Instant]) -> Image:
    """One picture of a run on which the tip is farthest out.

    Raises InputError if the system has no OpenGL library.
    """
    stage = _Stage(body, instants)
    image = _picture(stage, instants, max(instants, key=lambda instant: abs(instant.tip)))
    stage.close()
    return image


def _picture(stage: _Stage, instants: Sequence[Instant], now: Instant) -> Image:
    from PIL import Image as Images

    image = Images.new("RGB", (_BODY + _CURVES, _HEIGHT), "white")
    image.paste(Images.fromarray(stage.shot(now)), (0, 0))
    _words(image, stage, instants, now)
    return image


class _Stage:
    """The off-screen scene; only points change from picture to picture."""

    def __init__(self, body: MovingBody, instants: Sequence[Instant]) -> None:
        pv = off_screen()
        self._body, points = body, body.mesh.points
        height = float(np.ptp(points[:, 2]))
        moved = [body.displacement(i.position) for i in instants]
        lifts = max(abs(i.lift) for i in instants)
        sideways = max(float(np.abs(m[:, 0]).max()) for m in moved)
        self.lateral, self.axial = enlargements(height, sideways, lifts)
        surface = surface_of(body.mesh)
        self._plotter = pv.Plotter(
            off_screen=True, window_size=(_BODY, _HEIGHT), lighting="three lights"
        )
        self._plotter.set_background("white")
        self._plotter.enable_anti_aliasing("ssaa")
        self._parts: list[Any] = []
        for number, region in enumerate(body.mesh.regions):
            chosen = surface.triangles[surface.region_of_triangle == number]
            part = surface_part(pv, points * _MM, chosen)
            self._plotter.add_mesh(part, color=COLOURS.get(region, "silver"))
            self._parts.append(part)
        self._look(points * _MM)

    def _look(self, points: Floats) -> None:
        camera, low, high = self._plotter.camera, points.min(axis=0), points.max(axis=0)
        middle, tall = 0.5 * (low + high), float(np.ptp(points[:, 2]))
        away = _EYE / np.linalg.norm(_EYE)
        camera.focal_point = tuple(middle)
        camera.position = tuple(middle + 4.0 * tall * away)
        camera.up = _UP
        camera.parallel_projection = True
        camera.parallel_scale = 0.5 * tall * (1.15 + 2.0 * _LIFTED)
        self._plotter.renderer.ResetCameraClippingRange()

    def shot(self, instant: Instant) -> Any:
        """Picture (height, width, 3) at an instant."""
        moved = self._body.displacement(instant.position)
        # the turning of sections goes with the lateral motion, so that they stay square to it
        turned = moved[:, 2] - instant.lift
        up = self.axial * instant.lift + self.lateral * turned
        drawn = np.stack([self.lateral * moved[:, 0], 0.0 * up, up], axis=1)
        for part in self._parts:
            part.points = (self._body.mesh.points + drawn) * _MM
        self._plotter.render()
        return self._plotter.screenshot(return_img=True)

    def close(self) -> None:
        """Let go of the off-screen window."""
        self._plotter.close()


def enlargements(height: float, sideways: float, lift: float) -> tuple[float, float]:
    """By how much lateral motion and lift are enlarged in a picture of a body.

    Parameters
    ----------
    height : float
        Of the body (m).
    sideways, lift : float
        The largest of a run (m).
    """
    return _round(_FAR * height / max(sideways, 1e-9)), _round(_LIFTED * height / max(lift, 1e-9))


def _round(factor: float) -> float:
    """Factor rounded down to one digit that is easily read: 1, 2 or 5."""
    power = 10.0 ** np.floor(np.log10(factor))
    return float(max(n * power for n in (1.0, 2.0, 5.0) if n * power <= factor))


def _words(image: Image, stage: _Stage, instants: Sequence[Instant], now: Instant) -> None:
    """Write what is seen, and draw the curves with a mark at the instant."""
    from PIL import ImageDraw, ImageFont

    draw = ImageDraw.Draw(image)
    font, small = (ImageFont.truetype(typeface(), size) for size in (18, 14))
    left, right = _BODY + 20, _BODY + _CURVES - 20
    draw.text((left, 20), f"{1e3 * now.time:.2f} ms", fill=_INK, font=font)
    draw.text((left, 46), f"rod {CONTACTS[now.phase]}", fill=_INK, font=font)
    factors = f"lateral × {stage.lateral:,.0f}, lift × {stage.axial:,.0f}"
    draw.text((left, 74), factors, fill=_DIM, font=small)
    curves = (
        ("rod, µm", [1e6 * i.lift for i in instants], 1e6 * now.lift),
        ("tip, lateral, µm", [1e6 * i.tip for i in instants], 1e6 * now.tip),
        ("coil current, mA", [1e3 * i.current for i in instants], 1e3 * now.current),
    )
    tall, until = 165, instants[-1].time or 1.0
    for number, (title, values, value) in enumerate(curves):
        top = 110 + number * tall
        draw.text((left, top), f"{title}: {value:.3g}", fill=_INK, font=small)
        low, high = min(values), max(values)
        span = (high - low) or 1.0
        above, below = top + 24, top + tall - 24

        def at(time: float, v: float, above: int = above, below: int = below,
               low: float = low, span: float = span) -> tuple[float, float]:  # fmt: skip
            return left + (right - left) * time / until, below - (below - above) * (v - low) / span

        draw.line((left, below + 4, right, below + 4), fill=_DIM)
        draw.line(
            [at(i.time, v) for i, v in zip(instants, values, strict=True)], fill=_LINE, width=2
        )
        x, y = at(now.time, value)
        draw.line((x, above, x, below), fill=_DIM)
        draw.ellipse((x - 4, y - 4, x + 4, y + 4), fill=_INK)
        draw.text((left, below + 6), f"{low:.3g} to {high:.3g}", fill=_DIM, font=small)


#: Pictures of a film, and milliseconds that each is shown; time steps in a file.
_FRAMES, _SHOWN, _STEPS = 150, 60, 150


def write_run_film(
    path: Path, found: Simulation, announce: Callable[[str], None] = lambda _: None
) -> None:
    """Write a run as a film, by its suffix a .gif or .mp4, whole or not at all.

    Raises InputError if it cannot be made or written.
    """
    images = run_frames(body_of(found), list(_instants(found, _FRAMES)), announce)
    save_film(path, images, _SHOWN)


def still_of_run(found: Simulation) -> bytes:
    """Run as one picture (PNG), with its curves.

    Raises InputError if it cannot be made.
    """
    buffer = io.BytesIO()
    run_still(body_of(found), list(_instants(found, _FRAMES))).save(buffer, "PNG", optimize=True)
    return buffer.getvalue()


def write_run_steps(path: Path, found: Simulation) -> None:
    """Write a run as a .pvd of time steps in s: displacement at the points of what moves.

    Raises InputError if it cannot be written.
    """
    body = body_of(found)

    def at(instant: Instant) -> tuple[float, dict[str, Array]]:
        return instant.time, {"displacement (m)": body.displacement(instant.position)}

    write_steps(path, path.stem, body.mesh, map(at, _instants(found, _STEPS)))


def _instants(found: Simulation, count: int) -> Iterator[Instant]:
    """Yield the run at times evenly spaced from its start to its end."""
    run, outputs = found.answer.run, found.answer.outputs
    named = phases(found)
    for time in np.linspace(0.0, run.time[-1], count):
        position: Floats = np.array([np.interp(time, run.time, x) for x in run.position.T])
        phase = next((p.name for p in named if time <= p.end), named[-1].name)
        yield Instant(
            time=float(time),
            position=position,
            lift=float(np.interp(time, run.time, outputs["rod_lift"])),
            tip=float(np.interp(time, run.time, outputs["lateral_tip"])),
            current=float(np.interp(time, run.time, run.current)),
            phase=phase,
        )
