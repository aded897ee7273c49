"""Ten-node tetrahedra: mid-edge nodes, Jacobians that are positive everywhere, volumes, areas.

Plain arrays in any unit of length; knows nothing of regions or CAD.
"""

from __future__ import annotations

import itertools
from math import factorial

import numpy as np

from tactgen.geometry.arrays import Floats, Ints

#: Corners of the six edges of a tetrahedron, in the order of VTK's mid-edge nodes.
TET_EDGES = np.array([[0, 1], [1, 2], [2, 0], [0, 3], [1, 3], [2, 3]])

#: Corners of the three edges of a triangle, in the order of VTK's mid-edge nodes.
TRIANGLE_EDGES = np.array([[0, 1], [1, 2], [2, 0]])


def unique_edges(tets: Ints) -> tuple[Ints, Ints]:
    """Return all edges (n_edges, 2), sorted, and the edges (n_tets, 6) of each tetrahedron."""
    ends = np.sort(tets[:, TET_EDGES].reshape(-1, 2), axis=1)
    edges, index = np.unique(ends, axis=0, return_inverse=True)
    return edges, index.reshape(-1, 6)


def edges_of_triangles(triangles: Ints, edges: Ints) -> Ints:
    """Return the row in `edges` (as :func:`unique_edges` gives them) of each triangle's edges."""
    ends = np.sort(triangles[:, TRIANGLE_EDGES].reshape(-1, 2), axis=1)
    stride = int(edges.max()) + 1
    keys = edges[:, 0] * stride + edges[:, 1]
    return np.searchsorted(keys, ends[:, 0] * stride + ends[:, 1]).reshape(-1, 3)


_CUBIC = np.array([p for p in itertools.product(range(4), repeat=4) if sum(p) == 3])


def _bernstein_from_samples() -> Floats:
    """Return the (20, 20) matrix from values at the cubic lattice to Bernstein coefficients."""
    at = _CUBIC / 3.0
    weights = np.array([6.0 / np.prod([factorial(k) for k in p]) for p in _CUBIC])
    basis = weights * np.prod(at[:, None, :] ** _CUBIC[None, :, :], axis=2)
    return np.asarray(np.linalg.inv(basis))


def _shape_gradients(at: Floats) -> Floats:
    """Return gradients (n, 10, 3) of the ten shape functions at barycentric points (n, 4)."""
    slopes = np.array([[-1.0, -1.0, -1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]])
    corners = (4.0 * at - 1.0)[:, :, None] * slopes
    i, j = TET_EDGES.T
    middles = 4.0 * (at[:, i, None] * slopes[j] + at[:, j, None] * slopes[i])
    return np.concatenate([corners, middles], axis=1)


_FROM_SAMPLES = _bernstein_from_samples()
_GRADIENTS = _shape_gradients(_CUBIC / 3.0)


def jacobian_coefficients(nodes: Floats) -> Floats:
    """Return the Bernstein coefficients (n, 20) of det J of ten-node tetrahedra (n, 10, 3).

    det J is a cubic that lies between its smallest and its largest coefficient, so
    positive coefficients prove it positive everywhere.  Their mean is six volumes.
    """
    jacobians = np.einsum("cni,snj->csij", nodes, _GRADIENTS)
    return np.asarray(np.linalg.det(jacobians) @ _FROM_SAMPLES.T)


def tet_volumes(corners: Floats) -> Floats:
    """Return the volumes (n,) of straight tetrahedra (n, 4, 3), positive in VTK order."""
    a, b, c = (corners[:, k] - corners[:, 0] for k in (1, 2, 3))
    return np.asarray(np.einsum("ni,ni->n", np.cross(a, b), c) / 6.0)


def smallest_dihedral_angles(corners: Floats) -> Floats:
    """Return the smallest dihedral angle (n,) in degrees of straight tetrahedra (n, 4, 3)."""
    normals = []
    for face in ([0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]):
        p, q, r = (corners[:, k] for k in face)
        normal = np.cross(q - p, r - p)
        length = np.linalg.norm(normal, axis=1)
        normals.append(normal / np.maximum(length, np.finfo(float).tiny)[:, None])
    cosines = [-np.einsum("ni,ni->n", m, n) for m, n in itertools.combinations(normals, 2)]
    return np.asarray(np.degrees(np.arccos(np.clip(np.max(cosines, axis=0), -1.0, 1.0))))


# Radon's rule, exact to degree 5.
_A, _B = (6.0 - np.sqrt(15.0)) / 21.0, (6.0 + np.sqrt(15.0)) / 21.0
_RADON = np.array(
    [
        *[[1 / 3, 1 / 3]],
        *[[_A, _A], [1 - 2 * _A, _A], [_A, 1 - 2 * _A]],
        *[[_B, _B], [1 - 2 * _B, _B], [_B, 1 - 2 * _B]],
    ]
)
_RADON_WEIGHTS = np.array(
    [9 / 80] + 3 * [(155 - np.sqrt(15)) / 2400] + 3 * [(155 + np.sqrt(15)) / 2400]
)


def triangle_areas(nodes: Floats) -> Floats:
    """Return the areas (n,) of six-node triangles (n, 6, 3)."""
    x, y = _RADON.T
    z = 1.0 - x - y
    zero = np.zeros_like(x)
    d_x = [1 - 4 * z, 4 * x - 1, zero, 4 * (z - x), 4 * y, -4 * y]
    d_y = [1 - 4 * z, zero, 4 * y - 1, -4 * x, 4 * x, 4 * (z - y)]
    along_x = np.einsum("cni,ns->csi", nodes, np.array(d_x))
    along_y = np.einsum("cni,ns->csi", nodes, np.array(d_y))
    return np.asarray(np.linalg.norm(np.cross(along_x, along_y), axis=2) @ _RADON_WEIGHTS)
