"""The mesh as a plain value: points, cells, named regions and named faces.

Physics refers to names only (regions ``piezo_top``, ``shim``, …; faces ``tip``,
``base``, ``electrode_…``), never to coordinates.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np

from tactgen.geometry.arrays import Floats, Ints
from tactgen.geometry.store.values import storable

CellKind = Literal["tetra", "tetra10", "hexahedron"]

#: Corners of the four faces of a tetrahedron in VTK order, seen from outside.
TET_FACES = np.array([[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]])


@storable
@dataclass(frozen=True)
class Mesh:
    """A conforming volume mesh.

    Attributes
    ----------
    points : (n_points, 3) array
        Coordinates (m).
    cells : (n_cells, 4 | 8 | 10) int array
        Vertex indices in VTK order, positively oriented; ``tetra10`` carries mid-edge nodes.
    kind : str
        ``tetra``, ``tetra10`` (curved) or ``hexahedron`` (straight-edged, 8 corners).
    region_of_cell : (n_cells,) int array
        Index into `regions`.
    regions : tuple of str
        Region names.
    faces : dict of str to (n_faces, 3 | 4) int array
        Corner vertices of the element faces that make up each named face.
    """

    points: Floats
    cells: Ints
    kind: CellKind
    region_of_cell: Ints
    regions: tuple[str, ...]
    faces: dict[str, Ints]

    def cells_of(self, region: str) -> Ints:
        """Return the indices of the cells of a named region."""
        return np.flatnonzero(self.region_of_cell == self.regions.index(region))


#: Corners of the faces of each kind of cell, seen from outside, in VTK order.
_HEXAHEDRON = np.array(
    [[0, 3, 2, 1], [4, 5, 6, 7], [0, 1, 5, 4], [1, 2, 6, 5], [2, 3, 7, 6], [3, 0, 4, 7]]
)
_TETRA = np.array([[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]])
#: The same of ten nodes: corners, then the nodes between them.
_TETRA10 = np.array(
    [[0, 2, 1, 6, 5, 4], [0, 1, 3, 4, 8, 7], [1, 2, 3, 5, 9, 8], [0, 3, 2, 7, 9, 6]]
)
_FACES = {"hexahedron": (_HEXAHEDRON, 4), "tetra": (_TETRA, 3), "tetra10": (_TETRA10, 3)}
#: Triangles of a face with so many nodes.
_TRIANGLES = {
    3: np.array([[0, 1, 2]]),
    4: np.array([[0, 1, 2], [0, 2, 3]]),
    6: np.array([[0, 3, 5], [3, 1, 4], [5, 4, 2], [3, 4, 5]]),
}
#: Edges of such a face, without its diagonals.
_EDGES = {
    3: np.array([[0, 1], [1, 2], [2, 0]]),
    4: np.array([[0, 1], [1, 2], [2, 3], [3, 0]]),
    6: np.array([[0, 3], [3, 1], [1, 4], [4, 2], [2, 5], [5, 0]]),
}


@dataclass(frozen=True)
class Surface:
    """What is seen of a mesh, by the mesh's own points.

    Attributes
    ----------
    triangles : (n, 3) int array
        Seen from outside.
    region_of_triangle : (n,) int array
        Index into the mesh's regions.
    edges : (m, 2) int array
        Edges of cells, each once.
    """

    triangles: Ints
    region_of_triangle: Ints
    edges: Ints


def surface_of(mesh: Mesh) -> Surface:
    """Return the surface of a mesh."""
    local, corners = _FACES[mesh.kind]
    faces = mesh.cells[:, local].reshape(-1, local.shape[1])
    owners = np.repeat(mesh.region_of_cell, len(local))
    ends = np.sort(faces[:, :corners], axis=1)
    _, where, count = np.unique(ends, axis=0, return_inverse=True, return_counts=True)
    alone = count[where.ravel()] == 1
    faces, owners = faces[alone], owners[alone]
    number = local.shape[1]
    triangles = faces[:, _TRIANGLES[number]].reshape(-1, 3)
    edges = np.sort(faces[:, _EDGES[number]].reshape(-1, 2), axis=1)
    return Surface(
        triangles,
        np.repeat(owners, len(_TRIANGLES[number])),
        np.unique(edges, axis=0),
    )
