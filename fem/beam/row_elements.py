"""Elements along a row of beams, w and ψ of one order: their places, and their integrals."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_matrix

from tactgen.fem.elements.line_basis import gauss_values
from tactgen.geometry.arrays import Complex, Floats, Ints, Numbers

#: Polynomial order of w and ψ (equal orders lock only at low order).
ORDER = 5


@dataclass(frozen=True)
class RowElements:
    """Elements between nodes; w has a hat at every node, then the bubbles of each element.

    Unknowns are w, then ψ.  What is integrated is known at the places of quadrature, whose number
    is exact for a uniform beam.

    Attributes
    ----------
    heights : (n_nodes,) array
        Where the nodes are (m).
    cells : (n_elements, 2) int array
        Nodes of each element, the lower one first.
    """

    heights: Floats
    cells: Ints

    @property
    def functions(self) -> int:
        """How many unknowns w has, and ψ."""
        return self.heights.size + (ORDER - 1) * len(self.cells)

    @property
    def places(self) -> Floats:
        """Heights (n_elements, n_places) in m at which the beam is asked for."""
        points, _ = np.polynomial.legendre.leggauss(ORDER + 1)
        return self.heights[self.cells[:, :1]] + 0.5 * (1.0 + points) * self._lengths

    @property
    def measure(self) -> Floats:
        """Length (n_elements, n_places) in m for which each place stands."""
        weights, _ = gauss_values(ORDER, hierarchic=True)
        return 0.5 * self._lengths * weights

    def elastic(self, ei: Numbers, ga: Numbers) -> Complex:
        """Return ∫ EI ψ' φ' + GA (w' + ψ)(v' + φ) dz, (unknowns, unknowns)."""
        values, slopes = self._values
        none = np.zeros_like(values)
        return self._summed(((ei, none, slopes), (ga, slopes, values)))

    def inertial(self, m: Floats | float, rho_i: Floats | float) -> Floats:
        """Return ∫ m w v + ρI ψ φ dz, (unknowns, unknowns)."""
        values, _ = self._values
        none = np.zeros_like(values)
        return self._summed(((m, values, none), (rho_i, none, values)))

    def bent(self, moment: Complex) -> Complex:
        """Return ∫ M φ' dz, (unknowns,)."""
        _, slopes = self._values
        each = np.einsum("eq,eqi->ei", moment * self.measure, slopes)
        out = np.zeros(2 * self.functions, dtype=each.dtype)
        np.add.at(out, self._unknowns[:, ORDER + 1 :], each)
        return out

    def _summed(self, energies: tuple[tuple[Any, Floats, Floats], ...]) -> NDArray[Any]:
        """Return the sum of ∫ c e ε dz, each with c at the places and the strain e of w and ψ."""
        each: NDArray[Any] = np.zeros(1)
        for constant, of_w, of_psi in energies:
            strain = np.concatenate([of_w, of_psi], axis=2)
            weighed = (constant * self.measure)[:, :, None] * strain
            each = each + strain.transpose(0, 2, 1) @ weighed
        rows, columns = np.broadcast_arrays(self._unknowns[:, :, None], self._unknowns[:, None, :])
        shape = 2 * (2 * self.functions,)
        entries = each.ravel(), (rows.ravel(), columns.ravel())
        return np.asarray(coo_matrix(entries, shape=shape).toarray())

    @property
    def _lengths(self) -> Floats:
        return np.diff(self.heights[self.cells], axis=1)

    @cached_property
    def _values(self) -> tuple[Floats, Floats]:
        """Values and slopes of the functions, (n_elements, n_places, ORDER + 1)."""
        _, (values, slopes) = gauss_values(ORDER, hierarchic=True)
        per_metre = 2.0 / self._lengths[:, :, None]
        return np.broadcast_to(values, (len(self.cells), *values.shape)), per_metre * slopes

    @cached_property
    def _unknowns(self) -> Ints:
        """Numbers of each element's unknowns, (n_elements, 2 (ORDER + 1))."""
        bubbles = np.arange(self.heights.size, self.functions).reshape(-1, ORDER - 1)
        of_w = np.hstack([self.cells[:, :1], bubbles, self.cells[:, 1:]])
        return np.hstack([of_w, of_w + self.functions])
