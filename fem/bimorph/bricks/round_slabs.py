"""Integrals over what a circle leaves of bricks: a round body on a grid of boxes.

Bricks that the circle cuts keep their polynomials and lose what lies outside from their
integrals (the finite cell method: Parvizian, Düster and Rank, Computational Mechanics 41, 2007).
The arc is followed exactly, by Gauss points between the axis and the arc.
"""

from __future__ import annotations

from itertools import pairwise
from typing import TypeAlias

import numpy as np
from numpy.polynomial import legendre

from tactgen.fem.elements.line_basis import LineMatrices, line_matrices
from tactgen.geometry.arrays import Floats, Ints
from tactgen.geometry.bimorph.bricks import Axis, Bricks, Slab, lobatto_points

#: Points along x (n,), along y (n,), and their weights (n,).
Points: TypeAlias = tuple[Floats, Floats, Floats]

#: Gauss points per direction of a piece of a cut brick: integrals of degree 8 over an arc of at
#: most a right angle are then right to rounding.
_POINTS = 20
#: Stiffness of what is cut away, relative to the material: unknowns that hardly any material has
#: stay apart in a factorisation, and the body is stiffer by less than this.
_OUTSIDE = 1e-7


def round_matrices(bricks: Bricks, slab: Slab) -> tuple[Floats, Floats]:
    """Return the integrals over a round slab's cross-section.

    Returns
    -------
    area : (pairs along x, pairs along y) array
        ∫ N_i N_j, pairs as :func:`fem.elements.line_basis.line_matrices` has them.
    plane : (2, 2, 2, 2, pairs along x, pairs along y) array
        Entry [a, b, c, d]: ∫ ∂x^a ∂y^c N_i ∂x^b ∂y^d N_j, bricks that the circle cuts filled up
        by a little stiffness.
    """
    axes = bricks.x, bricks.y
    lines = [line_matrices(axis) for axis in axes]
    places = [_places(axis, line) for axis, line in zip(axes, lines, strict=True)]
    shape = tuple(line.rows.size for line in lines)
    plane = np.zeros((2, 2, 2, 2, *shape))
    outside = np.zeros((2, 2, 2, 2, *shape))
    for (i, _), (j, _) in bricks.columns(slab):
        x, y = bricks.x.breaks[i : i + 2], bricks.y.breaks[j : j + 2]
        cut = bool(np.hypot(x[1], y[1]) > slab.radius)
        at = np.ix_(places[0][i].ravel(), places[1][j].ravel())
        whole = _cell(bricks, x, y, _box_points(x, y))
        plane[(..., *at)] += _cell(bricks, x, y, _arc_points(x, y, slab.radius)) if cut else whole
        if cut:
            outside[(..., *at)] += whole
    return plane[0, 0, 0, 0], plane + _OUTSIDE * outside


def _places(axis: Axis, line: LineMatrices) -> Ints:
    """Return where the pairs (intervals, p + 1, p + 1) of each interval are in the pattern."""
    n = axis.nodes.size
    position = np.full((n, n), -1)
    position[line.rows, line.columns] = np.arange(line.rows.size)
    starts = axis.degree * np.arange(axis.intervals)
    nodes = starts[:, None] + np.arange(axis.degree + 1)
    return np.asarray(position[nodes[:, :, None], nodes[:, None, :]])


def _box_points(x: Floats, y: Floats) -> Points:
    """Return Gauss points and weights of a box."""
    points, weights = legendre.leggauss(_POINTS)
    along, across = (0.5 * (v[0] + v[1] + (v[1] - v[0]) * points) for v in (x, y))
    size = 0.25 * (x[1] - x[0]) * (y[1] - y[0])
    return (
        np.repeat(along, _POINTS),
        np.tile(across, _POINTS),
        size * np.outer(weights, weights).ravel(),
    )


def _arc_points(x: Floats, y: Floats, radius: float) -> Points:
    """Return points and weights over what of a box lies inside the circle.

    In strips across x, each from the box's lower face to its upper one or to the arc; along
    the arc the angle is the variable, in which it is smooth where it is steep, too.
    """
    low = np.arccos(min(x[1] / radius, 1.0))
    high = np.arccos(x[0] / radius)
    # above this angle the arc is above the box, below that one below it
    leaves = np.arcsin(min(y[1] / radius, 1.0))
    enters = np.arcsin(y[0] / radius)
    cuts = np.unique(np.clip([low, high, leaves, enters], low, high))
    nodes, weights = legendre.leggauss(_POINTS)
    found = []
    for start, end in pairwise(cuts):
        angle = 0.5 * (start + end + (end - start) * nodes)
        along = radius * np.cos(angle)
        top = np.minimum(radius * np.sin(angle), y[1])
        height = top - y[0]
        if height.max() <= 0.0:
            continue
        width = 0.5 * (end - start) * weights * radius * np.sin(angle)
        across = y[0] + 0.5 * height[:, None] * (1.0 + nodes)
        area = 0.5 * (width * height)[:, None] * weights
        found.append((np.repeat(along, _POINTS), across.ravel(), area.ravel()))
    along, across, weights = (np.concatenate(parts) for parts in zip(*found, strict=True))
    return along, across, weights


def _cell(bricks: Bricks, x: Floats, y: Floats, points: Points) -> Floats:
    """Return the integrals (2, 2, 2, 2, m, n) of one brick's pairs by these points."""
    along, across, weights = points
    of_x, of_y = (
        _products(_values(axis.degree, ends, at))
        for axis, ends, at in ((bricks.x, x, along), (bricks.y, y, across))
    )
    out = np.tensordot(of_x * weights, of_y, axes=(3, 3))
    return np.asarray(out.transpose(0, 1, 3, 4, 2, 5))


def _products(values: Floats) -> Floats:
    """Return the products (2, 2, m, points) of all pairs of values or slopes."""
    _, points, n = values.shape
    both = np.einsum("aqi,bqj->abijq", values, values)
    return np.asarray(both.reshape(2, 2, n * n, points))


def _values(degree: int, ends: Floats, points: Floats) -> Floats:
    """Return the polynomials of an interval and their slopes at points (2, points, degree + 1)."""
    half = 0.5 * (ends[1] - ends[0])
    local = (points - ends[0]) / half - 1.0
    to_coefficients = np.linalg.inv(legendre.legvander(lobatto_points(degree), degree))
    values = legendre.legvander(local, degree) @ to_coefficients
    slopes = legendre.legvander(local, degree - 1) @ legendre.legder(to_coefficients)
    return np.stack([values, slopes / half])
