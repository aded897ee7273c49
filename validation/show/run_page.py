"""The page of a run: the body at true times, a time slider, the curves beneath, in one file."""

from __future__ import annotations

import html
import json
from dataclasses import dataclass
from typing import Any

import numpy as np

from tactgen.geometry.arrays import Floats, Ints
from tactgen.validation.show.page import asset, document
from tactgen.validation.show.run_film import CONTACTS, enlargements
from tactgen.validation.show.shading import COLOURS
from tactgen.validation.show.viewer import Block

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
    body = f"<script>{asset('three.min.js')}</script>\n{fragment(film)}"
    head = "<style>html,body{margin:0;height:100%}.tr{height:100vh;min-height:40rem}</style>\n"
    return document(f"{film.scene}: a run in time", head, f"<main>{body}</main>\n")


def fragment(film: Film, *, within: bool = False) -> str:
    """Run as a part of a page that has the library for pictures in space.

    `within` a page that is about more it stays light, waits to be played, and takes only the keys
    that are meant for it.
    """
    text = json.dumps(film_payload(film), separators=(",", ":"), allow_nan=False)
    text = text.replace("</", "<\\/")
    title = f"{html.escape(film.scene)} in time"
    title = f"<h3>{title}</h3>" if within else f"<h1>{title}</h1>"
    return (
        f"<style>{asset('run.css')}</style>\n"
        f'<script type="application/json" id="tr-data">{text}</script>\n'
        f'<div class="tr{" tr-within" if within else ""}"><div class="tr-stage">{_STAGE}</div>\n'
        f'<div class="tr-panel">{title}{_PANEL}'
        f'<p class="tr-help">{html.escape(film.words)}</p>{_HELP}</div>\n'
        f'<div class="tr-curves"><div class="tr-rows"></div><div class="tr-axis"><span>0</span>'
        f"<span>{1e3 * film.time[-1]:.4g} ms</span></div></div></div>\n"
        f"<script>{asset('run.js')}</script>\n"
    )


def film_payload(film: Film) -> dict[str, Any]:
    """What the page gets, as plain JSON values and one binary block."""
    block = Block()
    at = np.linspace(0.0, film.time[-1], min(_MOST, film.time.size))
    kept = np.minimum(np.searchsorted(film.time, at), film.time.size - 1)
    own = np.array([np.interp(at, film.time, column) for column in film.coordinates.T]).T
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
                "colour": COLOURS.get(region, (0.7, 0.7, 0.7)),
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
