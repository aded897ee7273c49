"""Unknowns of a whole body, or of its quarter in one class of motion at a time.

Planes of symmetry: reflection at x = 0 turns the poling round, so with it goes φ → −φ.
Motions are even or odd at each plane; what is odd vanishes there.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import sparse

from tactgen.fem.piezo.modal_model import Motion
from tactgen.fem.solvers.linear_solver import wide_product
from tactgen.geometry.arrays import Bools, Floats, Ints, Numbers, Sparse

#: Ports that are unknowns: w_base, ψ_base and U.
PORTS = 3


@dataclass(frozen=True)
class Bordered:
    """A symmetric matrix over y = [inner unknowns, w_base, ψ_base, U]."""

    inner: Sparse  #: (n, n) In compressed rows
    border: Numbers  #: (n, 3) Inner unknowns against ports
    corner: Numbers  #: (3, 3) The ports among themselves

    @classmethod
    def cut(cls, matrix: Sparse) -> Bordered:
        """Take a sparse matrix over y apart."""
        rows = matrix.tocsr()
        inner, last = rows[:-PORTS], rows[-PORTS:].toarray()
        return cls(inner[:, :-PORTS].tocsr(), last[:, :-PORTS].T, last[:, -PORTS:])

    def with_base(self, added: Floats) -> Sparse:
        """Part over all unknowns but U, `added` (2, 2) at base motion and rotation."""
        border = sparse.csr_matrix(self.border[:, :2])
        corner = sparse.csr_matrix(self.corner[:2, :2] + added)
        return sparse.bmat([[self.inner, border], [border.T, corner]], format="csr")

    def __matmul__(self, y: Numbers) -> Numbers:
        """Product with y (n + 3,) or (n + 3, k)."""
        inside, ports = y[:-PORTS], y[-PORTS:]
        return np.concatenate(
            [
                self.inner @ inside + self.border @ ports,
                self.border.T @ inside + self.corner @ ports,
            ]
        )

    def wide_product(self, y: Numbers) -> Numbers:
        """Product with y in long double."""
        inside, ports = y[:-PORTS], y[-PORTS:]
        inner = wide_product(self.inner, inside) + self.border.astype(y.dtype) @ ports
        return np.concatenate([inner, self.at_ports(y)])

    def at_ports(self, y: Numbers) -> Numbers:
        """Last three rows of the product with y, in the precision of y."""
        border, corner = (part.astype(y.dtype) for part in (self.border, self.corner))
        return np.asarray(border.T @ y[:-PORTS] + corner @ y[-PORTS:])


#: Signs of (u_x, u_y, u_z, φ) under the reflections at x = 0 and at y = 0.
SIGNS: dict[Motion, tuple[tuple[int, ...], tuple[int, ...]]] = {
    "bending_x": ((1, -1, -1, 1), (1, -1, 1, 1)),
    "bending_y": ((-1, 1, 1, -1), (-1, 1, -1, -1)),
    "torsion": ((1, -1, -1, 1), (-1, 1, -1, -1)),
    "axial": ((-1, 1, 1, -1), (1, -1, 1, 1)),
}
#: Classes of motion in which the ports take no part, the same on any support and circuit, by how
#: many planes of symmetry there are.  Of half a body bending in x includes axial motion, and
#: bending in y torsion.
OTHERS: tuple[tuple[Motion, ...], ...] = ((), ("bending_y",), ("bending_y", "torsion", "axial"))


@dataclass(frozen=True)
class Unknowns:
    """Free unknowns among (n, 4) nodal values, and those prescribed by ports.

    `ports` (4 n, 3) gives the values, in the units of the unknowns, per unit of w_base,
    ψ_base and U.
    """

    free: Bools
    ports: Floats

    @property
    def index(self) -> Ints:
        """Flat positions of the free values."""
        return np.flatnonzero(self.free)

    def bordered(self, matrix: Sparse) -> Bordered:
        """(4 n, 4 n) matrix over [free values, w_base, ψ_base, U]."""
        free, ports = self.index, self.ports
        given = np.flatnonzero(ports.any(axis=1))
        on_ports = matrix[given].T @ ports[given]
        return Bordered(matrix[free][:, free], on_ports[free], ports.T @ on_ports)

    def seen(self, functionals: Floats) -> Floats:
        """Functionals (4 n, k) of all values as those (n_free + 3, k) of the unknowns."""
        return np.vstack([functionals[self.index], self.ports.T @ functionals])

    def translation(self, one: Floats) -> Floats:
        """Unit translation along x (n_free + 3,), `one` (n,) being 1 in the functions."""
        moved = np.zeros((one.size, 4))
        moved[:, 0] = one
        return np.concatenate([moved.ravel()[self.index], [1.0, 0.0, 0.0]])


@dataclass(frozen=True)
class Expansion:
    """(u_x, u_y, u_z, φ) at the nodes of the whole body from unknowns."""

    unknowns: Unknowns
    source: Ints  #: (n_whole,) The node that each node of the whole body is or mirrors
    sign: Floats  #: (n_whole, 4) Factor of each value there
    #: (nodes, functions) each: values of functions along x, y, z at the nodes, where the unknowns
    #: are not nodal values
    lines: tuple[Floats, Floats, Floats] | None = None

    def __matmul__(self, y: Numbers) -> Numbers:
        """(u_x, u_y, u_z, φ) by component, (4 n_whole, …), of unknowns y (n_free + 3, …)."""
        columns = y.reshape(y.shape[0], -1)
        free = self.unknowns.index.size
        values = self.unknowns.ports @ columns[free:]
        values[self.unknowns.index] += columns[:free]
        if self.lines is not None:
            shape = tuple(line.shape[1] for line in self.lines)
            values = values.reshape(*shape, -1)
            for axis, line in enumerate(self.lines):
                values = np.moveaxis(np.tensordot(line, values, axes=(1, axis)), 0, axis)
        at_nodes = values.reshape(-1, 4, columns.shape[1])[self.source] * self.sign[:, :, None]
        return np.asarray(at_nodes.transpose(1, 0, 2).reshape(-1, *y.shape[1:]))


def mirror_signs(motion: Motion, turned: Bools) -> Floats:
    """Signs (n, 4) of the values at nodes on the far side of x = 0 and y = 0 (n, 2)."""
    at_x, at_y = (np.array(signs) for signs in SIGNS[motion])
    return np.where(turned[:, :1], at_x, 1) * np.where(turned[:, 1:], at_y, 1)


def lumped(mass: Sparse) -> Floats:
    """Nodal masses (n,) of a mass matrix over (u_x, u_y, u_z, φ).

    In proportion to the diagonal: row sums may be negative.
    """
    diagonal = np.asarray(mass.diagonal()).reshape(-1, 4)[:, 0]
    return np.asarray(diagonal * (mass.sum() / 3.0 / diagonal.sum()))
