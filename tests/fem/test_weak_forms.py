"""One assembler against scikit-fem's forms and against the assembly of each room."""

import numpy as np
import pytest
from skfem import Basis, BilinearForm, ElementQuadP, ElementTetP2, ElementVector, MeshQuad, MeshTet
from skfem.helpers import ddot, dot, grad, sym_grad

from tactgen.fem.elements.skfem_mesh import ElementTetEdge2
from tactgen.fem.magnetics.axisymmetric_space import discretise
from tactgen.fem.magnetics.problem_3d import with_sorted_corners
from tactgen.fem.piezo.system import materials
from tactgen.fem.piezo.tetrahedra import SkfemBody
from tactgen.fem.weak_forms import (
    GIGAVOLT,
    assemble,
    piezo_strain,
    piezo_tensor,
    section_flux,
    strain,
)
from tactgen.geometry.device.magnetisation import MU0
from tactgen.geometry.device.parameters import Device
from tactgen.geometry.meshing.mesh import Mesh
from tactgen.geometry.reluctance.section_grid import Region, graded_grid


@pytest.fixture(scope="module")
def mesh():
    """Two ceramic layers and a shim, distorted inside."""
    x, y, z = np.linspace(-3e-4, 3e-4, 4), np.linspace(-1e-3, 1e-3, 3), np.linspace(0.0, 4e-3, 4)
    plain = MeshTet.init_tensor(x, y, z)
    inner = np.setdiff1d(np.arange(plain.nvertices), plain.boundary_nodes())
    plain.p[:, inner] += np.random.default_rng(3).uniform(-4e-5, 4e-5, (3, inner.size))
    return plain


def difference(one, other):
    return abs(one - other).max() / abs(other).max()


def test_piezoelectric_solid_equals_the_product(mesh):
    """Stiffness and mass node by node over (u, φ), as `cad` has them."""
    layers = ("piezo_bottom", "shim", "piezo_top")
    device = Device()
    known = materials(device, layers, device.piezo.ceramic(), lossy=False)
    layer = np.searchsorted([-1e-4, 1e-4], mesh.p[0, mesh.t].mean(axis=0))
    body = SkfemBody(Mesh(mesh.p.T, mesh.t.T, "tetra", layer, layers, {}), known, GIGAVOLT)
    basis = Basis(mesh, ElementVector(ElementTetP2()) * ElementTetP2(), intorder=4)
    stiffness = mass = 0.0
    for number, material in enumerate(known.values()):
        part = basis.with_elements(np.flatnonzero(layer == number))
        stiffness += assemble(part, piezo_strain, piezo_tensor(material))
        mass += assemble(part, lambda u, _: np.asarray(u), material.density * np.eye(3))
    order = np.concatenate([basis.nodal_dofs.T.ravel(), basis.edge_dofs.T.ravel()])
    own_stiffness, own_mass = body.matrices
    assert difference(stiffness[order][:, order], own_stiffness) < 1e-14
    assert difference(mass[order][:, order], own_mass) < 1e-14


def test_elasticity_and_poisson_equal_scikit_fem(mesh):
    basis = Basis(mesh, ElementVector(ElementTetP2()), intorder=2)
    once = np.diag([1.0, 1.0, 1.0, 0.5, 0.5, 0.5])  # shears of Voigt are doubled
    form = BilinearForm(lambda u, v, _: ddot(sym_grad(u), sym_grad(v)))
    ours = assemble(basis, strain, once)
    assert difference(ours, form.assemble(basis)) < 1e-14
    scalar = basis.with_element(ElementTetP2())
    laplace = BilinearForm(lambda u, v, _: dot(grad(u), grad(v))).assemble(scalar)
    assert difference(assemble(scalar, lambda u: u.grad, np.eye(3)), laplace) < 1e-14


def test_curl_curl_of_edge_elements_equals_scikit_fem(mesh):
    cells = Mesh(mesh.p.T, mesh.t.T, "tetra", np.zeros(mesh.nelements, dtype=int), ("air",), {})
    sorted_mesh = MeshTet(mesh.p, np.ascontiguousarray(with_sorted_corners(cells).cells.T))
    basis = Basis(sorted_mesh, ElementTetEdge2(), intorder=4)
    form = BilinearForm(lambda a, v, _: dot(a.curl, v.curl)).assemble(basis)
    assert difference(assemble(basis, lambda a: a.curl, np.eye(3)), form) < 1e-14


def test_half_section_equals_the_product():
    """The Hessian in air, order 4, over the unknowns that the outer wall does not hold at 0."""
    grid = graded_grid((Region("ring", (1e-3, 2e-3), (-1e-3, 1e-3), turns=10.0),), 10e-3)
    own = discretise(grid, 4)
    basis = Basis(MeshQuad.init_tensor(grid.r, grid.z), ElementQuadP(4), intorder=10)
    radius = np.asarray(basis.global_coordinates())[0]
    tensor = np.eye(2)[:, :, None, None] * 2.0 * np.pi * radius / MU0
    ours = assemble(basis, section_flux(radius), tensor)[own.free][:, own.free]
    assert difference(ours, own.pattern.of_entries(own.vacuum_entries)) < 1e-13
