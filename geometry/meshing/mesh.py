"""The mesh as a plain value: points, cells, named regions and named faces.

Physics refers to names only (regions ``piezo_top``, ``shim``, …; faces ``tip``,
``base``, ``electrode_…``), never to coordinates.
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass
from math import factorial
from typing import Literal

import numpy as np

from tactgen.geometry.arrays import Floats, Ints
from tactgen.geometry.cad.tessellation import Face
from tactgen.geometry.errors import MeshError
from tactgen.geometry.store.values import storable

CellKind = Literal["tetra", "tetra10", "hexahedron"]

#: Corners of the four faces of a tetrahedron in VTK order, seen from outside.
TET_FACES = np.array([[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]])


@storable
@dataclass(frozen=True)
class Mesh:
    """A conforming volume mesh."""

    points: Floats  #: (n_points, 3) Coordinates (m)
    #: (n_cells, 4 | 8 | 10) Vertex indices in VTK order, positively oriented; ``tetra10`` carries
    #: mid-edge nodes
    cells: Ints
    kind: CellKind  #: ``tetra``, ``tetra10`` (curved) or ``hexahedron`` (straight-edged, 8 corners)
    region_of_cell: Ints  #: (n_cells,) Index into `regions`
    regions: tuple[str, ...]  #: Region names
    faces: dict[str, Ints]  #: Corner vertices of the element faces that make up each named face

    def cells_of(self, region: str) -> Ints:
        """Indices of the cells of a named region."""
        return np.flatnonzero(self.region_of_cell == self.regions.index(region))


#: Corners of the faces of each kind of cell, seen from outside, in VTK order.
_HEXAHEDRON = np.array(
    [[0, 3, 2, 1], [4, 5, 6, 7], [0, 1, 5, 4], [1, 2, 6, 5], [2, 3, 7, 6], [3, 0, 4, 7]]
)
#: The same of ten nodes: corners, then the nodes between them.
_TETRA10 = np.array(
    [[0, 2, 1, 6, 5, 4], [0, 1, 3, 4, 8, 7], [1, 2, 3, 5, 9, 8], [0, 3, 2, 7, 9, 6]]
)
_FACES = {"hexahedron": (_HEXAHEDRON, 4), "tetra": (TET_FACES, 3), "tetra10": (_TETRA10, 3)}
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
    """Surface of a mesh, by the mesh's own points."""

    triangles: Ints  #: (n, 3) Seen from outside
    region_of_triangle: Ints  #: (n,) Index into the mesh's regions
    edges: Ints  #: (m, 2) Edges of cells, each once


def surface_of(mesh: Mesh) -> Surface:
    """Surface of a mesh."""
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
    return Surface(triangles, np.repeat(owners, len(_TRIANGLES[number])), np.unique(edges, axis=0))


#: Corners of the six edges of a tetrahedron, in the order of VTK's mid-edge nodes.
TET_EDGES = np.array([[0, 1], [1, 2], [2, 0], [0, 3], [1, 3], [2, 3]])


def unique_edges(tets: Ints) -> tuple[Ints, Ints]:
    """All edges (n_edges, 2), sorted, and the edges (n_tets, 6) of each tetrahedron."""
    ends = np.sort(tets[:, TET_EDGES].reshape(-1, 2), axis=1)
    size = int(tets.max()) + 1
    keys, index = np.unique(ends[:, 0] * size + ends[:, 1], return_inverse=True)
    return np.stack(np.divmod(keys, size), axis=1), index.reshape(-1, 6)


def find_rows(wanted: Ints, rows: Ints) -> Ints:
    """Place (m,) in `rows` (n, k) of each row of `wanted` (m, k), in whatever order that is.

    Rows are edges or faces by their ends or corners, ascending, each there once; of quadrilaterals
    three corners tell which it is.  What is not there gets any place.
    """
    shape = min(rows.shape[1], 3) * (int(rows.max()) + 1,)
    found, known = (
        np.ravel_multi_index(tuple(of[:, :3].T), shape, mode="clip")
        for of in (np.sort(wanted, axis=1), rows)
    )
    order = np.argsort(known)
    place = np.minimum(np.searchsorted(known, found, sorter=order), known.size - 1)
    return np.asarray(order[place])


