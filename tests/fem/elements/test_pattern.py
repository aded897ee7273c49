"""Whole-mesh assembly against scikit-fem's, form by form."""

import numpy as np
import pytest
from skfem import Basis, BilinearForm, ElementTetP2, LinearForm
from skfem.helpers import dot, mul

from tactgen.fem.elements.skfem_mesh import ElementTetEdge2, tet_rule
from tactgen.fem.magnetics.problem_3d import MagneticSolid, VectorPotential, gradient_kernel, sample
from tactgen.validation.evidence.cases.ball import sphere_mesh

RULE = tet_rule()
TENSOR = np.array([[2.0, 0.3, -0.1], [0.3, 1.0, 0.2], [-0.1, 0.2, 4.0]])


@pytest.fixture(scope="module", params=[False, True], ids=["straight", "curved"])
def solid(request):
    mesh = sphere_mesh(1, curved=request.param)
    # every wall open: all unknowns are free
    return sample(MagneticSolid(mesh, {}, np.zeros_like, flux_normal=tuple(mesh.faces)))


def compare(kernel, basis, derivative):
    """Matrix, right side and field of one kernel; scikit-fem takes the same quadrature."""
    shape = kernel.field(np.zeros(kernel.size)).shape
    matrix = kernel.matrix(np.broadcast_to(TENSOR, (*shape, 3)))
    form = BilinearForm(lambda u, v, _: dot(mul(TENSOR, derivative(u)), derivative(v)))
    expected = form.assemble(basis)
    scale = np.abs(expected).max()
    assert np.abs(matrix - expected).max() < 1e-12 * scale

    vector = np.array([1.0, -2.0, 0.5])
    right = kernel.functional(np.broadcast_to(vector, shape))
    known = LinearForm(lambda v, _: np.einsum("i,i...->...", vector, derivative(v))).assemble(basis)
    np.testing.assert_allclose(right, known, atol=1e-12 * np.abs(known).max())

    x = np.random.default_rng(5).standard_normal(kernel.size)
    field = derivative(basis.interpolate(x))
    np.testing.assert_allclose(kernel.field(x), np.moveaxis(field, 0, -1), atol=1e-10)


def test_curl_kernel_is_scikit_fems_curl(solid):
    """∫ curl v · T curl u, ∫ t · curl v and curl u agree to rounding, on curved cells too."""
    basis = Basis(solid.domain, ElementTetEdge2(), mapping=solid.mapping, quadrature=RULE)
    compare(VectorPotential(solid)._curl, basis, lambda u: u.curl)


def test_gradient_kernel_is_scikit_fems_gradient(solid):
    """The same for gradients of quadratic nodal functions."""
    basis = Basis(solid.domain, ElementTetP2(), mapping=solid.mapping, quadrature=RULE)
    kernel = gradient_kernel(solid, basis.element_dofs.T, np.arange(basis.N))
    compare(kernel, basis, lambda u: u.grad)
