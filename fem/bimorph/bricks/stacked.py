"""Matrices of bricks whose cross-section changes along z: stretch by stretch.

A grid that holds a wide rod and the slender bimorph on it is mostly empty.  Each stretch of one
cross-section is assembled on what it needs of the grid, and takes its place among all nodes.
"""

from __future__ import annotations

from itertools import pairwise

import numpy as np
from scipy import sparse

from tactgen.fem.bimorph.bricks.matrices import brick_matrices
from tactgen.fem.bimorph.system import Material
from tactgen.geometry.arrays import Ints, Sparse
from tactgen.geometry.bimorph.bimorph_bricks import between
from tactgen.geometry.bimorph.bricks import Bricks


def stacked_matrices(
    bricks: Bricks, known: dict[str, Material], unit: float
) -> tuple[Sparse, Sparse]:
    """Return stiffness and mass as :func:`fem.bimorph.bricks.matrices.brick_matrices` does."""
    n = 4 * int(np.prod(bricks.shape))
    totals = None
    for low, high in _stretches(bricks):
        part, nodes = between(bricks, low, high)
        found = [_spread(m, nodes, n) for m in brick_matrices(part, known, unit)]
        totals = found if totals is None else [a + b for a, b in zip(totals, found, strict=True)]
    assert totals is not None
    return totals[0], totals[1]


def _stretches(bricks: Bricks) -> list[tuple[int, int]]:
    """Return the break points along z between which the cross-section is the same."""
    ends = sorted({k for slab in bricks.slabs for k in slab.z})
    return list(pairwise(ends))


def _spread(matrix: Sparse, nodes: Ints, n: int) -> Sparse:
    """Return a matrix over some nodes as one over all n values."""
    values = (4 * nodes[:, None] + np.arange(4)).ravel().astype(np.int32)
    counts = np.zeros(n, dtype=np.int64)
    counts[values] = np.diff(matrix.indptr)
    starts = np.concatenate([[0], np.cumsum(counts)])
    # the nodes ascend, so rows and what is in them stay in their order
    return sparse.csr_matrix((matrix.data, values[matrix.indices], starts), shape=(n, n))
