"""The two factorisations behind one call give the same answers, and say when they cannot."""

import gc
import importlib.metadata
import sys
import weakref
from collections import OrderedDict
from types import SimpleNamespace

import numpy as np
import pytest
from scipy import sparse
from scipy.sparse.linalg import splu

from tactgen.fem.piezo.solid import assemble
from tactgen.fem.solvers import linear_solver, pardiso
from tactgen.fem.solvers.linear_solver import Factor, SolverError, factorise, refined_solution
from tactgen.fem.solvers.pardiso import nested_dissection
from tactgen.geometry.bimorph.bricks import bimorph_bricks
from tactgen.geometry.device.parameters import Device

without_mkl = linear_solver.available_solver().startswith("SuperLU")
needs_mkl = pytest.mark.skipif(without_mkl, reason="Intel MKL is not installed")
both = pytest.mark.usefixtures("solver")


@pytest.fixture(params=[pytest.param("pardiso", marks=needs_mkl), "superlu"])
def solver(request, monkeypatch):
    """Take either library."""
    if request.param == "superlu":
        monkeypatch.setattr(linear_solver, "mkl", lambda: None)


@pytest.fixture(scope="module", params=[False, True], ids=["lossless", "lossy"])
def system(request, few_bricks):
    return assemble(Device(), bimorph_bricks(Device(), few_bricks[1]), lossy=request.param)


def piezo_like(n=12, seed=5):
    """A random saddle point of the piezoelectric kind: [[A, B], [Bᵀ, −C]], A and C definite."""
    rng = np.random.default_rng(seed)
    a, c = (m @ m.T + np.eye(n) for m in rng.standard_normal((2, n, n)))
    b = rng.standard_normal((n, n))
    return np.block([[a, b], [b.T, -c]])


def laplacian(*shape):
    """The Laplacian on a grid that nothing holds: constants are in its null space."""
    total = sparse.csr_matrix((1, 1))
    for n in shape:
        line = sparse.diags([-np.ones(n - 1), -np.ones(n - 1)], [-1, 1])
        line = line - sparse.diags(np.asarray(line.sum(axis=1)).ravel())
        total = sparse.kronsum(line, total)
    return sparse.csr_matrix(total)


@pytest.mark.parametrize("starts", [[0, 3, 99_990, 100_010], [0, 250_000], [0, 1, 2, 3], [0, 0]])
def test_blocks_of_rows_are_all_rows_once(starts):
    """Every row in one block, no block without rows, also where a block ends in the last row."""
    blocks = list(linear_solver.row_blocks(np.array(starts)))
    assert all(first < last for first, last in blocks)
    assert [row for first, last in blocks for row in range(first, last)] == [
        *range(len(starts) - 1)
    ]


@needs_mkl
def test_pardiso_and_superlu_agree(system, monkeypatch):
    """The fallback must not change a result: same solution of the saddle point to 1e-9."""
    matrix = system.stiffness.inner
    right = np.column_stack([system.tip[:-3, 0], system.stiffness.border[:, -1]])
    a = refined_solution(matrix, factorise(matrix), right)
    monkeypatch.setattr(linear_solver, "mkl", lambda: None)
    b = refined_solution(matrix, factorise(matrix), right)
    assert np.abs(a - b).max(axis=0) == pytest.approx(0.0, abs=1e-9 * np.abs(a).max())


@both
@pytest.mark.parametrize("dtype", [float, complex])
def test_small_indefinite_system(dtype):
    """Both libraries solve a symmetric indefinite system, also for complex right sides."""
    rng = np.random.default_rng(7)
    dense = rng.standard_normal((30, 30)) + (
        1j * rng.standard_normal((30, 30)) if dtype is complex else 0
    )
    dense = dense + dense.T
    right = rng.standard_normal((30, 2)) + 1j * rng.standard_normal((30, 2))
    solution = factorise(sparse.csr_matrix(dense)).solve(right)
    assert np.allclose(dense @ solution, right, rtol=0, atol=1e-9)  # cond about 1e2


