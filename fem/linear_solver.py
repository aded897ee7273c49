"""Direct factorisation of symmetric sparse matrices, real indefinite or complex symmetric.

MKL Pardiso where Intel's libraries are installed (x86_64), SciPy's SuperLU elsewhere;
both behind one call.  No physics, no scaling of unknowns: callers balance their
systems first, because a small residual proves nothing on a badly scaled one.
"""

from __future__ import annotations

import ctypes
import weakref
from functools import cache
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from geometry.arrays import Sparse

Array = NDArray[Any]


class SolverError(RuntimeError):
    """The factorisation failed; the message says how."""


class Factor(Protocol):
    """A factorised symmetric matrix."""

    #: Number of negative pivots, None where the solver does not tell.
    negative_pivots: int | None

    def solve(self, right: Array) -> Array:
        """Return A⁻¹ right for right of shape (n,) or (n, k)."""
        ...


def factorise(matrix: Sparse, *, solver: str = "auto") -> Factor:
    """Factorise a symmetric (not Hermitian) real or complex sparse matrix.

    Parameters
    ----------
    matrix : sparse (n, n)
        Both triangles; only the upper one is read by Pardiso.
    solver : {"auto", "pardiso", "superlu"}
        ``auto`` takes Pardiso when its library is there.

    Raises
    ------
    SolverError
        If the matrix is singular or the library reports an error.
    """
    if solver == "superlu" or (solver == "auto" and _library() is None):
        return _SuperLU(matrix)
    if _library() is None:
        raise SolverError("Pardiso was asked for, but Intel's MKL is not installed here")
    return _Pardiso(matrix)


def refined_solution(matrix: Sparse, factor: Factor, right: Array) -> Array:
    """Return A⁻¹ right with one step of iterative refinement, the residual in long double.

    A piezoelectric matrix loses some seven digits, and which ones depends on the ordering,
    so even on the number of threads.  With a residual in the same precision they stay lost.
    """
    x = factor.solve(right)
    wide = np.clongdouble if np.iscomplexobj(matrix.data) else np.longdouble
    residual = right.astype(wide) - matrix.astype(wide) @ x.astype(wide)
    return x + factor.solve(residual.astype(x.dtype))


def available_solver() -> str:
    """Return the solver that ``auto`` takes."""
    return "SuperLU (SciPy)" if _library() is None else "Pardiso (MKL)"


class _SuperLU:
    """SciPy's SuperLU in symmetric mode."""

    def __init__(self, matrix: Sparse) -> None:
        from scipy.sparse.linalg import splu

        self.negative_pivots: int | None = None
        try:
            self._lu = splu(
                sparse.csc_matrix(matrix),
                permc_spec="MMD_AT_PLUS_A",
                diag_pivot_thresh=0.01,
                options={"SymmetricMode": True},
            )
        except RuntimeError as error:
            raise SolverError(f"SuperLU: {error}") from None

    def solve(self, right: Array) -> Array:
        right = np.asarray(right)
        if np.iscomplexobj(right) and not np.issubdtype(self._lu.U.dtype, np.complexfloating):
            return np.asarray(self._lu.solve(right.real) + 1j * self._lu.solve(right.imag))
        return np.asarray(self._lu.solve(right.astype(self._lu.U.dtype)))


@cache
def _library() -> ctypes.CDLL | None:
    """Load MKL's single dynamic library from the installed wheel, if there is one."""
    from importlib.metadata import PackageNotFoundError, files

    try:
        found = [f for f in files("mkl") or [] if f.name.startswith("libmkl_rt")]
    except PackageNotFoundError:
        return None
    for entry in found:
        try:
            return ctypes.CDLL(str(entry.locate()))
        except OSError:
            continue
    return None


