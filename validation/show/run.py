"""A run in time: its page with a slider and curves, films, a still, time steps for ParaView.

Lift and lateral motion differ by an order of magnitude, so each is drawn with a factor of its own,
which the picture says.
"""

from __future__ import annotations

import html
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from tactgen.geometry.arrays import Floats, Ints
from tactgen.geometry.cad.solids import colour_of
from tactgen.geometry.device.parts import MM
from tactgen.geometry.meshing.mesh import surface_of
from tactgen.validation.models.transient import Simulation, phases
from tactgen.validation.show.field import Array
from tactgen.validation.show.field_files import write_steps
from tactgen.validation.show.gather import body_of
from tactgen.validation.show.generator_body import MovingBody
from tactgen.validation.show.page import asset, data_script, document, library
from tactgen.validation.show.pictures import DIM, INK, Stage, as_png, fonts, save_film
from tactgen.validation.show.viewer import Block

if TYPE_CHECKING:
    from PIL.Image import Image

#: Width and height of the body's picture and the width of the curves beside it (pixels).
_BODY, _HEIGHT, _CURVES = 400, 640, 400
#: Part of the body's height that the largest lateral motion and the largest lift are drawn as.
_FAR, _LIFTED = 0.12, 0.06
_EYE, _UP = np.array([0.45, -1.0, 0.3]), (0.0, 0.0, 1.0)
_LINE = (0, 114, 178)
#: What a phase's name says of the contact.
CONTACTS = {
    "pressed": "on its upper stop", "held": "on its lower stop",
    "rising": "between the stops, rising", "falling": "between the stops, falling",
}  # fmt: skip
#: Pictures of a film, and milliseconds that each is shown; time steps in a file.
_FRAMES, _SHOWN, _STEPS = 150, 60, 150


def write_run_film(
    path: Path, found: Simulation, announce: Callable[[str], None] = lambda _: None
) -> None:
    """Write a run as a film, by its suffix a .gif or .mp4, whole or not at all."""
    stage = _RunStage(found)
    save_film(path, stage.images(range(_FRAMES), stage.picture_at, announce), _SHOWN)


def still_of_run(found: Simulation) -> bytes:
    """Picture (PNG) at the instant at which the tip is farthest out, with the curves."""
    stage = _RunStage(found)
    farthest = int(np.abs(stage.tip).argmax())
    return as_png(stage.images([farthest], stage.picture_at, lambda _: None)[0])


def write_run_steps(path: Path, found: Simulation) -> None:
    """Write a run as a .pvd of time steps (s) with displacements."""
    body, run = body_of(found), found.answer.run
    times = np.linspace(0.0, run.time[-1], _STEPS)
    steps: Iterable[tuple[float, dict[str, Array]]] = (
        (time, {"displacement (m)": body.displacement(position)})
        for time, position in zip(times, _columns_at(times, run.time, run.position), strict=True)
    )
    write_steps(path, path.stem, body.mesh, steps)


def _columns_at(at: Floats, time: Floats, values: Floats) -> Floats:
    """Values (n, c) at some times from those (k, c) at others."""
    return np.array([np.interp(at, time, column) for column in values.T]).T


class _RunStage(Stage):
    """The scene of a run at evenly spaced times; only points change from picture to picture."""

    def __init__(self, found: Simulation) -> None:
        super().__init__(_BODY, _HEIGHT)
        self._body: MovingBody = body_of(found)
        self.place = found.scene.measurement.place
        run, outputs = found.answer.run, found.answer.outputs
        self.time = np.linspace(0.0, run.time[-1], _FRAMES)
        read = (outputs["rod_lift"], outputs["lateral_tip"], run.current)
        self.lift, self.tip, self.current = (np.interp(self.time, run.time, v) for v in read)
        position = _columns_at(self.time, run.time, run.position)
        named = phases(found)
        after = np.searchsorted([phase.end for phase in named], self.time)
        self.contacts = [CONTACTS[named[min(k, len(named) - 1)].name] for k in after]
        mesh = self._body.mesh
        low, high = mesh.points.min(axis=0) * MM, mesh.points.max(axis=0) * MM
        self._moved = [self._body.displacement(own) for own in position]
        self.lateral, self.axial = enlargements(
            float(np.ptp(mesh.points[:, 2])),
            max(float(np.abs(moved[:, 0]).max()) for moved in self._moved),
            float(np.abs(self.lift).max()),
        )
        surface = surface_of(mesh)
        self._parts: list[Any] = []
        for number, region in enumerate(mesh.regions):
            chosen = surface.triangles[surface.region_of_triangle == number]
            part = self.surface(mesh.points * MM, chosen)
            self.plotter.add_mesh(part, color=colour_of(region))
            self._parts.append(part)
        tall = float(high[2] - low[2])
        self.look_at(
            0.5 * (low + high), 4.0 * tall * _EYE / np.linalg.norm(_EYE), _UP,
            0.5 * tall * (1.15 + 2.0 * _LIFTED),
        )  # fmt: skip

    def picture_at(self, k: int) -> Image:
        """The body at the k-th time, and the curves with a mark on them."""
        from PIL import Image as Images

        moved, lift = self._moved[k], self.lift[k]
        # the turning of sections goes with the lateral motion, so that they stay square to it
        up = self.axial * lift + self.lateral * (moved[:, 2] - lift)
        drawn = np.stack([self.lateral * moved[:, 0], 0.0 * up, up], axis=1)
        for part in self._parts:
            part.points = (self._body.mesh.points + drawn) * MM
        image = Images.new("RGB", (_BODY + _CURVES, _HEIGHT), "white")
        image.paste(self.image(), (0, 0))
        _words(image, self, k)
        return image


