"""The display as files to look at: the moving page, and a still."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np

from tactgen.geometry.device.layout import MM
from tactgen.geometry.display.layout import as_built, display_parts, unit_names
from tactgen.geometry.errors import InputError
from tactgen.geometry.files import write_text, written_whole
from tactgen.tmm.display.array import tip_motions
from tactgen.validation.engine.model import make_model
from tactgen.validation.engine.plan import make_plan
from tactgen.validation.engine.stages import Stages
from tactgen.validation.models.display.crosstalk import MechanicalCrosstalk, display_ports
from tactgen.validation.scene.scene import Scene
from tactgen.validation.view.page.display import DrawnPart, Swing, display_page
from tactgen.validation.view.page.html import Still
from tactgen.validation.view.pictures import assembly_picture

#: What swings with a unit's tip.
_SWINGS = ("piezo_top", "piezo_bottom", "shim")
#: Largest distance of a curved face from its triangles (mm), and their angle (rad).
_DEFLECTION = 0.02, 0.4
#: Which model says how tips move, and the quantity whose stages that takes.
_MODEL = "tmm"


def view_display(
    scene: Scene, files: dict[str, Path], announce: Callable[[str], None]
) -> list[Path]:
    """Write the display's page or a still, and return their paths.

    Parameters
    ----------
    files : dict of {"out", "png"} to Path
        What to write where.

    Raises
    ------
    InputError
        If a film is wanted, parts do not fit, or a file cannot be written.
    """
    films = [kind for kind in files if kind not in ("out", "png")]
    if films:
        raise InputError(
            f"--{films[0]} {files[films[0]]} is not there for the display; write --out FILE.html, "
            "in which it moves, or --png FILE"
        )
    announce("solids of the display")
    parts = drawn_parts(scene)
    for kind, path in files.items():
        announce("still" if kind == "png" else "page")
        picture = assembly_picture(parts)
        if kind == "png":
            with written_whole(path) as temporary:
                temporary.write_bytes(picture)
        else:
            still = Still(picture, f"{scene.name}: the display")
            write_text(path, display_page(scene.name, parts, swing(scene), still))
    return list(files.values())


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
    from tactgen.validation.catalogue.display import CROSSTALK_LARGEST

    plan = make_plan(scene, (_MODEL,), (CROSSTALK_LARGEST.name,))
    ports = make_model(_MODEL, scene, Stages(plan.keys)).answer("crosstalk").ports
    crosstalk = MechanicalCrosstalk(scene, ports)
    units = unit_names(scene.display)
    row, column = crosstalk.driven
    driven = row * scene.display.columns + column
    motions = tip_motions(display_ports(scene, ports.fine), units[driven], units)
    built = as_built(scene.device, scene.display)
    return Swing(
        units, driven, scene.drive.voltage, np.asarray(scene.frequency, dtype=float),
        scene.drive.voltage * motions, MM * built.ceramic_base, MM * built.bimorph.length,
        MM * scene.display.pitch,
    )  # fmt: skip