class _Pardiso:
    """MKL Pardiso, matrix types −2 (real symmetric indefinite) and 6 (complex symmetric)."""

    def __init__(self, matrix: Sparse) -> None:
        upper = sparse.triu(matrix, format="csr")
        upper.sort_indices()
        self._complex = bool(np.issubdtype(upper.dtype, np.complexfloating))
        self._type = ctypes.c_int(6 if self._complex else -2)
        dtype = np.complex128 if self._complex else np.float64
        self._data = np.ascontiguousarray(upper.data, dtype=dtype)
        self._indptr = np.ascontiguousarray(upper.indptr, dtype=np.int32)
        self._indices = np.ascontiguousarray(upper.indices, dtype=np.int32)
        self._n = ctypes.c_int(upper.shape[0])
        self._handle = np.zeros(64, dtype=np.int64)
        self._parameters = _parameters()
        weakref.finalize(self, _release, self._handle, self._type, self._n, self._parameters)
        self._call(12, None, None)
        self.negative_pivots = None if self._complex else int(self._parameters[22])

    def solve(self, right: Array) -> Array:
        right = np.asarray(right)
        if np.iscomplexobj(right) and not self._complex:
            return self.solve(right.real) + 1j * self.solve(right.imag)
        columns = np.asfortranarray(right.reshape(right.shape[0], -1), dtype=self._data.dtype)
        out = np.zeros_like(columns, order="F")
        self._call(33, columns, out)
        return out.reshape(right.shape)

    def _call(self, phase: int, right: Array | None, out: Array | None) -> None:
        library = _library()
        assert library is not None
        columns = 1 if right is None else right.shape[1]
        error = ctypes.c_int(0)
        one, quiet = ctypes.c_int(1), ctypes.c_int(0)
        library.pardiso(
            _pointer(self._handle),
            ctypes.byref(one),
            ctypes.byref(one),
            ctypes.byref(self._type),
            ctypes.byref(ctypes.c_int(phase)),
            ctypes.byref(self._n),
            _pointer(self._data),
            _pointer(self._indptr),
            _pointer(self._indices),
            None,
            ctypes.byref(ctypes.c_int(columns)),
            _pointer(self._parameters),
            ctypes.byref(quiet),
            None if right is None else _pointer(right),
            None if out is None else _pointer(out),
            ctypes.byref(error),
        )
        if error.value != 0:
            raise SolverError(_MESSAGES.get(error.value, f"Pardiso error {error.value}"))


_MESSAGES = {
    -2: "Pardiso ran out of memory; use a coarser mesh",
    -3: "Pardiso could not order the matrix",
    -4: "the matrix is singular (a part that nothing holds, or an electrode with no material)",
    -7: "the matrix has a singular diagonal",
}


def _parameters() -> Array:
    """Return Pardiso's control array; everything not named keeps 0."""
    p = np.zeros(64, dtype=np.int32)
    p[0] = 1  # the values below are ours
    p[1] = 2  # nested dissection
    p[7] = 0  # refine only if a pivot had to be perturbed: five times cheaper solves
    p[9] = 10  # perturb pivots below 1e-10 of the norm
    p[10] = 1  # scale
    p[12] = 1  # weighted matching: the zero-ish diagonal of a saddle point
    p[20] = 1  # 1x1 and 2x2 (Bunch-Kaufman) pivots
    p[34] = 1  # indices start at 0
    return p


def _pointer(array: Array) -> ctypes.c_void_p:
    return array.ctypes.data_as(ctypes.c_void_p)


def _release(handle: Array, kind: ctypes.c_int, n: ctypes.c_int, parameters: Array) -> None:
    """Free the factor's memory when its object dies."""
    library = _library()
    if library is None or not handle.any():
        return
    one, quiet, phase, error = (ctypes.c_int(v) for v in (1, 0, -1, 0))
    library.pardiso(
        _pointer(handle), ctypes.byref(one), ctypes.byref(one), ctypes.byref(kind),
        ctypes.byref(phase), ctypes.byref(n), None, None, None, None, ctypes.byref(one),
        _pointer(parameters), ctypes.byref(quiet), None, None, ctypes.byref(error),
    )  # fmt: skip