def enlargements(height: float, sideways: float, lift: float) -> tuple[float, float]:
    """Factors of lateral motion and lift in a picture, from their largest and the height (m)."""
    return _round(_FAR * height / max(sideways, 1e-9)), _round(_LIFTED * height / max(lift, 1e-9))


def _round(factor: float) -> float:
    """Factor rounded down to one digit that is easily read: 1, 2 or 5."""
    power = 10.0 ** np.floor(np.log10(factor))
    return float(max(n * power for n in (1.0, 2.0, 5.0) if n * power <= factor))


def _words(image: Image, stage: _RunStage, k: int) -> None:
    """Write the view, and draw the curves with a mark at the k-th time."""
    from PIL import ImageDraw

    draw = ImageDraw.Draw(image)
    font, small = fonts(18, 14)
    left, right = _BODY + 20, _BODY + _CURVES - 20
    draw.text((left, 20), f"{1e3 * stage.time[k]:.2f} ms", fill=INK, font=font)
    draw.text((left, 46), f"rod {stage.contacts[k]}", fill=INK, font=font)
    factors = f"lateral × {stage.lateral:,.0f}, lift × {stage.axial:,.0f}"
    draw.text((left, 74), factors, fill=DIM, font=small)
    curves = (
        ("rod, µm", 1e6 * stage.lift),
        (f"{stage.place}, lateral, µm", 1e6 * stage.tip),
        ("coil current, mA", 1e3 * stage.current),
    )
    tall, until = 165, float(stage.time[-1]) or 1.0
    for number, (title, values) in enumerate(curves):
        top = 110 + number * tall
        draw.text((left, top), f"{title}: {values[k]:.3g}", fill=INK, font=small)
        low, high = float(values.min()), float(values.max())
        above, below = top + 24, top + tall - 24
        x = left + (right - left) * stage.time / until
        y = below - (below - above) * (values - low) / ((high - low) or 1.0)
        draw.line((left, below + 4, right, below + 4), fill=DIM)
        draw.line(np.stack([x, y], axis=1).ravel().tolist(), fill=_LINE, width=2)
        draw.line((x[k], above, x[k], below), fill=DIM)
        draw.ellipse((x[k] - 4, y[k] - 4, x[k] + 4, y[k] + 4), fill=INK)
        draw.text((left, below + 6), f"{low:.3g} to {high:.3g}", fill=DIM, font=small)


#: Instants of a page at most, evenly spaced; between them the page takes straight lines.
_MOST = 2000
#: Force on a stop (N) from which on the page says that the head touches it.
_TOUCH = 1e-3


@dataclass(frozen=True)
class Film:
    """A run as it is seen."""

    scene: str  #:
    time: Floats  #: (k,) s, from 0; a time at which a source jumps appears twice
    coordinates: Floats  #: (k, c) What the body follows, the lift first
    #: (n, 3) The body's surface at rest (m), z = 0 at the face of the rod's head
    points: Floats
    triangles: Ints
    regions: tuple[str, ...]
    region_of_triangle: Ints
    #: (n, c) Displacement along x and z per coordinate
    lateral: Floats
    axial: Floats
    #: By title: values, unit to be shown, and that unit over SI
    curves: dict[str, tuple[Floats, str, float]]
    forces: tuple[Floats, Floats]  #: ((k,) Of the upper and the lower stop on the head (N)
    phase: Ints  #: (k,) Of :data:`PHASES`
    #: Way between the stops, and radius of the head (m)
    stroke: float
    rim: float
    words: str  #: How far the run can be trusted


#: Names of the phases by number.
PHASES = tuple(CONTACTS)

