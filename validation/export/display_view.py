"""The display as files to look at: the moving page, and a still."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from tactgen.geometry.arrays import Complex
from tactgen.geometry.device.layout import MM
from tactgen.geometry.display.layout import as_built, display_parts, unit_names
from tactgen.geometry.files import write_text, written_whole
from tactgen.geometry.formats import engineering
from tactgen.tmm.display.array import tip_motions
from tactgen.tmm.ports.multiport import Multiport
from tactgen.validation.engine.model import make_model
from tactgen.validation.engine.plan import make_plan
from tactgen.validation.engine.stages import Stages
from tactgen.validation.models.display.crosstalk import display_ports
from tactgen.validation.scene.scene import Scene
from tactgen.validation.view.page.display import DrawnPart, Swing, display_page
from tactgen.validation.view.page.html import Still
from tactgen.validation.view.pictures import assembly_picture
from tactgen.validation.view.stills import check_ffmpeg, save_film

if TYPE_CHECKING:
    from PIL.Image import Image

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

    Raises
    ------
    InputError
        If parts do not fit, a film cannot be made, or a file cannot be written.
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


def _film(
    scene: Scene, parts: tuple[DrawnPart, ...], announce: Callable[[str], None]
) -> list[Image]:
    """Return one period of a wave that runs along x, each column a quarter period after the last.

    Drawn once, whatever films it is saved as.
    """
    from tactgen.validation.view.assembly_frames import assembly_frames, enlargement

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
    phases = [2.0 * np.pi * k / _FRAMES for k in range(_FRAMES)]
    seen = [part for part in parts if part.name not in _HIDES]
    return assembly_frames(seen, tips, ceramic, times, words, phases, announce)


def travelling_wave(scene: Scene) -> tuple[float, Complex]:
    """Return the tips' motions (units,) in m with all units driven, and at what frequency (Hz).

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


def drawn_parts(scene: Scene) -> tuple[DrawnPart, ...]:
    """Return every distinct part of the display as triangles, with its places."""
    from tactgen.geometry.cad.display import DISPLAY_COLOURS, display_solids

    solids = display_solids(scene.device, scene.display)
    found = []
    for placed in display_parts(scene.device, scene.display):
        vertices, triangles = solids[placed.name].tessellate(*_DEFLECTION)
        found.append(
            DrawnPart(
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
    """Return how the tips move where one unit is driven, by transfer matrices."""
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
    """Return the display over each unit's tip and voltage, by transfer matrices."""
    from tactgen.validation.catalogue.quantities import CROSSTALK_LARGEST

    plan = make_plan(scene, (_MODEL,), (CROSSTALK_LARGEST.name,))
    ports = make_model(_MODEL, scene, Stages(plan.keys)).answer("crosstalk").ports
    return display_ports(scene, ports.fine)
