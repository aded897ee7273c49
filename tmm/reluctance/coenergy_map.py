"""The co-energy map W'(i, g): one surface from which all of the normal actuator follows.

Flux linkage λ = ∂W'/∂i, pull F = −∂W'/∂g (positive when it closes the gap), incremental
inductance ∂λ/∂i, motional coefficient ∂λ/∂g.  Any model gives the samples; the map is
the same for all.  How the surface is fitted is told in tmm.reluctance.coenergy_fit.
"""

from __future__ import annotations

import math
from bisect import bisect_right
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, NamedTuple, Protocol

import numpy as np

from tactgen.geometry.arrays import Floats
from tactgen.geometry.errors import InputError
from tactgen.geometry.store.values import storable

#: Degrees of the inductance in the current and of the surface in ln(g + g0).
CURRENT_DEGREE, GAP_DEGREE = 2, 3


def splines(breaks: Floats, degree: int) -> Any:
    """All n B-splines on `breaks` as one SciPy BSpline, which gives values (..., n).

    They are ≥ 0, so a sum of them with coefficients ≥ 0 is so too, sum to 1, and are `degree` − 1
    times continuously differentiable.
    """
    from scipy.interpolate import BSpline  # slow to import

    return BSpline(np.pad(breaks, degree, "edge"), np.eye(breaks.size - 1 + degree), degree)


#: Names of what a map is fitted to, over currents and gaps.
TABLES = ("flux_linkage", "force", "coenergy", "incremental_inductance")
#: How far beyond its ends a map may be asked, relative to its range: rounding of a grid.
_ROUNDING = 1e-9


@storable
@dataclass(frozen=True, eq=False)
class Samples:
    """Samples of a model on a grid of c currents and m gaps."""

    current: Floats  #: (c,) In the winding (A), increasing
    gap: Floats  #: (m,) Working gap (m), increasing
    flux_linkage: Floats  #: (c, m) λ of the whole winding (Wb)
    force: Floats  #: (c, m) Pull (N), positive when it closes the gap
    #: (c, m) W' (J) and ∂λ/∂i (H), if the model has them
    coenergy: Floats | None = None
    incremental_inductance: Floats | None = None
    #: (c, m) Numerical error bar of the force (N), if the model has one
    force_error: Floats | None = None
    #: Which model, of which device; for people
    model: str = ""
    device: str = ""


@storable
@dataclass(frozen=True)
class MapError:
    """Largest errors of the map's flux linkage and force, relative to the value there.

    Values below a tenth of the largest at the same gap count as that tenth.
    """

    flux_linkage: float
    force: float


@storable
@dataclass(frozen=True, eq=False)
class CoenergyMap:
    """The surface W'(i, g) = Σ_jk c_jk J_j(|i|) Y_k(ln(g + g0)).

    Y_k are cubic B-splines.  J_j is the double integral from 0 of a quadratic B-spline, so
    W' vanishes with the current and ∂²W'/∂i² is a sum of B-splines: with c_jk > 0 flux
    linkage increases with the current everywhere, not only at the samples.

    All methods take current (A, either sign) and gap (m), arrays that broadcast, and raise
    InputError outside the samples' range.
    """

    samples: Samples  #: What it was made from
    #: Breaks of the B-splines of the current (A) and of ln(g + g0), g + g0 in metres
    current_breaks: Floats
    width_breaks: Floats
    gap_offset: float  #: g0 (m), about the gap that the rest of the circuit is worth
    coefficients: Floats  #: (j, k) c_jk, all positive
    residual: MapError  #: How far the surface misses its own samples
    #: Error anywhere, estimated by leaving samples out and no less than the residual
    interpolation_error: MapError

    @cached_property
    def bases(self) -> tuple[Any, Any]:
        """J_j over the current and Y_k over ln(g + g0)."""
        return current_basis(self.current_breaks), splines(self.width_breaks, GAP_DEGREE)

    @property
    def current_limit(self) -> float:
        """Largest current of the map (A)."""
        return float(self.samples.current[-1])

    @property
    def gap_limits(self) -> tuple[float, float]:
        """Smallest and largest gap of the map (m)."""
        return float(self.samples.gap[0]), float(self.samples.gap[-1])

    def coenergy(self, current: Floats | float, gap: Floats | float) -> Floats:
        """W' (J)."""
        return self._surface(current, gap, 0, 0)

    def flux_linkage(self, current: Floats | float, gap: Floats | float) -> Floats:
        """Λ = ∂W'/∂i (Wb), odd in the current."""
        return self._surface(current, gap, 1, 0)

    def force(self, current: Floats | float, gap: Floats | float) -> Floats:
        """F = −∂W'/∂g (N), positive when it closes the gap."""
        return -self._surface(current, gap, 0, 1)

    def incremental_inductance(self, current: Floats | float, gap: Floats | float) -> Floats:
        """∂λ/∂i (H), positive."""
        return self._surface(current, gap, 2, 0)

    def energy(self, current: Floats | float, gap: Floats | float) -> Floats:
        """Stored energy W = iλ − W' (J)."""
        return np.asarray(current) * self.flux_linkage(current, gap) - self.coenergy(current, gap)

    def motional_coefficient(self, current: Floats | float, gap: Floats | float) -> Floats:
        """∂λ/∂g = −∂F/∂i (V s/m): voltage per speed of the gap, negative for i > 0."""
        return self._surface(current, gap, 1, 1)

    def force_gradient(self, current: Floats | float, gap: Floats | float) -> Floats:
        """∂F/∂g at constant current (N/m), usually negative: a destabilising spring."""
        return -self._surface(current, gap, 0, 2)

    def sampled(self, currents: Floats, gaps: Floats) -> Samples:
        """Map values on a grid of currents (c,) and gaps (m,)."""
        i, g = np.asarray(currents, dtype=float)[:, None], np.asarray(gaps, dtype=float)[None]
        tables: dict[str, Any] = {name: getattr(self, name)(i, g) for name in TABLES}
        return replace(self.samples, current=i[:, 0], gap=g[0], force_error=None, **tables)

    def _surface(
        self, current: Floats | float, gap: Floats | float, by_current: int, by_gap: int
    ) -> Floats:
        """Derivative of W' by current and gap."""
        i, g = np.broadcast_arrays(np.asarray(current, dtype=float), np.asarray(gap, dtype=float))
        size, width = np.abs(i), g + self.gap_offset
        self._check(size, g)
        of_current, of_gap = self.bases
        across = gap_derivative(of_gap, width, by_gap)
        value = np.sum((of_current(size, by_current) @ self.coefficients) * across, axis=-1)
        return np.asarray(np.sign(i) * value if by_current == 1 else value)

    def _check(self, size: Floats, gap: Floats) -> None:
        limit, (low, high) = self.current_limit, self.gap_limits
        if not (size <= limit * (1.0 + _ROUNDING)).all():
            worst = float(np.max(size))
            raise InputError(
                f"current = {worst * 1e3:.6g} mA lies outside the map of the normal actuator, "
                f"which ends at {limit * 1e3:.6g} mA; use a smaller one or a larger map"
            )
        slack = _ROUNDING * (high - low)
        if not ((gap >= low - slack) & (gap <= high + slack)).all():
            worst = float(gap.flat[np.argmax(np.abs(gap - 0.5 * (low + high)))])
            raise InputError(
                f"gap = {worst * 1e6:.6g} um lies outside the map of the normal actuator, which "
                f"goes from {low * 1e6:.6g} to {high * 1e6:.6g} um; stay inside or use a larger map"
            )


