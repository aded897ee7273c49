"""Symmetric matrices whose last three unknowns, the ports, are dense: sparse with a border."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import sparse

from tactgen.fem.solvers.sparse_rows import wide_product
from tactgen.geometry.arrays import Floats, Numbers, Sparse

#: Ports that are unknowns: w_base, ψ_base and U.
PORTS = 3


@dataclass(frozen=True)
class Bordered:
    """A symmetric matrix over y = [inner unknowns, w_base, ψ_base, U].

    Attributes
    ----------
    inner : (n, n) sparse
        In compressed rows.
    border : (n, 3) array
        Inner unknowns against ports.
    corner : (3, 3) array
        The ports among themselves.
    """

    inner: Sparse
    border: Numbers
    corner: Numbers

    @classmethod
    def cut(cls, matrix: Sparse) -> Bordered:
        """Take a sparse matrix over y apart."""
        rows = matrix.tocsr()
        inner, last = rows[:-PORTS], rows[-PORTS:].toarray()
        return cls(inner[:, :-PORTS].tocsr(), last[:, :-PORTS].T, last[:, -PORTS:])

    def with_base(self, added: Floats) -> Sparse:
        """Return the part over all unknowns but U, `added` (2, 2) at base motion and rotation."""
        border = sparse.csr_matrix(self.border[:, :2])
        corner = sparse.csr_matrix(self.corner[:2, :2] + added)
        return sparse.bmat([[self.inner, border], [border.T, corner]], format="csr")

    def __matmul__(self, y: Numbers) -> Numbers:
        """Return the product with y (n + 3,) or (n + 3, k)."""
        inside, ports = y[:-PORTS], y[-PORTS:]
        return np.concatenate(
            [
                self.inner @ inside + self.border @ ports,
                self.border.T @ inside + self.corner @ ports,
            ]
        )

    def wide_product(self, y: Numbers) -> Numbers:
        """Return the product with y in long double."""
        inside, ports = y[:-PORTS], y[-PORTS:]
        inner = wide_product(self.inner, inside) + self.border.astype(y.dtype) @ ports
        return np.concatenate([inner, self.at_ports(y)])

    def at_ports(self, y: Numbers) -> Numbers:
        """Return the last three rows of the product with y, in the precision of y."""
        border, corner = (part.astype(y.dtype) for part in (self.border, self.corner))
        return np.asarray(border.T @ y[:-PORTS] + corner @ y[-PORTS:])