@both
@pytest.mark.parametrize("exponent", [-10, 0, 10])
@pytest.mark.parametrize("loss", [0.0, 0.02])
def test_unit_of_a_block_does_not_matter(exponent, loss):
    """The potential in units of 1e-10 to 1e10: every unknown right to 1e-9 of its own size."""
    dense = piezo_like() * (1.0 + 1j * loss)
    n = dense.shape[0]
    exact = np.random.default_rng(2).uniform(0.5, 1.0, n)
    unit = np.where(np.arange(n) < n // 2, 1.0, 10.0**exponent)
    factor = factorise(sparse.csr_matrix(unit[:, None] * dense * unit))
    found = unit * factor.solve(unit * (dense @ exact))
    # condition below 1e4 once balanced
    assert found == pytest.approx(exact, rel=1e-9)


@both
@pytest.mark.parametrize("zeros", [False, True], ids=["absent", "stored"])
def test_multipliers(zeros):
    """Constraints put zeros on the diagonal, whether stored or not."""
    a = laplacian(6, 5)
    n = a.shape[0]
    b = sparse.csr_matrix(np.eye(n)[:, :7])
    corner = sparse.csr_matrix((np.zeros(7), (range(7), range(7))), shape=(7, 7)) if zeros else None
    matrix = sparse.bmat([[a, b], [b.T, corner]], format="csr")
    exact = np.linspace(-1.0, 1.0, n + 7)
    assert factorise(matrix).solve(matrix @ exact) == pytest.approx(exact, abs=1e-11)


@both
@pytest.mark.parametrize("definite", [False, True])
@pytest.mark.parametrize(
    "matrix",
    [
        sparse.diags([1.0, 0.0, 2.0]),
        sparse.csr_matrix(np.ones((2, 2))),
        laplacian(2000),
        laplacian(9, 8, 7),
        sparse.block_diag([2.0 * sparse.identity(40), 1e-6 * laplacian(5, 5, 5)]),
        sparse.csr_matrix(np.diag([1.0, np.nan])),
        (1.0 + 0.01j) * laplacian(9, 8, 7),
    ],
    ids=["zero row", "rank one", "line", "space", "floating part", "not a number", "lossy"],
)
def test_singular_matrices_are_refused(definite, matrix):
    """A mechanism is reported, not solved; also where rounding hides the zero pivot."""
    words = "singular" if np.isfinite(matrix.sum()) else "not finite"
    with pytest.raises(SolverError, match=words):
        factorise(sparse.csr_matrix(matrix), definite=definite)


@both
def test_a_rigid_body_is_refused(few_bricks):
    """A bimorph whose base is free has rigid motions."""
    system = assemble(Device(), bimorph_bricks(Device(), few_bricks[1]), lossy=False)
    with pytest.raises(SolverError, match="singular"):
        factorise(system.stiffness.with_base(np.zeros((2, 2))))


@needs_mkl
def test_order_found_for_a_pattern():
    """Every unknown comes once, and far less is filled in than along the grid."""
    matrix = sparse.csr_matrix(laplacian(10, 10, 12) + 0.1 * sparse.identity(1200))
    upper = sparse.triu(matrix, format="csr")
    order = nested_dissection(upper.indptr, upper.indices)
    assert np.array_equal(np.sort(order), np.arange(1200))
    exact = np.sin(np.arange(1200.0))
    assert factorise(matrix, order=order).solve(matrix @ exact) == pytest.approx(exact, abs=1e-12)

    def filled(places):
        lu = splu(matrix[places][:, places].tocsc(), permc_spec="NATURAL", diag_pivot_thresh=0.0)
        return lu.L.nnz

    assert filled(order) < 0.6 * filled(np.arange(1200))


@needs_mkl
def test_an_ordering_is_found_once_and_changes_no_bit(monkeypatch):
    """A second factor of the same pattern takes the first one's ordering; few are kept."""
    orders = OrderedDict()
    monkeypatch.setattr(pardiso, "_ORDERS", orders)
    monkeypatch.setattr(pardiso, "_MOST_ORDERS", 2)
    right = np.sin(np.arange(60.0))

    def solution(n, **known):
        grid = laplacian(n, 60 // n) + 0.1 * sparse.identity(60)
        return factorise(grid, **known).solve(right)

    assert solution(6, order=np.arange(60)) == pytest.approx(solution(6), rel=1e-12)
    (found,) = orders.values()
    assert np.array_equal(np.sort(found), np.arange(60))
    assert not np.array_equal(found, np.arange(60))  # the one stated belongs to its caller
    assert np.array_equal(solution(6), solution(6, order=found))
    (again,) = orders.values()
    assert again is found
    for n in (5, 4, 3):
        solution(n)
    assert len(orders) == 2


@needs_mkl
def test_rows_of_the_same_lengths_have_an_ordering_of_their_own(monkeypatch):
    """A chain and a star: the columns tell them apart."""
    orders = OrderedDict()
    monkeypatch.setattr(pardiso, "_ORDERS", orders)
    chain = np.eye(9) + 0.1 * np.eye(9, k=1)
    star = np.eye(9)
    star[:-1, -1] = 0.1
    for upper in (chain, star):
        factorise(sparse.csr_matrix(upper + np.triu(upper, 1).T))
    assert len(orders) == 2


@both
def test_said_to_be_definite_but_is_not():
    """The answer is right all the same, and the negative pivots tell."""
    matrix, exact = sparse.csr_matrix(piezo_like()), np.arange(24.0)
    factor = factorise(matrix, definite=True)
    assert factor.solve(matrix @ exact) == pytest.approx(exact, abs=1e-9)
    assert factor.negative_pivots in (12, None)


@both
@pytest.mark.parametrize("definite", [False, True])
def test_refactorise(definite, monkeypatch):
    """Another matrix of the pattern, definite or not, gives what a fresh factor does."""
    base, right = laplacian(15, 14), np.arange(210.0)
    first, *others = (base + s * sparse.identity(210) for s in (0.1, 7.0, -0.03))
    factor = factorise(first, definite=definite)
    for other in others:
        with monkeypatch.context() as patch:
            patch.setattr(Factor, "_order", None)  # not called
            factor.refactorise(other)
        fresh = factorise(other)
        assert factor.solve(right) == pytest.approx(fresh.solve(right), rel=1e-10)
        assert factor.negative_pivots == fresh.negative_pivots


@both
def test_refactorise_another_pattern():
    """Another pattern or type of number is ordered anew instead of misread."""
    factor = factorise(laplacian(6, 6) + sparse.identity(36), definite=True)
    exact = np.linspace(1.0, 2.0, 40)
    other = laplacian(8, 5) + sparse.identity(40)
    for matrix in (other, 1j * other, other, sparse.identity(40, format="csr")):
        factor.refactorise(matrix)
        assert factor.solve(matrix @ exact) == pytest.approx(exact, rel=1e-12)


@both
def test_refactorise_a_singular_matrix():
    """It is refused like a new one."""
    factor = factorise(laplacian(6, 6) + sparse.identity(36), definite=True)
    with pytest.raises(SolverError, match="singular"):
        factor.refactorise(laplacian(6, 6))


@needs_mkl
def test_shifted_system_counts_modes(system):
    """K − Ω²M on the ordering of K: same answer as fresh, one more negative pivot per mode."""
    k, m = system.stiffness.inner, system.mass.inner
    factor = factorise(k)
    static = factor.negative_pivots
    shifted = (k - (2.0 * np.pi * 5000.0) ** 2 * m).tocsr()
    factor.refactorise(shifted)
    fresh = factorise(shifted)
    right = system.tip[:-3]
    a, b = (refined_solution(shifted, f, right) for f in (factor, fresh))
    # one refinement of seven digits lost
    assert np.abs(a - b).max() < 1e-9 * np.abs(b).max()
    assert factor.negative_pivots == fresh.negative_pivots
    if static is not None:
        assert fresh.negative_pivots > static


@needs_mkl
def test_matching_where_pivots_are_lost(monkeypatch):
    """If the answer is wrong without weighted matching, it is tried with it, then refused."""
    tried = []

    def wrong_at_first(self, matrix):
        tried.append(self._method._matching)
        if not self._method._matching:
            raise SolverError("singular")

    monkeypatch.setattr(Factor, "_check", wrong_at_first)
    matrix, exact = sparse.csr_matrix(piezo_like()), np.arange(24.0)
    factor = factorise(matrix)
    assert tried == [False, True]
    assert factor.perturbed_pivots == 0
    assert factor.solve(matrix @ exact) == pytest.approx(exact, abs=1e-9)
    factor.refactorise(2.0 * matrix)
    assert factor.solve(matrix @ exact) == pytest.approx(exact / 2.0, abs=1e-9)


@needs_mkl
def test_perturbed_pivots_are_counted():
    """A pivot that had to be replaced is told of."""
    from tactgen.fem.solvers.pardiso import Pardiso

    upper = sparse.triu(laplacian(50), format="csr")
    line = Pardiso(upper.indptr, upper.indices, complex_numbers=False)
    line.factorise(upper.data)
    assert line.perturbed_pivots == 1


@needs_mkl
def test_a_fault_of_the_library_is_said():
    """An indefinite matrix that was said to be definite has a pivot that is not positive."""
    upper = sparse.csr_matrix(np.array([[1.0, 2.0], [0.0, 1.0]]))
    matrix = pardiso.Pardiso(upper.indptr, upper.indices, complex_numbers=False, definite=True)
    with pytest.raises(pardiso.PardisoError, match="singular"):
        matrix.factorise(upper.data)


@both
def test_a_factor_is_freed_when_nobody_has_it():
    """At once: a circle of references would keep gigabytes that the collector does not see."""
    factor = factorise(sparse.csr_matrix(piezo_like()))
    method = weakref.ref(factor._method)
    gc.disable()
    try:
        del factor
        assert method() is None
    finally:
        gc.enable()


@needs_mkl
def test_the_librarys_memory_is_given_back(monkeypatch):
    """With the factor that it belongs to: nobody else knows of it."""
    given = []
    monkeypatch.setattr(pardiso, "_release", lambda *what: given.append(what[0]))
    upper = sparse.csr_matrix(np.eye(2))
    factor = pardiso.Pardiso(upper.indptr, upper.indices, complex_numbers=False)
    held = factor._handle
    del factor
    gc.collect()
    assert [handle is held for handle in given] == [True]


@both
def test_a_matrix_as_it_comes_is_factorised():
    """Entries given twice, out of order and as whole numbers, and a diagonal that is not stored."""
    rows, columns = np.array([0, 1, 1, 0, 0, 2, 1]), np.array([1, 0, 1, 0, 0, 1, 2])
    given = sparse.coo_matrix((np.array([1, 1, 5, 2, 2, 1, 1]), (rows, columns)), shape=(3, 3))
    raw = sparse.csr_matrix(
        (given.data[[3, 4, 0, 1, 2, 6, 5]], given.col[[3, 4, 0, 1, 2, 6, 5]], [0, 3, 6, 7]),
        shape=(3, 3),
    )
    before = raw.copy()
    right = np.array([1.0, -2.0, 3.0])
    for matrix in (given, raw):
        found = factorise(matrix).solve(right)
        np.testing.assert_allclose(matrix.toarray() @ found, right, atol=1e-13)
    np.testing.assert_array_equal(raw.data, before.data)


def test_the_library_is_looked_for_where_its_wheel_lists_it(monkeypatch, tmp_path):
    """Of its files the dynamic library; without the wheel, or one that does not load, none."""
    listed = [SimpleNamespace(name=name, locate=lambda name=name: tmp_path / name)
              for name in ("libmkl_rt.so.2", "mkl.h")]  # fmt: skip
    (tmp_path / "libmkl_rt.so.2").write_text("no library")
    monkeypatch.setattr(importlib.metadata, "files", lambda _: listed)
    assert pardiso._in_wheel() == [tmp_path / "libmkl_rt.so.2"]
    monkeypatch.setattr(sys, "prefix", str(tmp_path / "nowhere"))
    assert pardiso.mkl.__wrapped__() is None
    monkeypatch.setattr(importlib.metadata, "files", lambda _: None)
    assert pardiso._in_wheel() == []

    def missing(_):
        raise importlib.metadata.PackageNotFoundError

    monkeypatch.setattr(importlib.metadata, "files", missing)
    assert pardiso._in_wheel() == []
    monkeypatch.setattr(pardiso, "mkl", lambda: None)
    assert nested_dissection(np.array([0, 1]), np.array([0])) is None
