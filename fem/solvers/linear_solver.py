"""Direct factorisation of symmetric sparse matrices: definite, indefinite, complex symmetric.

MKL Pardiso where Intel's libraries are installed (x86_64), SciPy's SuperLU elsewhere;
both behind one call.  No physics.

A small residual proves nothing on a badly scaled system, and neither library says when a
matrix is singular up to rounding.  So rows and columns are balanced first, and each
factorisation has to reproduce a solution that is known.
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from tactgen.fem.solvers.pardiso import Pardiso, PardisoError, mkl
from tactgen.geometry.arrays import Bools, Floats, Ints, Sparse

#: Real or complex, in any precision.
Array: TypeAlias = NDArray[Any]


#: Entries that are worked on at once.
_BLOCK = 100_000


def row_blocks(starts: Ints) -> Iterator[tuple[int, int]]:
    """Yield the first row of each block and that after its last, from the rows' starts (n + 1,)."""
    n = starts.size - 1
    cuts = np.unique(np.searchsorted(starts[:-1], np.arange(0, max(starts[-1], 1), _BLOCK)))
    # a cut inside the last row would leave a block without rows
    yield from pairwise([*cuts[cuts < n].tolist(), n])


def wide_product(matrix: Sparse, x: Array) -> Array:
    """Matrix @ x in long double, for a matrix in compressed rows and x (n,) or (n, k)."""
    wide = np.clongdouble if np.iscomplexobj(matrix.data) else np.longdouble
    x = x.astype(np.result_type(wide, x.dtype))
    columns = np.asfortranarray(x.reshape(x.shape[0], -1))
    out = np.empty((matrix.shape[0], columns.shape[1]), dtype=x.dtype, order="F")
    for first, last in row_blocks(matrix.indptr):
        starts = matrix.indptr[first : last + 1]
        part = slice(starts[0], starts[-1])
        rows = sparse.csr_matrix(
            (matrix.data[part].astype(wide), matrix.indices[part], starts - starts[0]),
            shape=(last - first, matrix.shape[1]),
        )
        # one column at a time: its sums stay in the processor, where they are long double
        for there, column in zip(out.T, columns.T, strict=True):
            there[first:last] = rows @ column
    return out.reshape(x.shape)


#: Error (2-norm, entries of the solution up to 1) above which a matrix counts as singular if
#: refinement does not mend it.  Rounding puts a null vector of length about 1 into the answer
#: (0.06 to 2000 on singular Laplacians of 50 to 100,000 unknowns); a barely gauged curl-curl
#: matrix of 80,000 unknowns, condition 1e12, is 0.02 off, the piezoelectric solid 4e-7.
_SINGULAR = 1e-2
#: Steps of refinement that may mend it: next to a condition of 1e15 each gains a digit.
_REFINEMENTS = 3
#: Balanced when the largest entry of every row is within this factor of 1.
_BALANCED = 4.0
#: Passes that even 600 decades need, each halving the decades that are left.
_PASSES = 12


class SolverError(RuntimeError):
    """The factorisation failed; the message says how."""


def factorise(matrix: Sparse, *, definite: bool = False, order: Ints | None = None) -> Factor:
    """Factorise a symmetric (not Hermitian) real or complex sparse matrix (n, n).

    It has both triangles; only the upper one is read by Pardiso.  One that should be positive
    `definite` is factorised by Cholesky, up to twice as fast; if it is not, as an indefinite one,
    and `negative_pivots` tells.  `order` (n,) has the unknowns in the order in which to eliminate
    them, where a good one is known; else Pardiso looks for one, which takes longer than the
    factorisation.

    Raises SolverError if the matrix is singular or the library reports an error.
    """
    return Factor(matrix, definite=definite, order=order)


