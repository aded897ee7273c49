"""The page of the display: each distinct part once, placed as often as it stands, tips swinging."""

from __future__ import annotations

import base64
import html
import json
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from tactgen.geometry.arrays import Complex, Floats, Ints
from tactgen.validation.view.page.html import Still, asset, document, inline


@dataclass(frozen=True)
class DrawnPart:
    """One distinct part as triangles.

    Attributes
    ----------
    name : str
        The region's.
    colour : (float, float, float)
        Red, green, blue; 0 to 1.
    points, triangles : (n, 3) float, (m, 3) int
        In its own frame (mm).
    places : (k, 3) float
        Where its frame stands (mm), one for each copy.
    moves : bool
        Whether it swings with its unit's tip.
    """

    name: str
    colour: tuple[float, float, float]
    points: Floats
    triangles: Ints
    places: Floats
    moves: bool


@dataclass(frozen=True)
class Swing:
    """How the tips move.

    Attributes
    ----------
    units : tuple of str
        The generators' names, in the order of the parts' places.
    driven : int
        Which of them is driven.
    voltage : float
        With which (V, peak).
    frequencies : (n,) array
        Hz.
    tips : (n, units) complex array
        Lateral motion (m).
    base, reach : float
        Height of the ceramic's lower edge in a unit's frame, and its length (mm).
    pitch : float
        mm.
    """

    units: tuple[str, ...]
    driven: int
    voltage: float
    frequencies: Floats
    tips: Complex
    base: float
    reach: float
    pitch: float


def display_page(scene: str, parts: Sequence[DrawnPart], swing: Swing, still: Still) -> str:
    """Return the page: HTML that holds all it needs."""
    text = json.dumps(_payload(parts, swing), separators=(",", ":")).replace("</", "<\\/")
    name, last = html.escape(scene), len(swing.frequencies) - 1
    low, high = (f"{end:.3f}" for end in _across(parts))
    body = (
        f'<script type="application/json" id="td-data">{text}</script>\n'
        '<div class="td"><div class="td-stage"><figure class="td-still" hidden>'
        f'<img alt="{html.escape(still.caption)}" src="{inline(still.png)}">'
        f"<figcaption>{html.escape(still.caption)}; WebGL 2 is not available, so nothing moves"
        "</figcaption></figure></div>\n"
        f'<div class="td-panel"><h1>{name}: {len(swing.units)} generators</h1>'
        '<p class="td-words" aria-live="polite"></p>'
        '<button class="td-play" type="button">stop</button>'
        f'<label>frequency <input class="td-frequency" type="range" min="0" max="{last}" '
        f'value="{last // 2}"></label>'
        '<label>enlarged <input class="td-enlarge" type="range" min="0" max="1" step="0.01" '
        'value="0.5"></label>'
        f'<label>cut across x <input class="td-cut" type="range" min="{low}" max="{high}" '
        f'step="0.05" value="{high}"></label>'
        '<div class="td-parts"></div><p class="td-note">Drag or arrow keys turn, wheel zooms, '
        "right button shifts, space stops and moves. The tips' amplitudes and phases are solved; "
        "between base and tip a bimorph is drawn as a parabola.</p></div></div>\n"
        f"<script>{asset('three.min.js')}</script>\n<script>{asset('display.js')}</script>\n"
    )
    head = f"<style>html,body{{margin:0;height:100%}}\n{asset('display.css')}</style>\n"
    return document(f"{scene}: the display", head, body)


def _across(parts: Sequence[DrawnPart]) -> tuple[float, float]:
    """Return the least and the largest x of all parts (mm), with a margin."""
    low = min(float(p.points[:, 0].min() + p.places[:, 0].min()) for p in parts)
    high = max(float(p.points[:, 0].max() + p.places[:, 0].max()) for p in parts)
    return low - 1.0, high + 1.0


def _payload(parts: Sequence[DrawnPart], swing: Swing) -> dict[str, object]:
    corners = np.array(
        [
            [pick(part.points, axis=0) + pick(part.places, axis=0) for part in parts]
            for pick in (np.min, np.max)
        ]
    )
    low, high = corners[0].min(axis=0), corners[1].max(axis=0)
    tips = np.stack([swing.tips.real, swing.tips.imag], axis=-1)
    return {
        "parts": [
            {
                "title": part.name.replace("_", " "),
                "colour": list(part.colour),
                "points": _packed(part.points, "<f4"),
                "triangles": _packed(part.triangles, "<u4"),
                "places": part.places.round(6).tolist(),
                "moves": part.moves,
            }
            for part in parts
        ],
        "units": list(swing.units),
        "driven": swing.driven,
        "voltage": swing.voltage,
        "frequency": swing.frequencies.tolist(),
        "motions": [[[float(f"{v:.5g}") for v in unit] for unit in row] for row in tips],
        "base": swing.base,
        "reach": swing.reach,
        "pitch": swing.pitch,
        "centre": (0.5 * (low + high)).tolist(),
        "size": float(np.linalg.norm(high - low)),
    }


def _packed(values: Floats | Ints, kind: str) -> str:
    return base64.b64encode(np.ascontiguousarray(values, dtype=kind).tobytes()).decode("ascii")