def current_basis(breaks: Floats) -> Any:
    """Functions of the current in W': double integrals of B-splines, those of ∂λ/∂i."""
    return splines(breaks, CURRENT_DEGREE).antiderivative(2)


def gap_derivative(gap_basis: Any, width: Floats, derivative: int) -> Floats:
    """D^n/dg^n of the functions of ln(g + g0) at `width` = g + g0, n up to 2."""
    y = np.log(width)
    if derivative == 0:
        return np.asarray(gap_basis(y))
    first = gap_basis(y, 1)
    if derivative == 1:
        return np.asarray(first / width[..., None])
    return np.asarray((gap_basis(y, 2) - first) / width[..., None] ** 2)


def closed_loop_work(
    model: Callable[[Floats, Floats], Samples],
    currents: tuple[float, float],
    gaps: tuple[float, float],
    panels: int = 64,
) -> tuple[float, float]:
    """∮ (λ di − F dg) (J) around a rectangle in the plane of current and gap.

    A model whose flux linkage and force come from one co-energy does no net work.

    Parameters
    ----------
    model : callable
        Takes currents (c,) and gaps (m,), returns their Samples.
    currents, gaps : (float, float)
        Sides of the rectangle (A, m).
    panels : int
        Pieces into which a side is divided, each with five Gauss points.

    Returns
    -------
    net, side : float
        The loop's work and, to judge it by, the largest of its four sides' (J).
    """
    i, i_weights = _quadrature(currents, panels)
    g, g_weights = _quadrature(gaps, panels)
    electrical = i_weights @ model(i, np.array(gaps)).flux_linkage
    mechanical = -(model(np.array(currents), g).force @ g_weights)
    net = electrical[0] + mechanical[1] - electrical[1] - mechanical[0]
    return float(net), float(np.abs([*electrical, *mechanical]).max())


def _quadrature(ends: tuple[float, float], panels: int) -> tuple[Floats, Floats]:
    points, weights = np.polynomial.legendre.leggauss(5)
    edges = np.linspace(*ends, panels + 1)
    half = 0.5 * np.diff(edges)[:, None]
    return (edges[:-1, None] + half * (1.0 + points)).ravel(), (half * weights).ravel()


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
        """W' and its derivatives at a current (A) and gap (m)."""
        ...


@dataclass(frozen=True)
class CoenergyCells:
    """A co-energy map cell by cell.

    In lists, as a scalar read from an array costs more than the arithmetic.
    """

    #: (c + 1,) Ends of the cells: |i| (A), and ln of g + g0 in metres
    current_breaks: list[float]
    width_breaks: list[float]
    gap_offset: float  #: g0 (m)
    coefficients: list[list[list[list[float]]]]  #: (c, d, 5, 4) a_pq (J)

    def at(self, current: float, gap: float) -> CoenergyPoint:
        """W' and its derivatives at a current (A, either sign) and gap (m)."""
        i, y, a = self.current_breaks, self.width_breaks, self.coefficients
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
    """Map cell by cell: the functions' Taylor series at the breaks."""
    i, y = found.current_breaks, found.width_breaks
    along, across = (
        [basis(breaks[:-1], p) / math.factorial(p) for p in range(basis.k + 1)]
        for basis, breaks in zip(found.bases, (i, y), strict=True)
    )
    coefficients = np.einsum("paj,jk,qbk->abpq", along, found.coefficients, across)
    return CoenergyCells(i.tolist(), y.tolist(), found.gap_offset, coefficients.tolist())