class Factor:
    """A factorised symmetric matrix; made by :func:`factorise`."""

    def __init__(self, matrix: Sparse, *, definite: bool, order: Ints | None) -> None:
        self._definite, self._known_order = definite, order
        self._order(_canonical(matrix))

    @property
    def negative_pivots(self) -> int | None:
        """Number of negative pivots, None where the solver does not tell."""
        return self._method.negative_pivots

    @property
    def perturbed_pivots(self) -> int:
        """Pivots that were replaced because they were too small; solutions are then refined."""
        return self._method.perturbed_pivots

    def refactorise(self, matrix: Sparse) -> None:
        """Become the factor of another matrix, keeping the ordering.

        Pays where many matrices share one sparsity pattern, as those of a Newton method or
        K − Ω² M for several Ω do.  With another pattern all is done anew.  The ordering is
        also found anew where pivots make it depend on the values, and always with SuperLU.

        Raises SolverError as :func:`factorise`; this object is then of no more use.
        """
        matrix = _canonical(matrix)
        if self._complex == np.iscomplexobj(matrix.data) and self._pattern.fits(matrix):
            self._factorise(matrix)
        else:
            self._order(matrix)

    def solve(self, right: Array) -> Array:
        """A⁻¹ right for right of shape (n,) or (n, k)."""
        right = np.asarray(right)
        if np.iscomplexobj(right) and not self._complex:
            return self.solve(right.real) + 1j * self.solve(right.imag)
        scale = self._scale[:, None]
        columns = right.reshape(right.shape[0], -1)
        return (scale * self._method.solve(scale * columns)).reshape(right.shape)

    def _order(self, matrix: Sparse) -> None:
        self._pattern = _Pattern(matrix)
        self._complex = np.iscomplexobj(matrix.data)
        self._methods = _attempts(self._pattern, self._complex, self._definite, self._known_order)
        self._method = next(self._methods)
        self._factorise(matrix)

    def _factorise(self, matrix: Sparse) -> None:
        self._scale = _balance(matrix)
        data = self._pattern.upper(matrix, self._scale)
        while True:
            try:
                self._method.factorise(data)
                self._check(matrix)
            except (PardisoError, SolverError) as error:
                following = next(self._methods, None)
                if following is None:
                    raise SolverError(str(error)) from None
                self._method = following
            else:
                return

    def _check(self, matrix: Sparse) -> None:
        """Solve for a known solution.

        What a badly conditioned matrix loses comes back by refinement, if the known case is
        rounded to more digits; what a singular one adds of its null vectors stays.
        """
        known = np.random.default_rng(1).uniform(-1.0, 1.0, matrix.shape[0])
        right = self._scale * (matrix @ (self._scale * known))
        found = self._method.solve(right[:, None])[:, 0]
        for _ in range(_REFINEMENTS):
            if np.linalg.norm(found - known) <= _SINGULAR:
                break
            missing = self._scale * wide_product(matrix, self._scale * (known - found))
            found = found + self._method.solve(missing.astype(found.dtype)[:, None])[:, 0]
        if not np.linalg.norm(found - known) <= _SINGULAR:
            raise SolverError(
                "the matrix is singular (a part that nothing holds, an electrode with no material, "
                "or a body so slender that rounding hides its stiffness)"
            )


def refined_solution(matrix: Sparse, factor: Factor, right: Array) -> Array:
    """A⁻¹ right with one step of iterative refinement, the residual in long double.

    A piezoelectric matrix loses some seven digits, and which ones depends on the ordering,
    so even on the number of threads.  With a residual in the same precision they stay lost.
    """
    x = factor.solve(right)
    residual = right - wide_product(matrix.tocsr(), x)
    return x + factor.solve(residual.astype(x.dtype))


def available_solver() -> str:
    """Solver that is taken."""
    return "SuperLU (SciPy)" if mkl() is None else "Pardiso (MKL)"


class _Pattern:
    """Where the entries of a matrix are; `starts`, `columns` are those of its upper triangle."""

    def __init__(self, matrix: Sparse) -> None:
        self._indptr, self._indices = matrix.indptr, matrix.indices
        rows = _rows(matrix)
        self._in_upper: Bools = matrix.indices >= rows
        self.columns: Ints = matrix.indices[self._in_upper]
        self._counts = np.bincount(rows[self._in_upper], minlength=matrix.shape[0])
        self.starts: Ints = np.concatenate([[0], np.cumsum(self._counts)])

    def fits(self, matrix: Sparse) -> bool:
        """Whether `matrix` has this pattern."""
        return np.array_equal(self._indptr, matrix.indptr) and np.array_equal(
            self._indices, matrix.indices
        )

    def upper(self, matrix: Sparse, scale: Floats) -> Array:
        """Upper entries of scale_i a_ij scale_j."""
        data = matrix.data[self._in_upper]
        data *= np.repeat(scale, self._counts)
        data *= scale[self.columns]
        return np.asarray(data)


