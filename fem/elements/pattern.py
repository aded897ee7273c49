"""Fields at quadrature points from unknowns, and matrices from tensors there.

Both potentials give their field in the same way, F = S Σ_i f_i x_i, where f_i are fixed
fields on the reference cell and S maps them to the cell: f = curl of an edge function
and S = J / det J for B = curl A; f = gradient of a nodal function and S = J⁻ᵀ for
H = −grad φ.  All cells are treated at once, so an assembly is one dense product.
"""

from __future__ import annotations

from copy import copy

import numpy as np
from scipy import sparse

from tactgen.geometry.arrays import Floats, Ints, Numbers, Sparse


class Pattern:
    """Where the cells' entries go in vectors and matrices over the free unknowns; found once.

    `dofs` (n_cells, n_local) are the cells' global unknowns, `free` (n_free,) those that are solved
    for; the others are 0.
    """

    def __init__(self, dofs: Ints, free: Ints) -> None:
        self.size = free.size
        renumbered = np.full(int(dofs.max()) + 1, -1)
        renumbered[free] = np.arange(free.size)
        self._dofs = renumbered[dofs]
        square = np.broadcast_arrays(self._dofs[:, :, None], self._dofs[:, None, :])
        rows, columns = (side.ravel() for side in square)
        self._kept = np.flatnonzero((rows >= 0) & (columns >= 0))
        rows, columns = rows[self._kept], columns[self._kept]
        # merged row by row, which takes half the time of sorting all places
        ones = np.ones(self._kept.size, dtype=bool)
        merged = sparse.coo_matrix((ones, (rows, columns)), shape=(self.size, self.size)).tocsr()
        self._columns, self._starts = merged.indices, merged.indptr
        heights = np.repeat(np.arange(self.size), np.diff(self._starts))
        places = heights * self.size + self._columns
        self._slot = np.searchsorted(places, rows * self.size + columns)
        self._parts: dict[bytes, Pattern] = {}

    def local(self, x: Floats) -> Floats:
        """Cells' values (n_cells, n_local) of the free unknowns x."""
        return np.asarray(np.append(x, 0.0)[self._dofs])  # index -1: an unknown held at 0

    def vector(self, local: Floats) -> Floats:
        """Sum (n_free,) of the cells' vectors (n_cells, n_local)."""
        whole = np.bincount(self._dofs.ravel() + 1, local.ravel(), minlength=self.size + 1)
        return np.asarray(whole[1:])

    def matrix(self, local: Floats) -> Sparse:
        """Sum of the cells' matrices, n_local² entries each."""
        return self.of_entries(self.entries(local))

    def entries(self, local: Floats) -> Floats:
        """Stored entries of the sum of the cells' matrices."""
        weights = local.ravel()[self._kept]
        return np.bincount(self._slot, weights, minlength=self._columns.size).astype(float)

    def of_entries(self, entries: Floats) -> Sparse:
        """Matrix of these stored entries."""
        shape = (self.size, self.size)
        return sparse.csr_matrix((entries, self._columns, self._starts), shape=shape)

    def part(self, cells: Ints) -> Pattern:
        """Pattern of some of the cells alone, cached."""
        key = cells.tobytes()
        if key not in self._parts:
            slot = np.full((*self._dofs.shape, self._dofs.shape[1]), -1)
            slot.ravel()[self._kept] = self._slot
            chosen = slot[cells].ravel()
            self._parts[key] = part = copy(self)
            part._dofs = self._dofs[cells]
            part._kept = np.flatnonzero(chosen >= 0)
            part._slot = chosen[part._kept]
        return self._parts[key]


class FieldKernel:
    """F = S Σ_i f_i x_i on every cell, and the integrals of a Newton method over it.

    `reference` (n_local, 3, n_points) are the fields f_i on the reference cell, `transform`
    (n_cells, n_points or 1, 3, 3) is S at the quadrature points, one matrix where it is constant on
    the cell, `weights` (n_cells, n_points) are the volumes (m³) of these points.
    """

    def __init__(
        self, reference: Floats, transform: Floats, weights: Floats, pattern: Pattern
    ) -> None:
        self._n_local, _, self._n_points = reference.shape
        self._transform = np.ascontiguousarray(transform)  # products of other strides take longer
        self._weights = weights
        self._pattern = pattern
        # (local, point * axis) and (point * axis * axis, local * local)
        self._linear = np.ascontiguousarray(reference.transpose(0, 2, 1)).reshape(self._n_local, -1)
        products = np.einsum("iaq,jbq->qabij", reference, reference)
        self._products = products.reshape(9 * self._n_points, -1)

    @property
    def size(self) -> int:
        """Number of free unknowns."""
        return self._pattern.size

    def field(self, x: Floats) -> Floats:
        """F (n_cells, n_points, 3) from the free unknowns x."""
        local = self._pattern.local(x) @ self._linear
        on_reference = local.reshape(local.shape[0], self._n_points, 3)
        return np.asarray(np.einsum("cqab,cqb->cqa", self._transform, on_reference))

    def functional(self, dual: Floats) -> Floats:
        """∫ dual · F_i dV (n_free,) for every free unknown i, dual (cells, points, 3)."""
        pulled = np.einsum("cqab,cqa->cqb", self._transform, dual * self._weights[..., None])
        local = pulled.reshape(pulled.shape[0], -1) @ self._linear.T
        return self._pattern.vector(local)

    def matrix(self, tensor: Floats) -> Sparse:
        """∫ F_i · tensor F_j dV, tensor (cells, points, 3, 3) symmetric."""
        s = self._transform
        pulled = np.swapaxes(s, -1, -2) @ (tensor * self._weights[..., None, None]) @ s
        local = pulled.reshape(pulled.shape[0], -1) @ self._products
        return self._pattern.matrix(local)


class BlockPattern:
    """Where the cells' entries go in a sparse matrix whose entries are blocks.

    `dofs` (n_cells, n_local) are the nodes of the cells, of which there are `size`.
    """

    def __init__(self, dofs: Ints, size: int) -> None:
        self._size = size
        keys = dofs[:, :, None] * np.int64(size) + dofs[:, None, :]
        unique, slot = np.unique(keys.ravel(), return_inverse=True)
        self._slot = slot.reshape(len(dofs), -1)
        self.columns: Ints = unique % size
        self._starts = np.searchsorted(unique, np.arange(size + 1) * np.int64(size))

    def upper(self) -> tuple[Ints, Ints]:
        """Starts (n + 1,) and columns of the upper triangle's compressed rows of blocks."""
        rows = np.repeat(np.arange(self._size), np.diff(self._starts))
        upper = self.columns >= rows
        counts = np.bincount(rows[upper], minlength=self._size)
        return np.concatenate([[0], np.cumsum(counts)]), self.columns[upper]

    def places(self, cells: Ints) -> Sparse:
        """Matrix of ones that adds the entries of some cells to those of the whole."""
        slot = self._slot[cells].ravel()
        ones = np.ones(slot.size)
        return sparse.csr_matrix(
            (ones, (slot, np.arange(slot.size))), shape=(self.columns.size, slot.size)
        )

    def matrix(self, entries: Numbers) -> Sparse:
        """Matrix in compressed rows, `entries` (n, k²) being blocks of k by k."""
        k = round(float(np.sqrt(entries.shape[1])))
        blocks = entries.reshape(-1, k, k)
        shape = (k * self._size, k * self._size)
        return sparse.bsr_matrix((blocks, self.columns, self._starts), shape=shape).tocsr()
