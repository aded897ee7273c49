"""The two factorisations behind one call give the same answers, and say when they cannot."""

import numpy as np
import pytest
from scipy import sparse

from fem import linear_solver
from fem.linear_solver import SolverError, factorise, refined_solution
from fem.piezo_solid import assemble
from geometry.parameters import Device
from geometry.structured import LEVELS, hexahedral

needs_mkl = pytest.mark.skipif(
    linear_solver.available_solver().startswith("SuperLU"), reason="Intel MKL is not installed"
)


@pytest.fixture(scope="module", params=[False, True], ids=["lossless", "lossy"])
def system(request):
    return assemble(Device(), hexahedral(Device(), LEVELS[0]), lossy=request.param)


@needs_mkl
def test_pardiso_and_superlu_agree(system):
    """The fallback must not change a result: same solution of the saddle point to 1e-9."""
    n = system.size - 3
    matrix = system.stiffness[:n, :n]
    right = np.column_stack([system.tip[:n, 0], system.stiffness[:n, [n + 2]].toarray()[:, 0]])
    a, b = (
        refined_solution(matrix, factorise(matrix, solver=s), right) for s in ("pardiso", "superlu")
    )
    assert np.abs(a - b).max(axis=0) == pytest.approx(0.0, abs=1e-9 * np.abs(a).max())


@needs_mkl
def test_negative_pivots_count_the_potentials():
    """A well-posed piezoelectric matrix has one negative pivot per free potential."""
    system = assemble(Device(), hexahedral(Device(), LEVELS[0]), lossy=False)
    n = system.size - 3
    assert factorise(system.stiffness[:n, :n]).negative_pivots == system.potentials


@pytest.mark.parametrize("solver", ["pardiso", "superlu"])
@pytest.mark.parametrize("dtype", [float, complex])
def test_small_indefinite_system(solver, dtype):
    """Both libraries solve a symmetric indefinite system, also for complex right sides."""
    if solver == "pardiso" and linear_solver.available_solver().startswith("SuperLU"):
        pytest.skip("Intel MKL is not installed")
    rng = np.random.default_rng(7)
    dense = rng.standard_normal((30, 30)) + (
        1j * rng.standard_normal((30, 30)) if dtype is complex else 0
    )
    dense = dense + dense.T
    right = rng.standard_normal((30, 2)) + 1j * rng.standard_normal((30, 2))
    solution = factorise(sparse.csr_matrix(dense), solver=solver).solve(right)
    assert np.allclose(dense @ solution, right, rtol=0, atol=1e-9)  # cond about 1e2


def test_superlu_reports_a_singular_matrix():
    """A mechanism is reported, not solved."""
    with pytest.raises(SolverError, match="singular"):
        factorise(sparse.csr_matrix(np.zeros((3, 3))), solver="superlu")


def test_unknown_library_is_refused(monkeypatch):
    """Asking for Pardiso without MKL is an explained error, and auto falls back."""
    monkeypatch.setattr(linear_solver, "_library", lambda: None)
    with pytest.raises(SolverError, match="not installed"):
        factorise(sparse.identity(3), solver="pardiso")
    assert factorise(sparse.identity(3)).solve(np.ones(3)) == pytest.approx(np.ones(3))
    assert linear_solver.available_solver().startswith("SuperLU")
