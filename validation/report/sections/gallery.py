"""The report's pictures: geometry, mesh and mode shapes, as PNG inside the page."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np

from tactgen.geometry.bimorph.bricks import Bricks
from tactgen.geometry.device.checks import beyond_plain_layers
from tactgen.geometry.meshing.mesh import Mesh
from tactgen.validation.report.report_data import Context, Study
from tactgen.validation.report.request import shown_model
from tactgen.validation.show.page import Still, fragment

if TYPE_CHECKING:
    from tactgen.validation.show.field import FieldResult

#: Mode stills, and their size in pixels.
_MODES = 4
_STILL = 340, 600
_LYING = 1000, 420

_KIND = {"tetra": "tetrahedra with 10 nodes", "tetra10": "curved tetrahedra with 10 nodes"}


def pictures(study: Study) -> list[Still]:
    """Pictures of the CAD solids of each actuator; none of what the CAD parts do not know."""
    from tactgen.validation.show.export import normal_actuator_solids, scene_solids
    from tactgen.validation.show.pictures import solids_picture

    scene, found = study.scene, []
    on_rod = scene.support.kind == "rod"
    if study.lateral and not beyond_plain_layers(scene.bimorph, any_parts=not on_rod):
        study.announce("picture of the geometry")
        found.append(Still(solids_picture(scene_solids(scene)), "bimorph"))
    if study.normal and not (study.lateral and on_rod):
        study.announce("picture of the normal actuator")
        caption = "reluctance actuator, coil and sleeve cut open"
        found.append(Still(solids_picture(normal_actuator_solids(scene.device)), caption))
    return found


def meshes(study: Study) -> list[Still]:
    """Pictures of the solved meshes at their held end."""
    from tactgen.validation.models.bimorph.mesh_pair import TwoMeshModel
    from tactgen.validation.models.bimorph.solid import cells_of
    from tactgen.validation.show.pictures import mesh_picture

    found = []
    for name, model in study.solution.models_of("bimorph").items():
        if not isinstance(model, TwoMeshModel):
            continue
        study.announce(f"picture of the mesh of {name}")
        solved = model.meshes()[0]
        mesh = cells_of(solved)
        caption = f"mesh of {name}: {mesh.cells.shape[0]} {_kind(solved, mesh)}"
        found.append(Still(mesh_picture(mesh), caption))
    return found


def moving(study: Study) -> Context:
    """Stills of the first solid modes, and the viewer in which modes and fields move.

    Of the solid that is shown, with transfer matrices beside it.
    """
    from tactgen.validation.catalogue.quantities import (
        OPEN_CIRCUIT_FREQUENCIES,
        SHORT_CIRCUIT_FREQUENCIES,
    )
    from tactgen.validation.engine.solve import solve
    from tactgen.validation.show.gather import gather_from
    from tactgen.validation.show.generator_body import standing
    from tactgen.validation.show.viewer import payload

    asked = tuple(study.solution.models_of("bimorph"))
    first = shown_model(study.scene) or asked[-1]
    models = (first, "tmm") if "tmm" in asked and first != "tmm" else (first,)
    names = (SHORT_CIRCUIT_FREQUENCIES.name, OPEN_CIRCUIT_FREQUENCIES.name)
    solution = solve(study.scene, models, names, study.announce, reuse=study.solution)
    results = [
        standing(study.scene, gather_from(solution, name, None, "edges", study.announce))
        for name in models
    ]
    drawn = shown_model(study.scene) is not None
    return {
        "stills": _stills(results[0], study.announce) if drawn else [],
        "stress": _stress_still(results[0], study.announce) if drawn else None,
        "viewer": fragment(payload(results), [], light=True),
    }


def _stills(result: FieldResult, announce: Callable[[str], None]) -> list[Still]:
    from tactgen.validation.show.stills import captioned

    found = []
    for state in [s for s in result.states if s.circuit == "short"][:_MODES]:
        announce(f"picture of {state.name}")
        found.append(captioned(result, state, _STILL))
    return found


def _stress_still(result: FieldResult, announce: Callable[[str], None]) -> Still | None:
    """Axial stress of the driven state at the first natural frequency."""
    from tactgen.validation.show.colours import SHADES
    from tactgen.validation.show.stills import Picture, still

    driven = [state for state in result.states if state.kind == "harmonic"]
    if not driven:
        return None
    announce("picture of the stress")
    shade = next(shade for shade in SHADES if shade.key == "stress_zz")
    amplitude = np.asarray(shade.amplitude(driven[-1]))
    size = np.abs(amplitude)
    # both layers have the largest value alike: that of the last one is real then
    phase = -float(np.angle(amplitude[size >= (1.0 - 1e-6) * size.max()][-1]))
    png = still(result, driven[-1], Picture(*_LYING, shade=shade), phase)
    caption = f"axial stress by the model {result.model} at {driven[-1].frequency:.4g} Hz"
    return Still(png, f"{caption}, {result.drive}")


def _kind(solved: Mesh | Bricks, shown: Mesh) -> str:
    """Cells of a mesh that is solved on, and shown by its cells, in words."""
    if not isinstance(solved, Bricks):
        return _KIND[shown.kind]
    x, y, z = solved.degree
    return f"bricks of degree {x}, {y}, {z} across the layers, the width and along the length"
