"""Meshes to and from .vtu and .msh files, names of regions and faces included.

For ParaView, Gmsh and other solvers.  A round trip gives the same mesh; results at the
points can go along on the way out.
"""

from __future__ import annotations

import contextlib
import io
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any, get_args

import numpy as np
from numpy.typing import NDArray

from tactgen.geometry.arrays import Floats, Ints
from tactgen.geometry.errors import InputError
from tactgen.geometry.files import written_whole
from tactgen.geometry.meshing.mesh import CellKind, Mesh

if TYPE_CHECKING:
    import meshio

#: meshio's name of each kind of cell, and of its faces by their corners.
_CELLS = {"tetra": "tetra", "tetra10": "tetra10", "hexahedron": "hexahedron"}
_FACES = {3: "triangle", 4: "quad"}

#: Prefixes of the 0/1 cell arrays that carry names in a .vtu file.
_REGION, _FACE = "region ", "face "


def write_mesh(
    mesh: Mesh, path: str | Path, point_data: Mapping[str, NDArray[np.number]] | None = None
) -> None:
    """Write a mesh to a file, as its suffix says.

    Parameters
    ----------
    mesh : Mesh
        Written in metres.
    path : path
        ``.vtu`` (ParaView: regions and faces are cell arrays named ``region …`` and
        ``face …`` that hold 0 or 1) or ``.msh`` (Gmsh 2.2: they are physical groups).
    point_data : mapping of str to (n_points,) or (n_points, 3) real array, optional
        Fields at the points.

    Raises
    ------
    InputError
        If the suffix is another one or the file cannot be written.
    """
    path = Path(path)
    _check_suffix(path)
    fields = {name: np.ascontiguousarray(values) for name, values in (point_data or {}).items()}
    if path.suffix == ".vtu":
        content, options = _as_vtu(mesh, fields), {}
    else:
        content, options = _as_msh(mesh, fields), {"file_format": "gmsh22"}
    with written_whole(path) as temporary:
        content.write(temporary, **options)


def read_mesh(path: str | Path) -> Mesh:
    """Read a mesh that :func:`write_mesh` wrote.

    Raises
    ------
    InputError
        If there is no such file or it is not such a mesh.
    """
    import meshio

    path = Path(path)
    _check_suffix(path)
    if not path.is_file():
        raise InputError(f"{path} does not exist; give the path of a .vtu or .msh file")
    try:
        # meshio's front door ends the whole program on a broken file; its Gmsh reader chats
        with contextlib.redirect_stdout(io.StringIO()):
            if path.suffix == ".vtu":
                return _from_vtu(meshio.vtu.read(str(path)))
            return _from_msh(meshio.gmsh.read(str(path)))
    except Exception as error:  # readers raise whatever a broken file provokes
        raise InputError(
            f"{path} is not a mesh with named regions; give a file written by this program"
        ) from error


def _check_suffix(path: Path) -> None:
    if path.suffix not in {".vtu", ".msh"}:
        raise InputError(f"{path} does not end in .vtu or .msh; name the file so")


def _blocks(mesh: Mesh) -> list[tuple[str, Ints]]:
    """Return the cells, then the triangles or quads of each named face."""
    faces = [(_FACES[corners.shape[1]], corners) for corners in mesh.faces.values()]
    return [(_CELLS[mesh.kind], mesh.cells), *faces]


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
        data[_REGION + name] = marked(0, (mesh.region_of_cell == index).astype(np.uint8))
    for index, name in enumerate(mesh.faces):
        data[_FACE + name] = marked(index + 1, np.ones(sizes[index + 1], np.uint8))
    return meshio.Mesh(mesh.points, blocks, point_data=fields, cell_data=data)


def _from_vtu(content: meshio.Mesh) -> Mesh:
    kind, cells = content.cells[0].type, content.cells[0].data
    data = content.cell_data
    faces = {}
    for name in [name for name in data if name.startswith(_FACE)]:
        marked = [
            block.data[marks == 1]
            for block, marks in zip(content.cells[1:], data[name][1:], strict=True)
        ]
        faces[name.removeprefix(_FACE)] = np.concatenate([m for m in marked if len(m)])
    return _mesh(
        content.points,
        cells,
        kind,
        region_of_cell=data["region"][0],
        regions=tuple(n.removeprefix(_REGION) for n in data if n.startswith(_REGION)),
        faces=faces,
    )


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


def _from_msh(content: meshio.Mesh) -> Mesh:
    groups = content.cell_data["gmsh:physical"]
    names = sorted(content.field_data.items(), key=lambda item: int(item[1][0]))
    regions = tuple(name for name, (_, dimension) in names if dimension == 3)
    volumes = [k for k, block in enumerate(content.cells) if block.type in _CELLS]
    surfaces = [k for k, block in enumerate(content.cells) if block.type in _FACES.values()]
    faces = {}
    for name, (group, dimension) in names:
        if dimension == 2:
            marked = [content.cells[k].data[groups[k] == group] for k in surfaces]
            faces[name] = np.concatenate([m for m in marked if len(m)])
    return _mesh(
        content.points,
        np.concatenate([content.cells[k].data for k in volumes]),
        content.cells[volumes[0]].type,
        region_of_cell=np.concatenate([groups[k] for k in volumes]) - 1,
        regions=regions,
        faces=faces,
    )


def _mesh(
    points: Floats,
    cells: Ints,
    kind: str,
    *,
    region_of_cell: Ints,
    regions: tuple[str, ...],
    faces: dict[str, Ints],
) -> Mesh:
    kinds: dict[str, CellKind] = {k: k for k in get_args(CellKind)}
    if not regions:
        raise ValueError("no named regions")
    return Mesh(
        points=np.asarray(points, dtype=np.float64),
        cells=np.asarray(cells, dtype=np.int64),
        kind=kinds[kind],
        region_of_cell=np.asarray(region_of_cell, dtype=np.int64),
        regions=regions,
        faces={name: np.asarray(corners, dtype=np.int64) for name, corners in faces.items()},
    )
