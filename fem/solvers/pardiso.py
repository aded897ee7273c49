"""Pardiso of Intel's MKL by ctypes: one symmetric sparsity pattern, its factors, solutions.

The library comes with the mkl wheel.  No scaling, no judgement of the answers: that is
:mod:`fem.solvers.linear_solver`.

Fill-reducing ordering and symbolic factorisation (phase 11) look at the pattern only, so
they stay valid for every matrix that has it.  Weighted matching permutes by value, so with
it every factorisation orders anew.  The ordering, which takes longer than many a factorisation,
is kept for the patterns met last; what comes of it is the same to the last bit.
"""

from __future__ import annotations

import ctypes
import os
import sys
import threading
import weakref
from collections import OrderedDict
from collections.abc import Callable, Iterable
from functools import cache
from hashlib import blake2b
from pathlib import Path
from typing import Any, TypeAlias, TypeVar

import numpy as np
from numpy.typing import NDArray

from tactgen.geometry.arrays import Ints
from tactgen.geometry.errors import InputError
from tactgen.geometry.operating_system import core_count

S = TypeVar("S")
T = TypeVar("T")

VARIABLE = "TACTGEN_THREADS"

#: Says of a thread that it is one of several that do jobs side by side.
_here = threading.local()


def thread_count() -> int | None:
    """Number of threads that the environment asks for, None if it does not say.

    Raises InputError if that is not a whole number from 1.
    """
    text = os.environ.get(VARIABLE, "").strip()
    if not text:
        return None
    if not (text.isascii() and text.isdigit() and 1 <= int(text) <= 1024):
        raise InputError(
            f"the environment variable {VARIABLE} is '{text}'; "
            "set it to a whole number of threads from 1 to 1024, or unset it to use all cores"
        )
    return int(text)


def solver_threads() -> int:
    """Threads of a sparse-solver call; 0 leaves it to MKL."""
    return 1 if _beside_others() else thread_count() or 0


def side_by_side(work: Callable[[S], T], jobs: Iterable[S]) -> list[T]:
    """Results of jobs run side by side, in their order.

    For jobs of which nearly all is done by libraries that let other threads run.  Each has one
    thread of the sparse solver, so that together they take no more than the setting allows.
    """
    asked = list(jobs)
    threads = min(thread_count() or core_count(), len(asked))
    if threads < 2 or _beside_others():
        return [work(job) for job in asked]
    from concurrent.futures import ThreadPoolExecutor

    with ThreadPoolExecutor(threads, initializer=_say_beside_others) as pool:
        try:
            return list(pool.map(work, asked))
        except BaseException:  # interrupted, too: what has not begun is not waited for
            pool.shutdown(wait=False, cancel_futures=True)
            raise


def _beside_others() -> bool:
    return getattr(_here, "beside_others", False)


def _say_beside_others() -> None:
    _here.beside_others = True


Array: TypeAlias = NDArray[Any]

#: With fewer stored entries than this, a second thread costs more than it brings.
_WORTH_THREADS = 100_000


#: Orderings by the digest of their pattern; those longest unused go first.
_ORDERS: OrderedDict[bytes, Array] = OrderedDict()
_MOST_ORDERS = 32


class PardisoError(RuntimeError):
    """Pardiso reported an error; the message says which."""


