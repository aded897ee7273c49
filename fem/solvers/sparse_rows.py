"""Work on the compressed rows of large sparse matrices, a block of rows at a time.

Blocks that fit the processor's cache cost no memory of their own; to make a whole copy of a
matrix takes longer than what is done with it.
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from tactgen.geometry.arrays import Ints, Sparse

Array = NDArray[Any]

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
