"""The report's pictures: geometry, mesh and mode shapes, as PNG inside the page."""

from __future__ import annotations

import base64
from typing import Any

from tactgen.geometry.bimorph.bricks import Bricks
from tactgen.geometry.device.checks import beyond_plain_layers
from tactgen.geometry.meshing.mesh import Mesh
from tactgen.validation.report.study import Study

_KIND = {
    "tetra": "tetrahedra with 10 nodes",
    "tetra10": "curved tetrahedra with 10 nodes",
}


def pictures(study: Study) -> list[dict[str, str]]:
    """Return pictures of the CAD solids and, with a field model, of its mesh."""
    found = _lateral(study) if study.lateral else []
    whole = study.lateral and study.scene.support.kind == "rod"
    return found if whole or not study.normal else [*found, _normal(study)]


def _lateral(study: Study) -> list[dict[str, str]]:
    """Return pictures of the bimorph; none of one that only the beam models know."""
    if beyond_plain_layers(study.scene.bimorph):
        return []
    from tactgen.validation.export.files import scene_solids
    from tactgen.validation.models.bimorph.meshes import cells_of
    from tactgen.validation.view.pictures import mesh_picture, solids_picture

    study.announce("picture of the geometry")
    solids = solids_picture(scene_solids(study.scene))
    found = [{"caption": "CAD solids", "png": _inline(solids)}]
    if study.field is not None:
        study.announce("picture of the mesh")
        solved = study.field.meshes()[0]
        mesh = cells_of(solved)
        caption = f"mesh of the model {study.field.name}: {mesh.cells.shape[0]} {_kind(solved)}"
        found.append({"caption": caption, "png": _inline(mesh_picture(mesh))})
        found.append({"caption": "the same at its held end", "png": close_up(mesh)})
    return found


def _normal(study: Study) -> dict[str, str]:
    """Return a picture of rod, coil and sleeve."""
    from tactgen.validation.export.files import normal_actuator_solids
    from tactgen.validation.view.pictures import solids_picture

    study.announce("picture of the normal actuator")
    solids = solids_picture(normal_actuator_solids(study.scene.device))
    caption = "normal actuator: the rod inside coil and sleeve, these cut open"
    return {"caption": caption, "png": _inline(solids)}


def close_up(mesh: Mesh) -> str:
    """Return a picture of a mesh at its held end."""
    from tactgen.validation.view.pictures import mesh_picture

    return _inline(mesh_picture(mesh, close_up=True))


def modes(study: Study) -> list[dict[str, Any]]:
    """Return the first four solid modes with their pictures."""
    from scipy.spatial import cKDTree

    from tactgen.validation.models.bimorph.meshes import points_of
    from tactgen.validation.view.pictures import mode_picture

    solid = study.field
    if solid is None:
        return []
    mesh, system = points_of(solid.meshes()[0]), solid.systems()[0]
    at_points = cKDTree(system.nodes).query(mesh.points)[1]
    found = []
    for number, mode in enumerate(solid.shapes()[:4], start=1):
        study.announce(f"picture of mode {number}")
        picture = mode_picture(mesh, mode.displacement[at_points])
        found.append({"number": number, "mode": mode, "png": _inline(picture)})
    return found


def _kind(mesh: Mesh | Bricks) -> str:
    """Return the cells of a mesh in words."""
    if not isinstance(mesh, Bricks):
        return _KIND[mesh.kind]
    x, y, z = mesh.degree
    return f"bricks of degree {x}, {y}, {z} across the layers, the width and along the length"


def _inline(png: bytes) -> str:
    return "data:image/png;base64," + base64.b64encode(png).decode("ascii")
