"""The second-order edge element: continuity, the curls it has, the gradients it leaves out."""

import numpy as np
import pytest
from skfem import Basis, InteriorFacetBasis, MeshTet
from skfem.element import ElementTetN1

from tactgen.fem.elements.skfem_mesh import ElementTetEdge2

POINTS = np.random.default_rng(1).dirichlet(np.ones(4), 40).T[:3]


def sheared_mesh():
    """48 tetrahedra of several shapes, corners in increasing order."""
    mesh = MeshTet().refined(1)
    points = mesh.p.copy()
    inner = np.all((points > 0.01) & (points < 0.99), axis=0)
    points[:, inner] += 0.07 * np.array([[1.0], [-0.6], [0.8]])
    shear = np.array([[1.0, 0.3, 0.1], [0.0, 0.8, -0.2], [0.2, 0.0, 1.3]])
    return MeshTet(shear @ points, np.sort(mesh.t, axis=0))


def functions():
    """All functions and curls (14, 3 * n_points) on the reference cell."""
    pairs = [ElementTetEdge2().lbasis(POINTS, i) for i in range(14)]
    return tuple(np.array([p[k].ravel() for p in pairs]) for k in (0, 1))


def test_tangential_parts_match_across_every_face():
    """H(curl) conformity: a random field jumps across no interior face but in its normal part."""
    mesh = sheared_mesh()
    sides = [InteriorFacetBasis(mesh, ElementTetEdge2(), side=side) for side in (0, 1)]
    x = np.random.default_rng(2).standard_normal(sides[0].N)
    jump = sides[0].interpolate(x) - sides[1].interpolate(x)
    tangential = np.cross(jump, sides[0].normals, axis=0)
    normal = np.einsum("ief,ief->ef", jump, sides[0].normals)
    assert np.abs(normal).max() > 0.1
    assert np.abs(tangential).max() < 1e-12 * np.abs(normal).max()


def test_curls_are_all_linear_solenoidal_fields():
    """14 independent functions whose curls span the 11 linear fields of zero divergence.

    So leaving out the six gradients of the full second-order element costs B nothing.
    """
    values, curls = functions()
    assert np.linalg.matrix_rank(values, tol=1e-9) == 14
    assert np.linalg.matrix_rank(curls, tol=1e-9) == 11
    x, y, z = POINTS
    zero, one = np.zeros_like(x), np.ones_like(x)
    fields = [
        (one, zero, zero), (zero, one, zero), (zero, zero, one), (y, zero, zero), (z, zero, zero),
        (zero, x, zero), (zero, z, zero), (zero, zero, x), (zero, zero, y), (x, -y, zero),
        (x, zero, -z),
    ]  # fmt: skip
    wanted = np.array([np.ravel(f) for f in fields])
    both = np.concatenate([curls, wanted])
    assert np.linalg.matrix_rank(both, tol=1e-9) == 11


def test_contains_the_lowest_order_element():
    """Its first six functions are those that scikit-fem has as the lowest-order element."""
    for i in range(6):
        for mine, theirs in zip(
            ElementTetEdge2().lbasis(POINTS, i), ElementTetN1().lbasis(POINTS, i), strict=True
        ):
            theirs = np.broadcast_to(np.asarray(theirs, dtype=float), mine.shape)
            np.testing.assert_allclose(mine, theirs, atol=1e-14)


def test_unsorted_cells_are_refused():
    """Without increasing corners signs would be wrong; the element says so."""
    mesh = MeshTet().refined(1)
    assert np.any(np.diff(mesh.t, axis=0) < 0)
    with pytest.raises(ValueError, match="increasing order"):
        Basis(mesh, ElementTetEdge2())