def _attempts(
    pattern: _Pattern, complex_numbers: bool, definite: bool, order: Ints | None
) -> Iterator[Pardiso | _SuperLU]:
    """Yield the methods to try, the cheapest first.

    Knows nothing of the factor that asks: a generator that did would be held by it and hold it,
    and gigabytes of factors would wait for the collector of such circles, which does not see them.
    """
    if mkl() is None:
        yield _SuperLU(pattern)
        return
    starts, columns = pattern.starts, pattern.columns
    if definite and not complex_numbers:
        yield Pardiso(starts, columns, complex_numbers=False, definite=True, order=order)
    yield Pardiso(starts, columns, complex_numbers=complex_numbers, order=order)
    yield Pardiso(starts, columns, complex_numbers=complex_numbers, matching=True)


class _SuperLU:
    """SciPy's SuperLU in symmetric mode."""

    negative_pivots: int | None = None
    perturbed_pivots = 0

    def __init__(self, pattern: _Pattern) -> None:
        self._pattern = pattern

    def factorise(self, data: Array) -> None:
        from scipy.sparse.linalg import splu

        starts, columns = self._pattern.starts, self._pattern.columns
        upper = sparse.csr_matrix((data, columns, starts), shape=2 * (starts.size - 1,))
        self._dtype = data.dtype
        try:
            self._lu = splu(
                (upper + sparse.triu(upper, 1).T).tocsc(),
                permc_spec="MMD_AT_PLUS_A",
                diag_pivot_thresh=0.01,
                options={"SymmetricMode": True},
            )
        except RuntimeError as error:
            raise SolverError(f"SuperLU: {error}") from None

    def solve(self, right: Array) -> Array:
        return np.asarray(self._lu.solve(right.astype(self._dtype)))


def _canonical(matrix: Sparse) -> Sparse:
    """Matrix in compressed rows, columns sorted, every diagonal entry stored."""
    csr = sparse.csr_matrix(matrix)
    if not csr.has_canonical_format:
        csr = csr.copy()
        csr.sum_duplicates()
    if csr.dtype.kind not in "fc":
        csr = csr.astype(float)
    n, rows = csr.shape[0], _rows(csr)
    if np.count_nonzero(csr.indices == rows) < n:
        # sums of sparse matrices drop zeros, coordinates keep them
        here = np.arange(n)
        entries = np.concatenate([csr.data, np.zeros(n, dtype=csr.dtype)])
        places = (np.concatenate([rows, here]), np.concatenate([csr.indices, here]))
        csr = sparse.coo_matrix((entries, places), shape=csr.shape).tocsr()
    return csr


def _rows(matrix: Sparse) -> Ints:
    """Row of each stored entry."""
    return np.repeat(np.arange(matrix.shape[0], dtype=matrix.indices.dtype), np.diff(matrix.indptr))


def _balance(matrix: Sparse) -> Floats:
    """Powers of two s, so that s_i a_ij s_j has rows whose largest entries are near 1.

    From the diagonal, which already balances a definite matrix; then by the square roots of
    the rows' largest entries (D. Ruiz, A scaling algorithm to equilibrate both rows and
    columns norms in matrices, RAL-TR-2001-034).  Powers of two round nothing.
    """
    diagonal = np.abs(matrix.diagonal())
    if not diagonal.all():
        entries = _largest(matrix, np.ones(matrix.shape[0]))
        if not entries.all():
            raise SolverError(f"the matrix is singular (row {int(np.argmin(entries))} is zero)")
        diagonal = np.where(diagonal > 0.0, diagonal, entries)
    scale = 1.0 / np.sqrt(diagonal)
    for _ in range(_PASSES):
        entries = _largest(matrix, scale)
        if not np.isfinite(entries).all():
            raise SolverError("the matrix has entries that are not finite")
        if entries.max() <= _BALANCED and entries.min() >= 1.0 / _BALANCED:
            break
        scale = scale / np.sqrt(entries)
    return np.asarray(np.exp2(np.round(np.log2(scale))))


def _largest(matrix: Sparse, scale: Floats) -> Floats:
    """Largest |scale_i a_ij scale_j| of each row i, in blocks to save memory."""
    starts = matrix.indptr
    found = np.empty(matrix.shape[0])
    for first, last in row_blocks(starts):
        part = slice(starts[first], starts[last])
        entries = np.abs(matrix.data[part]) * scale[matrix.indices[part]]
        found[first:last] = np.maximum.reduceat(entries, starts[first:last] - starts[first])
    return scale * found