def edges_of_triangles(triangles: Ints, edges: Ints) -> Ints:
    """Row in `edges` (as :func:`unique_edges` gives them) of each triangle's edges."""
    return find_rows(triangles[:, _EDGES[3]].reshape(-1, 2), edges).reshape(-1, 3)


_CUBIC = np.array([p for p in itertools.product(range(4), repeat=4) if sum(p) == 3])


def _bernstein_from_samples() -> Floats:
    """(20, 20) matrix from values at the cubic lattice to Bernstein coefficients."""
    at = _CUBIC / 3.0
    weights = np.array([6.0 / np.prod([factorial(k) for k in p]) for p in _CUBIC])
    basis = weights * np.prod(at[:, None, :] ** _CUBIC[None, :, :], axis=2)
    return np.asarray(np.linalg.inv(basis))


def _shape_gradients(at: Floats) -> Floats:
    """Gradients (n, 10, 3) of the ten shape functions at barycentric points (n, 4)."""
    slopes = np.array([[-1.0, -1.0, -1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]])
    corners = (4.0 * at - 1.0)[:, :, None] * slopes
    i, j = TET_EDGES.T
    middles = 4.0 * (at[:, i, None] * slopes[j] + at[:, j, None] * slopes[i])
    return np.concatenate([corners, middles], axis=1)


_FROM_SAMPLES = _bernstein_from_samples()
_GRADIENTS = _shape_gradients(_CUBIC / 3.0)


def jacobian_coefficients(nodes: Floats) -> Floats:
    """Bernstein coefficients (n, 20) of det J of ten-node tetrahedra (n, 10, 3).

    det J is a cubic that lies between its smallest and its largest coefficient, so
    positive coefficients prove it positive everywhere.  Their mean is six volumes.
    """
    jacobians = np.einsum("cni,snj->csij", nodes, _GRADIENTS)
    return np.asarray(np.linalg.det(jacobians) @ _FROM_SAMPLES.T)


def tet_volumes(corners: Floats) -> Floats:
    """Volumes (n,) of straight tetrahedra (n, 4, 3), positive in VTK order."""
    a, b, c = (corners[:, k] - corners[:, 0] for k in (1, 2, 3))
    return np.asarray(np.einsum("ni,ni->n", np.cross(a, b), c) / 6.0)


def smallest_dihedral_angles(corners: Floats) -> Floats:
    """Smallest dihedral angle (n,) in degrees of straight tetrahedra (n, 4, 3)."""
    normals = []
    for face in TET_FACES:
        p, q, r = (corners[:, k] for k in face)
        normal = np.cross(q - p, r - p)
        length = np.linalg.norm(normal, axis=1)
        normals.append(normal / np.maximum(length, np.finfo(float).tiny)[:, None])
    cosines = [-np.einsum("ni,ni->n", m, n) for m, n in itertools.combinations(normals, 2)]
    return np.asarray(np.degrees(np.arccos(np.clip(np.max(cosines, axis=0), -1.0, 1.0))))


def triangle_areas(nodes: Floats) -> Floats:
    """Areas (n,) of six-node triangles (n, 6, 3), corners first, by a rule of degree 5."""
    from skfem import ElementTriP2
    from skfem.quadrature import get_quadrature

    element = ElementTriP2()
    at, weights = get_quadrature(element.refdom, 5)
    slopes = np.stack([element.lbasis(at, i)[1] for i in range(6)])
    along_x, along_y = np.einsum("cni,nds->dcsi", nodes, slopes)
    return np.asarray(np.linalg.norm(np.cross(along_x, along_y), axis=2) @ weights)


#: Largest relative difference between mesh and CAD: where cylinders are involved, …
TOLERANCE = 1e-3

