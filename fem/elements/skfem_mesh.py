"""From the project's mesh value to a scikit-fem mesh, names kept.

Only a change of container; nothing is computed.
"""

from __future__ import annotations

import itertools
from typing import Any

import numpy as np
from skfem.element import DiscreteField
from skfem.element.element_hcurl import ElementHcurl
from skfem.refdom import RefTet

from tactgen.geometry.arrays import Floats, Ints
from tactgen.geometry.meshing.mesh import TET_EDGES, Mesh, find_rows

#: VTK's eight corners in scikit-fem's order.
_HEX_ORDER = [0, 4, 3, 1, 7, 5, 2, 6]


def to_skfem(mesh: Mesh) -> Any:
    """Scikit-fem mesh with `mesh.regions` as subdomains and `mesh.faces` as boundaries.

    Curved tetrahedra become MeshTet2 with their mid-edge nodes kept.
    """
    from skfem import MeshHex, MeshTet

    if mesh.kind == "hexahedron":
        plain = MeshHex(
            np.ascontiguousarray(mesh.points.T), np.ascontiguousarray(mesh.cells.T[_HEX_ORDER])
        )
        renumber = np.arange(mesh.points.shape[0])
    else:
        corners, cells = np.unique(mesh.cells[:, :4], return_inverse=True)
        plain = MeshTet(
            np.ascontiguousarray(mesh.points[corners].T),
            np.ascontiguousarray(cells.reshape(-1, 4).T),
        )
        renumber = np.full(mesh.points.shape[0], -1)
        renumber[corners] = np.arange(corners.size)
    named = plain.with_subdomains({r: mesh.cells_of(r) for r in mesh.regions}).with_boundaries(
        {name: _facets(plain, renumber[faces]) for name, faces in mesh.faces.items()}
    )
    return _curved(named, mesh, cells.reshape(-1, 4)) if mesh.kind == "tetra10" else named


def _facets(plain: Any, faces: Ints) -> Ints:
    """Facet number of each face given by its corners."""
    if faces.size == 0:
        return np.zeros(0, dtype=np.int64)
    facets = np.sort(plain.facets, axis=0).T
    at = find_rows(faces, facets)
    if not np.array_equal(facets[at], np.sort(faces, axis=1)):
        raise ValueError("a named face is not a face of the mesh")
    return at


def _curved(named: Any, mesh: Mesh, corners: Ints) -> Any:
    """Give a tetrahedral mesh its mid-edge nodes; `corners` (n, 4) are those of its cells."""
    from dataclasses import replace

    from skfem import MeshTet2

    quadratic = MeshTet2.from_mesh(named)
    points = quadratic.doflocs.copy()
    # scikit-fem may have permuted the corners of an element: find an edge by its ends
    edges = find_rows(corners[:, TET_EDGES].reshape(-1, 2), np.sort(named.edges, axis=0).T)
    points[:, quadratic.dofs.edge_dofs[0, edges]] = mesh.points[mesh.cells[:, 4:].ravel()].T
    curved = replace(quadratic, doflocs=points)
    return curved.with_subdomains(named.subdomains).with_boundaries(named.boundaries)


#: Barycentric coordinate that three corners share, and weight (N. J. Walkington, Quadrature
#: on simplices of arbitrary dimension, Carnegie Mellon University 2000; 14 points).
_THREE_ALIKE = (
    (0.31088591926330060980, 0.11268792571801585080),
    (0.092735250310891226402, 0.073493043116361949544),
)
#: Barycentric coordinate that two corners share, the others sharing the rest, and weight.
_TWO_ALIKE = (0.045503704125649649492, 0.042546020777081466438)


def tet_rule() -> tuple[Floats, Floats]:
    """Points (3, 14) on the reference tetrahedron and weights (14,), their sum 1/6."""
    barycentric, weights = [], []
    for shared, weight in _THREE_ALIKE:
        for corner in range(4):
            barycentric.append(np.where(np.arange(4) == corner, 1.0 - 3.0 * shared, shared))
            weights.append(weight)
    shared, weight = _TWO_ALIKE
    for pair in itertools.combinations(range(4), 2):
        barycentric.append(np.where(np.isin(np.arange(4), pair), shared, 0.5 - shared))
        weights.append(weight)
    return np.array(barycentric).T[1:], np.array(weights) / 6.0


#: ∇λ on the reference tetrahedron, one row per corner.
SLOPES = np.array([[-1.0, -1.0, -1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]])


class ElementTetEdge2(ElementHcurl):  # type: ignore[misc]
    """One unknown per edge and two per face; see the module's text.

    The mesh must have its cells' corners in increasing order.
    """

    edge_dofs = 1
    facet_dofs = 2
    maxdeg = 2
    dofnames = ("u^t", "u^f1", "u^f2")
    doflocs = np.concatenate(
        [
            np.array([RefTet.p[:, e].mean(axis=1) for e in RefTet.edges]),
            np.repeat([RefTet.p[:, f].mean(axis=1) for f in RefTet.facets], 2, axis=0),
        ]
    )
    refdom = RefTet

    def lbasis(self, X: Floats, i: int) -> tuple[Floats, Floats]:
        """Function `i` and its curl, each (3, ...), at reference points X (3, ...)."""
        if i < 6:
            return _whitney(X, *RefTet.edges[i])
        if i >= 14:
            self._index_error()
        a, b, c = RefTet.facets[(i - 6) // 2]
        factor, edge = (c, (a, b)) if i % 2 == 0 else (a, (b, c))
        value, curl = _whitney(X, *edge)
        slope = SLOPES[factor].reshape((3,) + (1,) * (X.ndim - 1))
        lam = _barycentric(X, factor)
        return lam * value, lam * curl + np.cross(slope, value, axis=0)

    def gbasis(self, mapping: Any, X: Floats, i: int, tind: Any = None) -> tuple[Any]:
        """Function `i` on the cells: covariant values, contravariant curls.

        Raises ValueError if the corners of the mesh's cells are not in increasing order.
        """
        if np.any(np.diff(mapping.mesh.t, axis=0) < 0):
            raise ValueError("edge elements need cells whose corners are in increasing order")
        value, curl = self.lbasis(X, i)
        derivative, inverse = mapping.DF(X, tind), mapping.invDF(X, tind)
        points = "iq" if X.ndim == 2 else "ieq"
        curls = np.einsum(f"jieq,{points}->jeq", derivative, curl)
        return (
            DiscreteField(
                value=np.einsum(f"ijeq,{points}->jeq", inverse, value),
                curl=curls / mapping.detDF(X, tind),
            ),
        )


def _barycentric(X: Floats, corner: int) -> Floats:
    return np.asarray(1.0 - X.sum(axis=0) if corner == 0 else X[corner - 1])


def _whitney(X: Floats, i: int, j: int) -> tuple[Floats, Floats]:
    """Λi ∇λj − λj ∇λi and its curl 2 ∇λi × ∇λj."""
    shape = (3,) + (1,) * (X.ndim - 1)
    a, b = SLOPES[i].reshape(shape), SLOPES[j].reshape(shape)
    value = _barycentric(X, i) * b - _barycentric(X, j) * a
    return value, np.broadcast_to(2.0 * np.cross(a, b, axis=0), X.shape)
