"""Sparse matrices of small blocks from the matrices of cells, in one product per batch of cells."""

from __future__ import annotations

import numpy as np
from scipy import sparse

from tactgen.geometry.arrays import Ints, Numbers, Sparse


class BlockPattern:
    """Where the cells' entries go in a sparse matrix whose entries are blocks.

    Parameters
    ----------
    dofs : (n_cells, n_local) int array
        Nodes of the cells.
    size : int
        Number of nodes.
    """

    def __init__(self, dofs: Ints, size: int) -> None:
        self._size = size
        keys = dofs[:, :, None] * np.int64(size) + dofs[:, None, :]
        unique, slot = np.unique(keys.ravel(), return_inverse=True)
        self._slot = slot.reshape(len(dofs), -1)
        self.columns: Ints = unique % size
        self._starts = np.searchsorted(unique, np.arange(size + 1) * np.int64(size))

    def upper(self) -> tuple[Ints, Ints]:
        """Return starts (n + 1,) and columns of the upper triangle's compressed rows of blocks."""
        rows = np.repeat(np.arange(self._size), np.diff(self._starts))
        upper = self.columns >= rows
        counts = np.bincount(rows[upper], minlength=self._size)
        return np.concatenate([[0], np.cumsum(counts)]), self.columns[upper]

    def places(self, cells: Ints) -> Sparse:
        """Return the matrix of ones that adds the entries of some cells to those of the whole."""
        slot = self._slot[cells].ravel()
        ones = np.ones(slot.size)
        return sparse.csr_matrix(
            (ones, (slot, np.arange(slot.size))), shape=(self.columns.size, slot.size)
        )

    def matrix(self, entries: Numbers) -> Sparse:
        """Return the matrix in compressed rows, `entries` (n, k²) being blocks of k by k."""
        k = round(float(np.sqrt(entries.shape[1])))
        blocks = entries.reshape(-1, k, k)
        shape = (k * self._size, k * self._size)
        return sparse.bsr_matrix((blocks, self.columns, self._starts), shape=shape).tocsr()