#: … and for the volume of a solid bounded by planes only.  Such a mesh has it to rounding;
#: a difference means that an edge or a corner was cut off.
PLANE_TOLERANCE = 1e-6

#: Smallest dihedral angle (degrees) that passes.
SMALLEST_ANGLE = 3.0

#: Elements whose Jacobians are worked out at a time: bounds the memory.
_CHUNK = 20_000


def check_volumes(
    points: Floats, cells: Ints, labels: Ints, expected: dict[str, float], plane: set[str]
) -> None:
    """Refuse a region whose volume is off, or an element that is turned inside out.

    Of the ten-node tetrahedra `cells` (n_cells, 10) of `points` (n_points, 3) in mm the region is
    ``labels`` (n_cells,): a position in `expected`, the volumes (mm³) from CAD.  `plane` names the
    regions bounded by planes only.

    Raises MeshError naming the region and by how much it is off.
    """
    volumes = np.empty(len(cells))
    for start in range(0, len(cells), _CHUNK):
        coefficients = jacobian_coefficients(points[cells[start : start + _CHUNK]])
        volumes[start : start + _CHUNK] = coefficients.mean(axis=1) / 6.0
        if coefficients.min() <= 0.0:
            raise MeshError("a curved element folds over; choose a smaller edge length")
    for label, (name, volume) in enumerate(expected.items()):
        tolerance = PLANE_TOLERANCE if name in plane else TOLERANCE
        found = float(volumes[labels == label].sum())
        _compare(f"volume of {name}", found, volume, "mm^3", tolerance)


def check_areas(points: Floats, triangles: Ints, face: Ints, faces: Sequence[Face]) -> None:
    """Refuse a CAD face whose triangles do not add up to its area.

    `triangles` (n_triangles, 6) have six nodes each of `points` (n_points, 3) in mm; `face`
    (n_triangles,) is the one of `faces` that each is of.

    Raises MeshError naming the two sides of the face and by how much it is off.
    """
    areas = np.bincount(face, triangle_areas(points[triangles]), minlength=len(faces))
    for i, expected in enumerate(faces):
        sides = " and ".join(sorted(expected.sides))
        _compare(f"area between {sides}", float(areas[i]), expected.area, "mm^2", TOLERANCE)


def _compare(what: str, found: float, expected: float, unit: str, tolerance: float) -> None:
    off = found / expected - 1.0
    if not abs(off) <= tolerance:
        raise MeshError(
            f"the {what} is {found:.6g} {unit} in the mesh but {expected:.6g} {unit} in CAD "
            f"({off * 100:+.2g} %); choose a smaller edge length"
        )


def check_conformity(tets: Ints, n_skin: int) -> None:
    """Refuse a mesh in which a face belongs to more than two cells, or that is torn.

    `tets` (n_cells, 4) are the corners, `n_skin` the number of triangles between regions and
    outside.

    Raises MeshError if faces do not match.
    """
    faces = np.sort(tets[:, TET_FACES].reshape(-1, 3), axis=1)
    _, count = np.unique(faces, axis=0, return_counts=True)
    if count.max() > 2 or np.count_nonzero(count == 1) != n_skin:
        raise MeshError("neighbouring elements do not share their faces; change the edge length")


def check_shape(points: Floats, tets: Ints) -> None:
    """Refuse flat elements; inverted ones have turned volumes (:func:`check_volumes`).

    Raises MeshError saying how many there are.
    """
    poor = is_poor(points, tets)
    if poor.any():
        raise MeshError(
            f"{np.count_nonzero(poor)} elements have angles below {SMALLEST_ANGLE:g} degrees; "
            "choose a smaller edge length"
        )


def is_poor(points: Floats, tets: Ints) -> np.ndarray[tuple[int], np.dtype[np.bool_]]:
    """Mask (n,) of flat tetrahedra; inverted ones have the same angles."""
    return np.asarray(smallest_dihedral_angles(points[tets]) < SMALLEST_ANGLE)
