"""A cube in cells of every kind, none of them better shaped than meshes of devices have them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Literal

import numpy as np

from tactgen.geometry.arrays import Floats
from tactgen.geometry.meshing.mesh import Mesh
from tactgen.geometry.meshing.quadratic import TET_EDGES
from tactgen.geometry.meshing.structured_tets import box_tetrahedra

Cells = Literal["straight", "curved", "hexahedra"]

#: Edge of the cube (m), and how far a vertex is moved: by a map as a share of it, or at random as
#: one of a cell's edge.
EDGE = 1e-3
_BENT, _SHAKEN = 0.02, 0.1


def cube(cells: Cells, divisions: int, across: int | None = None) -> Mesh:
    """Return a cube of 1 mm: shaken straight tetrahedra, curved ones, or rectangular hexahedra.

    The curved ones follow a smooth map of the cube onto itself, all edges with their middles.
    With `across` it is a column along x, so many of these cells wide.
    """
    counts = np.array([divisions, across or divisions, across or divisions])
    sizes = EDGE * counts / divisions
    planes = [np.linspace(0.0, size, n + 1) for size, n in zip(sizes, counts, strict=True)]
    if cells == "hexahedra":
        return hexahedra(planes)
    x, y, z = planes
    mesh = box_tetrahedra(x, y, z, np.zeros(counts, dtype=int), ("all",))
    if cells == "curved":
        return _curved(mesh, sizes)
    share = mesh.points / sizes
    inner = np.all((share > 1e-6) & (share < 1.0 - 1e-6), axis=1)
    moved = np.random.default_rng(1).uniform(-1.0, 1.0, share.shape)
    points = mesh.points + _SHAKEN * EDGE / divisions * moved * inner[:, None]
    return replace(mesh, points=points)


def _curved(mesh: Mesh, sizes: Floats) -> Mesh:
    ends = mesh.cells[:, TET_EDGES].reshape(-1, 2)
    edges, which = np.unique(np.sort(ends, axis=1), axis=0, return_inverse=True)
    points = np.vstack([mesh.points, mesh.points[edges].mean(axis=1)])
    share = np.pi * points / sizes
    points = points + _BENT * sizes * np.sin(share) * np.cos(np.roll(share, 1, axis=1))
    middles = len(mesh.points) + which.reshape(len(mesh.cells), -1)
    return replace(mesh, points=points, cells=np.hstack([mesh.cells, middles]), kind="tetra10")


def hexahedra(planes: Sequence[Floats]) -> Mesh:
    """Return the rectangular hexahedra between planes (m) along x, y and z."""
    nodes = [p.size for p in planes]
    points = np.stack(np.meshgrid(*planes, indexing="ij"), axis=-1).reshape(-1, 3)
    low = np.arange(len(points)).reshape(nodes)[:-1, :-1, :-1].ravel()[:, None]
    along, sideways = nodes[1] * nodes[2], nodes[2]
    square = np.array([0, along, along + sideways, sideways])
    cells = low + np.concatenate([square, square + 1])
    return Mesh(points, cells, "hexahedron", np.zeros(len(cells), dtype=int), ("all",), {})
