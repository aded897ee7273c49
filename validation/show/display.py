"""The page of the display: each distinct part once, placed as often as it stands, tips swinging."""

from __future__ import annotations

import base64
import html
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from tactgen.geometry.arrays import Complex, Floats, Ints
from tactgen.geometry.device.parts import MM
from tactgen.geometry.display.layout import as_built, display_parts, unit_names
from tactgen.geometry.files import write_text, written_whole
from tactgen.geometry.formats import engineering
from tactgen.tmm.display import tip_motions
from tactgen.tmm.ports.multiport import Multiport
from tactgen.validation.engine.solve import make_plan
from tactgen.validation.models.classes import make_model
from tactgen.validation.models.display import display_ports
from tactgen.validation.models.model import Stages
from tactgen.validation.scene.scene import Scene
from tactgen.validation.show.page import Still, asset, data_script, document
from tactgen.validation.show.pictures import (
    INK,
    Part,
    Stage,
    assembly_picture,
    check_ffmpeg,
    fonts,
    save_film,
)

if TYPE_CHECKING:
    from PIL.Image import Image


@dataclass(frozen=True)
class Swing:
    """Motion of the tips."""

    units: tuple[str, ...]  #: The generators' names, in the order of the parts' places
    driven: int  #: Which of them is driven
    voltage: float  #: With which (V, peak)
    frequencies: Floats  #: (n,) Hz
    tips: Complex  #: (n, units) complex Lateral motion (m)
    #: Height of the ceramic's lower edge in a unit's frame, and its length (mm)
    base: float
    reach: float
    pitch: float  #: mm


