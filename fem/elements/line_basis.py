"""One axis of a tensor grid: Lagrange polynomials on Gauss–Lobatto nodes and their matrices.

On boxes all integrals of the solid are products of integrals along the axes, which the
Gauss rule of degree + 1 points gives exactly.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

import numpy as np
from numpy.polynomial import legendre

from tactgen.geometry.arrays import Floats, Ints
from tactgen.geometry.bimorph.bricks import Axis, lobatto_points


@dataclass(frozen=True)
class LineMatrices:
    """Sparse matrices of one axis on one common pattern, entries in rows of ascending columns.

    Attributes
    ----------
    rows, columns : (nnz,) int array
        The pattern of all intervals together.
    integrals : (2, 2, nnz) array
        Entry [a, b]: ∫ ∂^a N_i ∂^b N_j over the chosen intervals.
    """

    rows: Ints
    columns: Ints
    integrals: Floats


@cache
def gauss_values(degree: int) -> tuple[Floats, Floats]:
    """Return the polynomials and their slopes at the degree + 1 Gauss points of [−1, 1].

    Returns
    -------
    weights : (points,) array
    values : (2, points, degree + 1) array
        Values, then slopes.
    """
    points, weights = legendre.leggauss(degree + 1)
    to_coefficients = np.linalg.inv(legendre.legvander(lobatto_points(degree), degree))
    values = legendre.legvander(points, degree) @ to_coefficients
    slopes = np.array([legendre.legval(points, legendre.legder(c)) for c in to_coefficients.T]).T
    return weights, np.stack([values, slopes])


@cache
def _reference(degree: int) -> Floats:
    """Return ∫ ∂^a N_i ∂^b N_j over [−1, 1], (2, 2, degree + 1, degree + 1)."""
    weights, both = gauss_values(degree)
    return np.asarray(np.einsum("aqi,q,bqj->abij", both, weights, both))


def line_matrices(axis: Axis, first: int = 0, last: int | None = None) -> LineMatrices:
    """Return the matrices of an axis, integrated over the intervals first … last − 1."""
    chosen = range(first, axis.intervals if last is None else last)
    n, p = axis.nodes.size, axis.degree
    lengths = np.diff(axis.breaks)
    local = np.arange(p + 1)
    pattern = np.zeros((n, n), dtype=bool)
    full = np.zeros((2, 2, n, n))
    for interval in range(axis.intervals):
        at = interval * p + local
        pattern[np.ix_(at, at)] = True
    reference = _reference(p)
    for interval in chosen:
        nodes = interval * p + local
        for a in range(2):
            for b in range(2):
                scaled = reference[a, b] * (0.5 * lengths[interval]) ** (1 - a - b)
                full[a, b][np.ix_(nodes, nodes)] += scaled
    full[1, 1] = _without_row_sums(full[1, 1])
    rows, columns = np.nonzero(pattern)
    return LineMatrices(rows, columns, full[:, :, rows, columns])


def _without_row_sums(stiffness: Floats) -> Floats:
    """Round ∫ N_i' N_j' so that its rows sum to exactly zero: a translation strains nothing.

    Entries become multiples of one power of two, whose sums are exact.  In a slender body
    bending is what is left of stretches (L/h)⁴ times as stiff; row sums that are rounding
    have one sign in all rows of the other axes, and would add up.
    """
    unit = np.exp2(np.ceil(np.log2(np.abs(stiffness).max())) - 49.0)
    rounded = unit * np.round(stiffness / unit)
    np.fill_diagonal(rounded, 0.0)
    np.fill_diagonal(rounded, -rounded.sum(axis=1))
    return np.asarray(rounded)


def line_weights(axis: Axis, first: int = 0, last: int | None = None) -> tuple[Floats, Floats]:
    """Return ∫ N_i and ∫ s N_i (n_nodes,) along an axis s, over the intervals first … last − 1."""
    matrices = line_matrices(axis, first, last)
    mass = matrices.integrals[0, 0]
    n = axis.nodes.size
    levered = mass * axis.nodes[matrices.columns]
    return _row_sums(matrices.rows, mass, n), _row_sums(matrices.rows, levered, n)


def _row_sums(rows: Ints, values: Floats, n: int) -> Floats:
    return np.asarray(np.bincount(rows, values, minlength=n), dtype=float)