class Pardiso:
    """Factors of symmetric matrices that share one pattern.

    `starts` (n + 1,) and `columns` (n_entries,) are the compressed rows of the upper triangle,
    columns sorted, every diagonal entry there.  Real matrices are positive `definite` (matrix type
    2) or indefinite (−2); complex symmetric is always 6.  Weighted `matching` and scaling are for
    matrices on whose diagonal there is little.  `order` (n,) has the unknowns in the order of their
    elimination; found by nested dissection if not given.
    """

    #: Number of negative pivots; None for complex matrices, where there is no sign
    negative_pivots: int | None = None
    perturbed_pivots = 0  #: Pivots that were too small and were replaced

    def __init__(
        self,
        starts: Ints,
        columns: Ints,
        *,
        complex_numbers: bool,
        definite: bool = False,
        matching: bool = False,
        order: Ints | None = None,
    ) -> None:
        self._complex = complex_numbers
        self._definite = definite and not complex_numbers
        self._matching = matching
        self._kind = ctypes.c_int(6 if complex_numbers else 2 if definite else -2)
        self._n = ctypes.c_int(starts.size - 1)
        self._indptr = np.ascontiguousarray(starts, dtype=np.int32)
        self._indices = np.ascontiguousarray(columns, dtype=np.int32)
        self._data = np.zeros(0)
        self._handle = np.zeros(64, dtype=np.int64)
        self._control = _control(definite=self._definite, matching=matching)
        self._order: Array | None = (
            None if order is None else np.ascontiguousarray(order, dtype=np.int32)
        )
        self._ordered = False
        weakref.finalize(self, _release, self._handle, self._kind, self._n, self._control)

    def factorise(self, data: Array) -> None:
        """Factorise the matrix with entries `data`, in the order of the pattern.

        Raises PardisoError if the pattern cannot be ordered, memory runs out, or a pivot is zero,
        or not positive where the matrix was said to be definite.
        """
        # kept: Pardiso reads the entries again when it refines a solution
        self._data = np.ascontiguousarray(data, dtype=complex if self._complex else float)
        if not self._ordered:
            self._analyse()
            self._ordered = not self._matching
        self._call(22)
        self.perturbed_pivots = int(self._control[13])
        if not self._complex:
            self.negative_pivots = 0 if self._definite else int(self._control[22])

    def found_order(self) -> Ints:
        """Unknowns in the order of their elimination, found without a factorisation."""
        self._data = np.ones(self._indices.size)
        self._analyse()
        return np.asarray(self._order, dtype=np.int64)

    def _analyse(self) -> None:
        """Find the ordering, unless it is known, and the symbolic factorisation."""
        if self._matching:
            self._call(11)
            return
        written, read = 2, 1
        if self._order is not None:
            self._control[4] = read
            self._call(11)
            return
        pattern = blake2b(self._indptr.data, digest_size=16)
        pattern.update(self._indices.data)
        key = pattern.digest()
        known = _ORDERS.pop(key, None)
        self._control[4] = written if known is None else read
        order: Array = np.zeros(self._n.value, dtype=np.int32) if known is None else known
        self._order = order
        self._call(11)
        _ORDERS[key] = order
        while len(_ORDERS) > _MOST_ORDERS:
            _ORDERS.popitem(last=False)

    def solve(self, right: Array) -> Array:
        """A⁻¹ right for right (n, k) of the matrix's own type."""
        columns = np.asfortranarray(right, dtype=self._data.dtype)
        out = np.zeros_like(columns, order="F")
        self._call(33, columns, out)
        return out

    def _call(self, phase: int, right: Array | None = None, out: Array | None = None) -> None:
        library = mkl()
        assert library is not None
        columns = 1 if right is None else right.shape[1]
        error = ctypes.c_int(0)
        one, quiet = ctypes.c_int(1), ctypes.c_int(0)
        few = self._indices.size < _WORTH_THREADS
        before = library.MKL_Set_Num_Threads_Local(1 if few else solver_threads())
        library.pardiso(
            _pointer(self._handle),
            ctypes.byref(one),
            ctypes.byref(one),
            ctypes.byref(self._kind),
            ctypes.byref(ctypes.c_int(phase)),
            ctypes.byref(self._n),
            _pointer(self._data),
            _pointer(self._indptr),
            _pointer(self._indices),
            None if self._order is None else _pointer(self._order),
            ctypes.byref(ctypes.c_int(columns)),
            _pointer(self._control),
            ctypes.byref(quiet),
            None if right is None else _pointer(right),
            None if out is None else _pointer(out),
            ctypes.byref(error),
        )
        library.MKL_Set_Num_Threads_Local(before)
        if error.value != 0:
            raise PardisoError(_MESSAGES.get(error.value, f"Pardiso error {error.value}"))


def nested_dissection(starts: Ints, columns: Ints) -> Ints | None:
    """Order (n,) in which to eliminate the unknowns of a pattern as :class:`Pardiso` has it.

    None without Intel's library.
    """
    if mkl() is None:
        return None
    pattern = Pardiso(starts, columns, complex_numbers=False)
    return pattern.found_order()


@cache
def mkl() -> ctypes.CDLL | None:
    """Load MKL's single dynamic library from the installed wheel, if there is one."""
    # where the wheel puts it; what is elsewhere is found by its list of files, which takes 20 ms
    for path in sorted((Path(sys.prefix) / "lib").glob("libmkl_rt*")) or _in_wheel():
        try:
            return ctypes.CDLL(str(path))
        except OSError:
            continue
    return None


def _in_wheel() -> list[Path]:
    """Places of the library by the wheel's own list of files."""
    from importlib.metadata import PackageNotFoundError, files

    try:
        found = files("mkl") or []
    except PackageNotFoundError:
        return []
    return [Path(f.locate()) for f in found if f.name.startswith("libmkl_rt")]


_MESSAGES = {
    -2: "Pardiso ran out of memory; use a coarser mesh",
    -3: "Pardiso could not order the matrix",
    -4: "the matrix is singular (a part that nothing holds, or an electrode with no material)",
    -7: "the matrix has a singular diagonal",
}


def _control(*, definite: bool, matching: bool) -> Array:
    """Pardiso's control array iparm, counted from 0; other entries are 0."""
    p = np.zeros(64, dtype=np.int32)
    p[0] = 1  # the values below are ours
    p[1] = 2  # nested dissection
    p[7] = 0  # refine only if a pivot had to be perturbed: five times cheaper solves
    p[9] = 13  # perturb pivots below 1e-13 of the norm
    p[10] = p[12] = int(matching)  # scaling, weighted matching
    p[20] = int(not definite)  # 1x1 and 2x2 (Bunch-Kaufman) pivots
    p[34] = 1  # indices start at 0
    return p


def _pointer(array: Array) -> ctypes.c_void_p:
    # ten times faster than data_as, which would keep the array alive: callers hold theirs
    return ctypes.c_void_p(array.ctypes.data)


def _release(handle: Array, kind: ctypes.c_int, n: ctypes.c_int, control: Array) -> None:
    """Free the factor's memory when its object dies."""
    library = mkl()
    if library is None or not handle.any():
        return
    one, quiet, phase, error = (ctypes.c_int(v) for v in (1, 0, -1, 0))
    library.pardiso(
        _pointer(handle), ctypes.byref(one), ctypes.byref(one), ctypes.byref(kind),
        ctypes.byref(phase), ctypes.byref(n), None, None, None, None, ctypes.byref(one),
        _pointer(control), ctypes.byref(quiet), None, None, ctypes.byref(error),
    )  # fmt: skip