def display_page(scene: str, parts: Sequence[Part], swing: Swing, still: Still) -> str:
    """Page: HTML that holds all it needs."""
    name, last = html.escape(scene), len(swing.frequencies) - 1
    # all of x, with a margin
    low, high = (f"{ends[0] + room:.3f}" for ends, room in zip(_box(parts), (-1, 1), strict=True))
    body = (
        f"{data_script('td-data', _payload(parts, swing))}\n"
        '<div class="td"><div class="td-stage"><figure class="td-still" hidden>'
        f'<img alt="{html.escape(still.caption)}" src="{still.source}">'
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


def _box(parts: Sequence[Part]) -> tuple[Floats, Floats]:
    """Lowest and highest corner (mm) of all parts."""
    low = [p.points.min(axis=0) + p.places.min(axis=0) for p in parts]
    high = [p.points.max(axis=0) + p.places.max(axis=0) for p in parts]
    return np.min(low, axis=0), np.max(high, axis=0)


def _payload(parts: Sequence[Part], swing: Swing) -> dict[str, object]:
    low, high = _box(parts)
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


#: Size in pixels, and where the eye is: far enough up that all tips are seen.
_SIZE = 640, 720
_VIEW = (2.2, -3.0, 2.0)
#: Half the picture's height over the size of what moves.
_ROOM = 0.62
#: Share of the pitch that the largest deflection is drawn as.
_REACH = 0.3


def enlargement(tips: Complex, pitch: float) -> float:
    """By how much tips' motions (units,) in m are drawn enlarged at a pitch (mm)."""
    largest = 1e3 * float(np.abs(tips).max(initial=0.0))
    return _REACH * pitch / largest if largest > 0.0 else 0.0


def _frames(
    parts: Sequence[Part],
    tips: Complex,
    ceramic: tuple[float, float],
    enlarge: float,
    words: str,
    announce: Callable[[str], None],
) -> list[Image]:
    """Images of one period, with words in them.

    Tips (units,) move along x (m, peak), in the order of what moves.  `ceramic` is the height of
    its lower edge in a unit's frame, and its length (mm).
    """
    from PIL import ImageDraw

    stage = Stage(*_SIZE)
    moving = []
    for part in parts:
        surface, rest = stage.copies(part)
        stage.plotter.add_mesh(surface, color=part.colour, smooth_shading=False)
        if part.moves:
            height = np.clip((part.points[:, 2] - ceramic[0]) / ceramic[1], 0.0, 1.0)
            moving.append((surface, rest, height**2))
    stage.look_from(_VIEW)
    # what moves fills the picture; what stands round it may be cut off
    points = np.concatenate([rest.reshape(-1, 3) for _, rest, _ in moving])
    camera = stage.plotter.camera
    stage.shift(0.5 * (points.min(axis=0) + points.max(axis=0)) - np.array(camera.focal_point))
    camera.parallel_scale = _ROOM * float(np.linalg.norm(np.ptp(points, axis=0)))
    stage.plotter.renderer.ResetCameraClippingRange()
    (font,) = fonts(15)

    def at(phase: float) -> Image:
        swing = MM * enlarge * np.real(tips * np.exp(1j * phase))
        for surface, rest, shares in moving:
            drawn = rest.copy()
            drawn[..., 0] += swing[:, None] * shares
            surface.points = drawn.reshape(-1, 3)
        image = stage.image()
        ImageDraw.Draw(image).text((14, 12), words, fill=INK, font=font)
        return image

    phases = [2.0 * np.pi * k / _FRAMES for k in range(_FRAMES)]
    return stage.images(phases, at, announce)


#: Pictures of a film's one period, milliseconds that each is shown, and periods in an .mp4.
_FRAMES, _SHOWN, _REPEATS = 24, 80, 4
#: What a film leaves out, since it stands round the bimorphs.
_HIDES = ("support_plate", "support_spacer", "adjusting_spring")
#: What swings with a unit's tip.
_SWINGS = ("piezo_top", "piezo_bottom", "shim")
#: Largest distance of a curved face from its triangles (mm), and their angle (rad).
_DEFLECTION = 0.02, 0.4
#: Which model says how tips move, and the quantity whose stages that takes.
_MODEL = "tmm"


def view_display(
    scene: Scene, files: dict[str, Path], announce: Callable[[str], None]
) -> list[Path]:
    """Write the display's page, a still, and films of a travelling wave; return their paths.

    Parameters
    ----------
    files : dict of {"out", "png", "gif", "mp4"} to Path
        What to write where.

    Raises InputError if parts do not fit, a film cannot be made, or a file cannot be written.
    """
    for path in files.values():
        check_ffmpeg(path)
    announce("solids of the display")
    parts = drawn_parts(scene)
    films = [path for kind, path in files.items() if kind in ("gif", "mp4")]
    if films:
        images = _film(scene, parts, announce)
        for path in films:
            save_film(path, images, _SHOWN, _REPEATS)
    if "out" in files or "png" in files:
        announce("still")
        still = Still(assembly_picture(parts), f"{scene.name}: the display")
        if "png" in files:
            with written_whole(files["png"]) as temporary:
                temporary.write_bytes(still.png)
        if "out" in files:
            announce("page")
            write_text(files["out"], display_page(scene.name, parts, swing(scene), still))
    return list(files.values())


def _film(scene: Scene, parts: tuple[Part, ...], announce: Callable[[str], None]) -> list[Image]:
    """One period of a wave that runs along x, each column a quarter period after the last.

    Drawn once, whatever films it is saved as.
    """
    announce("motions of the display")
    frequency, tips = travelling_wave(scene)
    built = as_built(scene.device, scene.display)
    ceramic = MM * built.ceramic_base, MM * built.bimorph.length
    times = enlargement(tips, MM * scene.display.pitch)
    largest = engineering(float(np.abs(tips).max()), "m", 3)
    words = (
        f"{scene.name}: {frequency:.4g} Hz, {scene.drive.voltage:g} V peak at every unit, each "
        f"column\na quarter period later, tips up to {largest}, drawn × {times:.3g},\n"
        "the support plate left out"
    )
    seen = [part for part in parts if part.name not in _HIDES]
    return _frames(seen, tips, ceramic, times, words, announce)


def travelling_wave(scene: Scene) -> tuple[float, Complex]:
    """Tips' motions (units,) in m with all units driven, and the frequency (Hz).

    Each column lags a quarter period behind the one before it; of the scene's frequencies that at
    which the tips move most.
    """
    units = unit_names(scene.display)
    whole = _whole(scene)
    column = np.arange(len(units)) % scene.display.columns
    drives = scene.drive.voltage * (-1j) ** column
    motions = sum(
        drive * tip_motions(whole, unit, units)
        for unit, drive in zip(units, drives.tolist(), strict=True)
    )
    at = int(np.abs(motions).max(axis=1).argmax())
    return float(scene.frequency[at]), np.asarray(motions[at])


def drawn_parts(scene: Scene) -> tuple[Part, ...]:
    """Every distinct part of the display as triangles, with its places."""
    from tactgen.geometry.cad.display import DISPLAY_COLOURS, display_solids

    solids = display_solids(scene.device, scene.display)
    found = []
    for placed in display_parts(scene.device, scene.display):
        vertices, triangles = solids[placed.name].tessellate(*_DEFLECTION)
        found.append(
            Part(
                placed.name,
                DISPLAY_COLOURS[placed.name],
                np.array([vertex.toTuple() for vertex in vertices]),
                np.array(triangles),
                np.array(placed.places),
                placed.name in _SWINGS,
            )
        )
    return tuple(found)


def swing(scene: Scene) -> Swing:
    """Motion of the tips where one unit is driven, by transfer matrices."""
    units = unit_names(scene.display)
    row, column = (scene.display.rows - 1) // 2, (scene.display.columns - 1) // 2
    driven = row * scene.display.columns + column
    motions = tip_motions(_whole(scene), units[driven], units)
    built = as_built(scene.device, scene.display)
    return Swing(
        units, driven, scene.drive.voltage, np.asarray(scene.frequency, dtype=float),
        scene.drive.voltage * motions, MM * built.ceramic_base, MM * built.bimorph.length,
        MM * scene.display.pitch,
    )  # fmt: skip


def _whole(scene: Scene) -> Multiport:
    """Display over each unit's tip and voltage, by transfer matrices."""
    from tactgen.validation.catalogue.quantities import CROSSTALK_LARGEST

    plan = make_plan(scene, (_MODEL,), (CROSSTALK_LARGEST.name,))
    ports = make_model(_MODEL, scene, Stages(plan.keys)).answer("crosstalk").ports
    return display_ports(scene, ports.fine)
