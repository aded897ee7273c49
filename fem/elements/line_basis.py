"""One axis of a tensor grid: its polynomials, of nodes or in a hierarchy, and their matrices.

On boxes all integrals of the solid are products of integrals along the axes, which the
Gauss rule of degree + 1 points gives exactly.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache, lru_cache

import numpy as np
from numpy.polynomial import legendre

from tactgen.geometry.arrays import Bools, Floats, Ints
from tactgen.geometry.bimorph.bricks import Axis, lobatto_points


@dataclass(frozen=True)
class LineMatrices:
    """Sparse matrices of one axis on one common pattern, entries in rows of ascending columns."""

    #: (nnz,) The pattern of all intervals together
    rows: Ints
    columns: Ints
    integrals: Floats  #: (2, 2, nnz) Entry [a, b]: ∫ ∂^a N_i ∂^b N_j over the chosen intervals


@cache
def gauss_values(degree: int, *, hierarchic: bool = False) -> tuple[Floats, Floats]:
    """Weights (points,) of the degree + 1 Gauss points of [−1, 1], and the polynomials there.

    Values, then slopes, (2, points, degree + 1).  In a hierarchy the bubbles are integrals of
    Legendre's polynomials, of unit ∫ N'².
    """
    points, weights = legendre.leggauss(degree + 1)
    to_coefficients = _legendre_coefficients(degree, hierarchic=hierarchic)
    values = legendre.legvander(points, degree) @ to_coefficients
    slopes = np.array([legendre.legval(points, legendre.legder(c)) for c in to_coefficients.T]).T
    return weights, np.stack([values, slopes])


@cache
def _legendre_coefficients(degree: int, *, hierarchic: bool) -> Floats:
    """Each polynomial (column) in those of Legendre."""
    if not hierarchic:
        return np.asarray(np.linalg.inv(legendre.legvander(lobatto_points(degree), degree)))
    found = np.zeros((degree + 1, degree + 1))
    found[:2, 0], found[:2, -1] = (0.5, -0.5), (0.5, 0.5)
    for k in range(2, degree + 1):
        found[[k - 2, k], k - 1] = np.array([-1.0, 1.0]) / np.sqrt(2.0 * (2.0 * k - 1.0))
    return found


@cache
def _reference(degree: int, *, hierarchic: bool) -> Floats:
    """∫ ∂^a N_i ∂^b N_j over [−1, 1], (2, 2, degree + 1, degree + 1)."""
    weights, both = gauss_values(degree, hierarchic=hierarchic)
    return np.asarray(np.einsum("aqi,q,bqj->abij", both, weights, both))


def nodal_values(axis: Axis) -> Floats:
    """Values (nodes, functions) of an axis' functions at its nodes."""
    if not axis.hierarchic:
        return np.eye(axis.nodes.size)
    p = axis.degree
    local = legendre.legvander(lobatto_points(p), p) @ _legendre_coefficients(p, hierarchic=True)
    values = np.zeros((axis.nodes.size, axis.nodes.size))
    for interval in range(axis.intervals):
        at = axis.nodes_of(interval, interval + 1)
        values[at, at] = local
    return values


def values_at(axis: Axis, at: float) -> Floats:
    """Values (n,) of an axis' functions at one point of it (m)."""
    interval = min(max(int(np.searchsorted(axis.breaks, at)) - 1, 0), axis.intervals - 1)
    low, high = axis.breaks[interval : interval + 2]
    local = legendre.legvander(np.array([2.0 * (at - low) / (high - low) - 1.0]), axis.degree)
    values = np.zeros(axis.nodes.size)
    to_coefficients = _legendre_coefficients(axis.degree, hierarchic=axis.hierarchic)
    values[axis.nodes_of(interval, interval + 1)] = (local @ to_coefficients)[0]
    return values


@lru_cache(maxsize=64)
def line_matrices(axis: Axis, first: int = 0, last: int | None = None) -> LineMatrices:
    """Matrices of an axis, integrated over the intervals first … last − 1."""
    n, p = axis.nodes.size, axis.degree
    lengths = np.diff(axis.breaks)
    nodes = p * np.arange(axis.intervals)[:, None] + np.arange(p + 1)
    rows, columns = nodes[:, :, None], nodes[:, None, :]
    pattern = np.zeros((n, n), dtype=bool)
    pattern[rows, columns] = True
    chosen = slice(first, last)
    half = 0.5 * lengths[chosen, None, None]
    reference = _reference(p, hierarchic=axis.hierarchic)
    full = np.zeros((2, 2, n, n))
    for a, b in np.ndindex(2, 2):
        scaled = reference[a, b] * half ** (1 - a - b)
        np.add.at(full[a, b], (rows[chosen], columns[chosen]), scaled)
    full[1, 1] = _without_row_sums(full[1, 1], axis.one == 1.0)
    row, column = np.nonzero(pattern)
    return LineMatrices(row, column, full[:, :, row, column])


def _without_row_sums(stiffness: Floats, moved: Bools) -> Floats:
    """Round ∫ N_i' N_j' so that the sum of those `moved` is exactly zero: a translation.

    Entries become multiples of one power of two, whose sums are exact.  In a slender body
    bending is what is left of stretches (L/h)⁴ times as stiff; row sums that are rounding
    have one sign in all rows of the other axes, and would add up.
    """
    unit = np.exp2(np.ceil(np.log2(np.abs(stiffness).max())) - 49.0)
    rounded = unit * np.round(stiffness / unit)
    # a bubble's slope is orthogonal to those of hats
    rounded[np.ix_(moved, ~moved)], rounded[np.ix_(~moved, moved)] = 0.0, 0.0
    at = np.flatnonzero(moved)
    rounded[at, at] = 0.0
    rounded[at, at] = -rounded[at].sum(axis=1)
    return np.asarray(rounded)


def line_weights(axis: Axis, first: int = 0, last: int | None = None) -> tuple[Floats, Floats]:
    """∫ N_i and ∫ s N_i (n_nodes,) along an axis s, over the intervals first … last − 1."""
    matrices = line_matrices(axis, first, last)
    products = (matrices.integrals[0, 0] * of[matrices.columns] for of in (axis.one, axis.position))
    plain, levered = (np.bincount(matrices.rows, each).astype(float) for each in products)
    return plain, levered
