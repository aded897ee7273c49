"""The co-energy map as one polynomial per cell: what a time step evaluates thousands of times.

Exactly the surface of :mod:`tmm.reluctance.coenergy.map`, re-expanded: in the cell between two
breaks of |i| and two of y = ln(g + g0),

    W' = Σ_pq a_pq s^p t^q,   s = |i| − i_a,   t = y − y_b,   p ≤ 4, q ≤ 3.

Beyond the ends the polynomials of the outermost cells go on, so that an iteration may look there;
whoever accepts a state checks that it lies inside.
"""

from __future__ import annotations

import math
from bisect import bisect_right
from dataclasses import dataclass
from typing import NamedTuple, Protocol

import numpy as np

from tactgen.geometry.arrays import Floats
from tactgen.tmm.reluctance.coenergy.map import CoenergyMap, current_basis


class CoenergyPoint(NamedTuple):
    """W' and its derivatives at one current and gap, in SI units.

    `coenergy` W' (J), `flux_linkage` ∂W'/∂i (Wb), `force` −∂W'/∂g (N, a pull), `inductance`
    ∂²W'/∂i² (H), `motional` ∂²W'/∂i∂g (V s/m), `force_gradient` −∂²W'/∂g² (N/m).
    """

    coenergy: float
    flux_linkage: float
    force: float
    inductance: float
    motional: float
    force_gradient: float


class Coenergy(Protocol):
    """Anything that has a co-energy: a map, or a closed form."""

    def at(self, current: float, gap: float) -> CoenergyPoint:
        """Return W' and its derivatives at a current (A) and gap (m)."""
        ...


@dataclass(frozen=True)
class CoenergyCells:
    """A co-energy map cell by cell.

    Attributes
    ----------
    current_breaks, width_breaks : (c + 1,) and (d + 1,) float
        Ends of the cells: |i| (A), and ln of g + g0 in metres.
    gap_offset : float
        g0 (m).
    coefficients : (c, d, 5, 4) float
        a_pq (J).
    """

    current_breaks: Floats
    width_breaks: Floats
    gap_offset: float
    coefficients: Floats

    def __post_init__(self) -> None:
        # plain lists: a scalar read from an array costs more than the arithmetic
        object.__setattr__(self, "_i", self.current_breaks.tolist())
        object.__setattr__(self, "_y", self.width_breaks.tolist())
        object.__setattr__(self, "_a", self.coefficients.tolist())

    def at(self, current: float, gap: float) -> CoenergyPoint:
        """Return W' and its derivatives at a current (A, either sign) and gap (m)."""
        i, y, a = self._i, self._y, self._a  # type: ignore[attr-defined]
        size, width = abs(current), gap + self.gap_offset
        # an iteration that strays below the iron is led back by the steep end of the map
        level = math.log(max(width, 1e-3 * self.gap_offset))
        row = bisect_right(i, size, 1, len(i) - 1) - 1
        column = bisect_right(y, level, 1, len(y) - 1) - 1
        s, t = size - i[row], level - y[column]
        values = [0.0] * 5
        first = [0.0] * 5
        second = [0.0] * 5
        for p, (c0, c1, c2, c3) in enumerate(a[row][column]):
            values[p] = ((c3 * t + c2) * t + c1) * t + c0
            first[p] = (3.0 * c3 * t + 2.0 * c2) * t + c1
            second[p] = 6.0 * c3 * t + 2.0 * c2
        v0, v1, v2, v3, v4 = values
        d0, d1, d2, d3, d4 = first
        e0, e1, e2, e3, e4 = second
        whole = (((v4 * s + v3) * s + v2) * s + v1) * s + v0
        linkage = ((4.0 * v4 * s + 3.0 * v3) * s + 2.0 * v2) * s + v1
        inductance = (12.0 * v4 * s + 6.0 * v3) * s + 2.0 * v2
        by_y = (((d4 * s + d3) * s + d2) * s + d1) * s + d0
        mixed = ((4.0 * d4 * s + 3.0 * d3) * s + 2.0 * d2) * s + d1
        by_yy = (((e4 * s + e3) * s + e2) * s + e1) * s + e0
        sign = -1.0 if current < 0.0 else 1.0
        return CoenergyPoint(
            whole,
            sign * linkage,
            -by_y / width,
            inductance,
            sign * mixed / width,
            -(by_yy - by_y) / width**2,
        )


def cells(found: CoenergyMap) -> CoenergyCells:
    """Return a map cell by cell."""
    along = current_basis(found.inductance_basis, 0)
    across = found.gap_basis
    return CoenergyCells(
        current_breaks=along.breaks,
        width_breaks=across.breaks,
        gap_offset=found.gap_offset,
        coefficients=np.einsum(
            "ajp,jk,bkq->abpq", along.coefficients, found.coefficients, across.coefficients
        ),
    )
