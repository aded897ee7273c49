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
