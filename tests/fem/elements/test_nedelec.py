"""The second-order edge element: continuity, the curls it has, the gradients it leaves out."""

import numpy as np
import pytest
from skfem import Basis, ElementTetP1, InteriorFacetBasis, MeshTet

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


def test_curls_are_the_curls_of_the_functions():
    """Central differences of the functions give the curls that the element states."""
    element, step = ElementTetEdge2(), 1e-5
    for i in range(14):
        slope = np.zeros((3, 3, POINTS.shape[1]))
        for axis in range(3):
            shift = step * np.eye(3)[:, [axis]]
            ahead, _ = element.lbasis(POINTS + shift, i)
            behind, _ = element.lbasis(POINTS - shift, i)
            slope[axis] = (ahead - behind) / (2.0 * step)
        curl = [slope[1, 2] - slope[2, 1], slope[2, 0] - slope[0, 2], slope[0, 1] - slope[1, 0]]
        # quadratic functions: the difference quotient is exact but for rounding / step
        np.testing.assert_allclose(curl, element.lbasis(POINTS, i)[1], atol=1e-9)


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


def test_global_kernel_is_the_gradients_of_nodal_functions():
    """On a mesh the curl-curl matrix loses exactly one rank per vertex but one."""
    from skfem import BilinearForm
    from skfem.helpers import dot

    mesh = sheared_mesh()
    basis = Basis(mesh, ElementTetEdge2(), intorder=4)
    matrix = BilinearForm(lambda u, v, _: dot(u.curl, v.curl)).assemble(basis).toarray()
    size = np.linalg.eigvalsh(matrix)
    nodal = Basis(mesh, ElementTetP1()).N
    assert np.sum(size < 1e-10 * size[-1]) == nodal - 1


def test_unsorted_cells_are_refused():
    """Without increasing corners signs would be wrong; the element says so."""
    mesh = MeshTet().refined(1)
    assert np.any(np.diff(mesh.t, axis=0) < 0)
    with pytest.raises(ValueError, match="increasing order"):
        Basis(mesh, ElementTetEdge2())