_STAGE = (
    '<div class="tr-now"><b class="tr-clock"></b><br><span class="tr-state"></span></div>'
    '<p class="tr-none" hidden>WebGL 2 is not available here, so the body is not drawn; curves and '
    "numbers follow the slider.</p><noscript>Scripts are off, so nothing is shown here.</noscript>"
    '<div class="tr-note">circles: where the face of the rod\'s head is on its upper and its lower '
    "stop, orange while it is pressed</div>"
)
_PANEL = (
    '<button class="tr-play" type="button"></button>'
    '<label><span>time</span><input class="tr-time" type="range" min="0" step="any" value="0">'
    "</label>"
    '<label><span>speed</span><select class="tr-speed">'
    + "".join(
        f'<option value="{speed}"{" selected" if speed == "1" else ""}>{speed} ms a second</option>'
        for speed in ("0.03", "0.1", "0.3", "1", "3", "10")
    )
    + "</select></label>"
    '<label><span>lateral</span><input class="tr-lateral" type="range" min="-1" max="0.5" '
    'step="0.01" value="0"><output class="tr-lateral-by"></output></label>'
    '<label><span>lift</span><input class="tr-lift" type="range" min="-1" max="0.5" step="0.01" '
    'value="0"><output class="tr-lift-by"></output></label>'
    '<div class="tr-buttons"><button type="button" data-from="0.45 -1 0.3">oblique</button>'
    '<button type="button" data-from="0 -1 0">front</button>'
    '<button type="button" data-from="1 0 0">side</button></div>'
    '<table class="tr-values"></table><div class="tr-legend"></div>'
)
_HELP = (
    '<p class="tr-help">Space plays, arrows step, a curve takes the time where it is pressed. Drag '
    "turns, wheel zooms. An address that ends in #5.2ms opens there.</p>"
)


def run_page(film: Film) -> str:
    """Page: HTML that holds all it needs."""
    body = library() + fragment(film)
    head = "<style>html,body{margin:0;height:100%}.tr{height:100vh;min-height:40rem}</style>\n"
    return document(f"{film.scene}: a run in time", head, f"<main>{body}</main>\n")


def fragment(film: Film, *, within: bool = False) -> str:
    """Run as a part of a page that has the :func:`library`.

    `within` a page that is about more it stays light, waits to be played, and takes only the keys
    that are meant for it.
    """
    title = f"{html.escape(film.scene)} in time"
    title = f"<h3>{title}</h3>" if within else f"<h1>{title}</h1>"
    return (
        f"<style>{asset('run.css')}</style>\n"
        f"{data_script('tr-data', film_payload(film))}\n"
        f'<div class="tr{" tr-within" if within else ""}"><div class="tr-stage">{_STAGE}</div>\n'
        f'<div class="tr-panel">{title}{_PANEL}'
        f'<p class="tr-help">{html.escape(film.words)}</p>{_HELP}</div>\n'
        f'<div class="tr-curves"><div class="tr-rows"></div><div class="tr-axis"><span>0</span>'
        f"<span>{1e3 * film.time[-1]:.4g} ms</span></div></div></div>\n"
        f"<script>{asset('run.js')}</script>\n"
    )


def film_payload(film: Film) -> dict[str, Any]:
    """Data of the page, as plain JSON values and one binary block."""
    block = Block()
    at = np.linspace(0.0, film.time[-1], min(_MOST, film.time.size))
    kept = np.minimum(np.searchsorted(film.time, at), film.time.size - 1)
    own = _columns_at(at, film.time, film.coordinates)
    turned = film.axial.copy()
    turned[:, 0] = 0.0
    sideways, lifted = film.lateral @ own.T, own[:, 0]
    tilted = np.abs(turned @ own.T).max(initial=0.0)
    lateral, lift = enlargements(
        float(np.ptp(film.points[:, 2])),
        float(max(np.abs(sideways).max(initial=0.0), tilted)),
        float(np.abs(lifted).max(initial=0.0)),
    )
    return {
        "scene": film.scene,
        "until": float(film.time[-1]),
        "samples": int(at.size),
        "width": int(own.shape[1]),
        "coordinates": block.plain(own.ravel()),
        "points": block.plain(film.points.ravel()),
        "lateral": block.plain(film.lateral.ravel()),
        "axial": block.plain(film.axial.ravel()),
        "regions": [
            {
                "name": region,
                "colour": colour_of(region),
                "triangles": block.plain(
                    film.triangles[film.region_of_triangle == number].ravel().astype(np.int64)
                ),
            }
            for number, region in enumerate(film.regions)
        ],
        "curves": [
            {
                "key": f"c{number}",
                "title": title,
                "unit": unit,
                "values": block.plain(np.interp(at, film.time, values) / size),
            }
            for number, (title, (values, unit, size)) in enumerate(film.curves.items())
        ],
        "forces": [block.plain(1e3 * _largest(film.time, force, at)) for force in film.forces],
        "phase": block.plain(film.phase[kept].astype(np.int64)),
        "phases": [{"name": name, "words": words} for name, words in CONTACTS.items()],
        "drawn": {"lateral": lateral, "lift": lift},
        "heights": [float(film.points[:, 2].min()), float(film.points[:, 2].max())],
        "stroke": film.stroke,
        "rim": film.rim,
        "touch": 1e3 * _TOUCH,
        "blob": block.text(),
    }


def _largest(time: Floats, values: Floats, at: Floats) -> Floats:
    """Largest value (s,) near each of some evenly spaced times: blows are short."""
    middle = 0.5 * (at[1:] + at[:-1])
    starts = np.concatenate([[0], np.searchsorted(time, middle)])
    found = np.maximum.reduceat(values, np.minimum(starts, time.size - 1))
    return np.asarray(np.maximum(found, np.interp(at, time, values)))
