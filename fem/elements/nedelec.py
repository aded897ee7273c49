"""Second-order edge element on tetrahedra, without the gradients that a curl cannot see.

Nédélec's first kind of second order (Numer. Math. 35 (1980) 315) has 20 functions on a
tetrahedron.  Six of them may be chosen as gradients of the quadratic edge bubbles
λi λj; their curl is nothing, so a magnetostatic field does not depend on them.  Leaving
them out gives 14 functions, with i < j < k the corners in order of global number:

    one per edge     w_ij = λi ∇λj − λj ∇λi
    two per face     λk w_ij   and   λi w_jk

Their curls still span all 11 solenoidal linear fields, so B = curl A is the same as with
20, with a third fewer unknowns.  Because local corners are numbered as the global ones
are, tangential traces match across faces with no signs.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from skfem.element import DiscreteField
from skfem.element.element_hcurl import ElementHcurl
from skfem.refdom import RefTet

from tactgen.geometry.arrays import Floats

#: ∇λ on the reference tetrahedron, one row per corner.
_SLOPES = np.array([[-1.0, -1.0, -1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]])


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
        slope = _SLOPES[factor].reshape((3,) + (1,) * (X.ndim - 1))
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
    a, b = _SLOPES[i].reshape(shape), _SLOPES[j].reshape(shape)
    value = _barycentric(X, i) * b - _barycentric(X, j) * a
    return value, np.broadcast_to(2.0 * np.cross(a, b, axis=0), X.shape)
