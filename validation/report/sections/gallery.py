"""The report's pictures: geometry, mesh and mode shapes, as PNG inside the page."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from tactgen.geometry.bimorph.bricks import Bricks
from tactgen.geometry.device.checks import beyond_plain_layers
from tactgen.geometry.meshing.mesh import Mesh
from tactgen.validation.report.report_data import Study
from tactgen.validation.report.request import shown_model
from tactgen.validation.show.page import fragment, inline

if TYPE_CHECKING:
    from tactgen.validation.engine.solve import Solution
    from tactgen.validation.show.field import FieldResult

#: Mode stills, and their size in pixels.
_MODES = 4
_STILL = 340, 600

_KIND = {"tetra": "tetrahedra with 10 nodes", "tetra10": "curved tetrahedra with 10 nodes"}


def pictures(study: Study) -> list[dict[str, str]]:
    """Pictures of the CAD solids and, with a field model, of its mesh."""
    found = bimorph(study) if study.lateral else []
    whole = study.lateral and study.scene.support.kind == "rod"
    return found if whole or not study.normal else [*found, _normal(study)]


def bimorph(study: Study) -> list[dict[str, str]]:
    """Pictures of the bimorph; none of one that only the beam models know."""
    if beyond_plain_layers(study.scene.bimorph):
        return []
    from tactgen.validation.models.bimorph.solid import cells_of
    from tactgen.validation.show.export import scene_solids
    from tactgen.validation.show.pictures import mesh_picture, solids_picture

    study.announce("picture of the geometry")
    solids = solids_picture(scene_solids(study.scene))
    found = [{"caption": "CAD solids", "png": inline(solids)}]
    solved = study.shown_mesh
    if solved is not None:
        study.announce("picture of the mesh")
        mesh = cells_of(solved)
        name = shown_model(study.scene)
        caption = f"mesh of the model {name}: {mesh.cells.shape[0]} {_kind(solved, mesh)}"
        found.append({"caption": caption, "png": inline(mesh_picture(mesh))})
        found.append({"caption": "the same at its held end", "png": _close_up(mesh)})
    return found


def beside(study: Study) -> dict[str, Any] | None:
    """Tetrahedra of the CAD solids, where they stand beside bricks."""
    if "cad" not in study.scene.models or shown_model(study.scene) in (None, "cad"):
        return None
    study.announce("picture of the tetrahedra")
    return tetrahedra(study.solution)


def tetrahedra(solution: Solution) -> dict[str, Any]:
    """Picture of the tetrahedra that a solution has solved on."""
    from tactgen.validation.models.bimorph.mesh_pair import TwoMeshModel
    from tactgen.validation.models.bimorph.solid import cells_of

    cad = solution.models["cad"]
    assert isinstance(cad, TwoMeshModel)
    shown = cells_of(cad.meshes()[0])
    return {"cells": shown.cells.shape[0], "png": _close_up(shown)}


def _normal(study: Study) -> dict[str, str]:
    """Picture of rod, coil and sleeve."""
    from tactgen.validation.show.export import normal_actuator_solids
    from tactgen.validation.show.pictures import solids_picture

    study.announce("picture of the normal actuator")
    solids = solids_picture(normal_actuator_solids(study.scene.device))
    caption = "normal actuator: the rod inside coil and sleeve, these cut open"
    return {"caption": caption, "png": inline(solids)}


def _close_up(mesh: Mesh) -> str:
    """Picture of a mesh at its held end."""
    from tactgen.validation.show.pictures import mesh_picture

    return inline(mesh_picture(mesh, close_up=True))


def moving(study: Study) -> dict[str, Any]:
    """Stills of the first solid modes, and the viewer in which modes and fields move."""
    from tactgen.validation.catalogue.quantities import (
        OPEN_CIRCUIT_FREQUENCIES,
        SHORT_CIRCUIT_FREQUENCIES,
    )
    from tactgen.validation.engine.solve import solve
    from tactgen.validation.show.gather import Request, gather_from
    from tactgen.validation.show.moving import standing
    from tactgen.validation.show.viewer import payload

    models = _moving_models(study)
    names = (SHORT_CIRCUIT_FREQUENCIES.name, OPEN_CIRCUIT_FREQUENCIES.name)
    solution = solve(study.scene, models, names, study.announce, reuse=study.solution)
    request = Request(None, "edges")
    gathered = (gather_from(solution, name, request, study.announce) for name in models)
    results = [standing(study.scene, result) for result in gathered]
    return {
        "stills": _stills(results[0], study.announce) if shown_model(study.scene) else [],
        "viewer": fragment(payload(results), [], light=True),
    }


def _moving_models(study: Study) -> tuple[str, ...]:
    """Models to look at: the solid that is shown, and transfer matrices beside it."""
    asked = tuple(study.solution.models_of("bimorph"))
    first = shown_model(study.scene) or asked[-1]
    return (first, "tmm") if "tmm" in asked and first != "tmm" else (first,)


def _stills(result: FieldResult, announce: Callable[[str], None]) -> list[dict[str, str]]:
    from tactgen.validation.show.field import SHADES, words_of
    from tactgen.validation.show.stills import Picture, still

    found = []
    for state in [s for s in result.states if s.circuit == "short"][:_MODES]:
        announce(f"picture of {state.name}")
        words = words_of(result, state)
        png = still(result, state, Picture(*_STILL, shade=SHADES[0]))
        caption = f"{words.title}: {words.number}, {words.detail}"
        found.append({"caption": caption, "png": inline(png)})
    return found


def _kind(solved: Mesh | Bricks, shown: Mesh) -> str:
    """Cells of a mesh that is solved on, and shown by its cells, in words."""
    if not isinstance(solved, Bricks):
        return _KIND[shown.kind]
    x, y, z = solved.degree
    return f"bricks of degree {x}, {y}, {z} across the layers, the width and along the length"
