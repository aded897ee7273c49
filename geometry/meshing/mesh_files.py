"""Meshes to .vtu and .msh files, names of regions and faces included.

For ParaView, Gmsh and other solvers; results at the points can go along.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from tactgen.geometry.arrays import Ints
from tactgen.geometry.errors import InputError
from tactgen.geometry.files import written_whole
from tactgen.geometry.meshing.mesh import Mesh

if TYPE_CHECKING:
    import meshio

#: meshio's name of a face by its corners; kinds of cells have the same names there.
_FACES = {3: "triangle", 4: "quad"}


def write_mesh(
    mesh: Mesh, path: str | Path, point_data: Mapping[str, NDArray[np.number]] | None = None
) -> None:
    """Write a mesh in metres to a file, as its suffix says, with fields at its points.

    ``.vtu`` is ParaView's: regions and faces are cell arrays named ``region …`` and ``face …`` that
    hold 0 or 1.  ``.msh`` is Gmsh's (2.2): they are physical groups.  Fields are real, (n_points,)
    or (n_points, 3).

    Raises InputError if the suffix is another one or the file cannot be written.
    """
    path = Path(path)
    if path.suffix not in {".vtu", ".msh"}:
        raise InputError(f"{path} does not end in .vtu or .msh; name the file so")
    fields = {name: np.ascontiguousarray(values) for name, values in (point_data or {}).items()}
    if path.suffix == ".vtu":
        content, options = _as_vtu(mesh, fields), {}
    else:
        content, options = _as_msh(mesh, fields), {"file_format": "gmsh22"}
    with written_whole(path) as temporary:
        content.write(temporary, **options)


def _blocks(mesh: Mesh) -> list[tuple[str, Ints]]:
    """Cells, then the triangles or quads of each named face."""
    faces = [(_FACES[corners.shape[1]], corners) for corners in mesh.faces.values()]
    return [(mesh.kind, mesh.cells), *faces]


def _as_vtu(mesh: Mesh, fields: dict[str, NDArray[np.number]]) -> meshio.Mesh:
    import meshio

    blocks = _blocks(mesh)
    sizes = [len(cells) for _, cells in blocks]

    def marked(where: int, values: NDArray[np.uint8]) -> list[NDArray[np.uint8]]:
        return [values if k == where else np.zeros(n, np.uint8) for k, n in enumerate(sizes)]

    data: dict[str, Any] = {
        "region": [mesh.region_of_cell, *(np.full(n, -1, np.int64) for n in sizes[1:])]
    }
    for index, name in enumerate(mesh.regions):
        data[f"region {name}"] = marked(0, (mesh.region_of_cell == index).astype(np.uint8))
    for index, name in enumerate(mesh.faces):
        data[f"face {name}"] = marked(index + 1, np.ones(sizes[index + 1], np.uint8))
    return meshio.Mesh(mesh.points, blocks, point_data=fields, cell_data=data)


def _as_msh(mesh: Mesh, fields: dict[str, NDArray[np.number]]) -> meshio.Mesh:
    import meshio

    blocks = _blocks(mesh)
    first_face = len(mesh.regions) + 1  # Gmsh counts its physical groups from 1
    groups = [(mesh.region_of_cell + 1).astype(np.int32)]
    for index, (_, corners) in enumerate(blocks[1:]):
        groups.append(np.full(len(corners), first_face + index, np.int32))
    names = {name: np.array([i + 1, 3]) for i, name in enumerate(mesh.regions)}
    names |= {name: np.array([first_face + i, 2]) for i, name in enumerate(mesh.faces)}
    return meshio.Mesh(
        mesh.points,
        blocks,
        point_data=fields,
        cell_data={"gmsh:physical": groups, "gmsh:geometrical": groups},
        field_data=names,
    )
