"""Smooth functions of a few numbers, interpolated on nested grids until the interpolation is good.

Chebyshev points with both ends, 2^n + 1 along each axis, of which every second one makes the
grid before: what that one misses at the others is what the error is judged by.  Polynomials
through them by the barycentric formula (J.-P. Berrut and L. N. Trefethen, SIAM Review 46 (2004)
501).  No physics.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace

import numpy as np

from tactgen.geometry.arrays import Floats
from tactgen.geometry.store.values import storable

Value = float | Floats
#: Points along an axis to begin with, as a power of two.
_FIRST = 2


@storable
@dataclass(frozen=True)
class Table:
    """Values at the points of a grid in the box [−1, 1]^k.

    Attributes
    ----------
    powers : tuple of int
        Points along each axis are 2^power + 1.
    values, bars : dict of str to array
        Of the shape of the grid, and of what each value is if that is an array.
    missed : dict of str to float
        What the interpolation may be off by, in units of the bars.
    """

    powers: tuple[int, ...]
    values: dict[str, Floats]
    bars: dict[str, Floats]
    missed: dict[str, float]

    def value(self, name: str, places: Floats) -> Floats:
        """Return a value at places (n, k), (n, ...)."""
        return _read(self.values[name], [chebyshev(p) for p in self.powers], places)

    def bar(self, name: str, places: Floats) -> Floats:
        """Return its error bar (n, ...): of what was solved around, and of the interpolation."""
        points = [chebyshev(power) for power in self.powers]
        above = [
            np.clip(np.searchsorted(x, places[:, axis]), 1, x.size - 1)
            for axis, x in enumerate(points)
        ]
        # the largest of those at the corners of the cell
        corners = itertools.product((0, 1), repeat=len(points))
        around = [
            self.bars[name][tuple(n - low for n, low in zip(above, corner, strict=True))]
            for corner in corners
        ]
        return np.asarray(np.max(around, axis=0) * (1.0 + self.missed[name]))


def chebyshev(power: int) -> Floats:
    """Return 2^power + 1 Chebyshev points from −1 to 1, 0 among them exactly."""
    half = np.arange(1 << (power - 1), -1, -1) / (1 << power)
    left = -np.sin(np.pi * half)
    return np.concatenate([left, -left[-2::-1]])


def first_points() -> Floats:
    """Return the points along each axis of the smallest table."""
    return chebyshev(_FIRST)


def nested_table(
    solve: Callable[[Floats], Mapping[str, tuple[Value, Value]]],
    axes: int,
    *,
    wanted: float,
    most: int,
) -> Table:
    """Return the table of a function, as fine as its interpolation needs.

    Parameters
    ----------
    solve : callable
        Takes a place (k,), gives by name a value, or an array, and its bar.
    wanted : float
        The interpolation's error in units of the bars at which it is good.
    most : int
        Points that are too many; what is reached before is returned.
    """
    found: dict[tuple[float, ...], Mapping[str, tuple[Value, Value]]] = {}
    powers = (_FIRST,) * axes
    while True:
        points = [chebyshev(power) for power in powers]
        places = np.stack(np.meshgrid(*points, indexing="ij"), axis=-1)
        # outwards from the middle, then the ends, then in between
        flat = sorted(map(tuple, places.reshape(-1, axes).tolist()), key=_turn)
        for place in flat:
            if place not in found:
                found[place] = solve(np.array(place))
        table = _tabled(powers, places, found)
        missed = [_missed(table, axis) for axis in range(axes)]
        worst = [max(each.values()) for each in missed]
        axis = int(np.argmax(worst))
        finer = tuple(p + (n == axis) for n, p in enumerate(powers))
        if worst[axis] <= wanted or np.prod([(1 << p) + 1 for p in finer]) > most:
            total = {name: sum(each[name] for each in missed) for name in table.values}
            return replace(table, missed=total)
        powers = finer


def _turn(place: tuple[float, ...]) -> tuple[float, ...]:
    inner = [x for x in place if abs(x) not in (0.0, 1.0)]
    return (float(len(inner)), float(np.abs(place).sum()), *place)


def _tabled(
    powers: tuple[int, ...],
    places: Floats,
    found: dict[tuple[float, ...], Mapping[str, tuple[Value, Value]]],
) -> Table:
    shape = places.shape[:-1]
    rows = [found[tuple(place)] for place in places.reshape(-1, len(powers)).tolist()]
    values, bars = (
        {
            name: np.array([row[name][which] for row in rows]).reshape(*shape, *np.shape(each))
            for name, (each, _) in rows[0].items()
        }
        for which in (0, 1)
    )
    return Table(powers, values, bars, dict.fromkeys(values, 0.0))


def _missed(table: Table, axis: int) -> dict[str, float]:
    """Return what every second point along an axis misses at the others, over the bars.

    All of it counts: smooth functions leave a small part to the whole grid, but magnetisation
    curves from tables have kinks, which may lie anywhere between the points.
    """
    points = chebyshev(table.powers[axis])
    weights = _weights(points[::2], points[1::2])
    missed = {}
    for name, values in table.values.items():
        along, bars = np.moveaxis(values, axis, 0), np.moveaxis(table.bars[name], axis, 0)
        off, bar = np.abs(np.tensordot(weights, along[::2], 1) - along[1::2]), bars[1::2]
        missed[name] = float(np.max(off[bar > 0.0] / bar[bar > 0.0], initial=0.0))
    return missed


def _read(values: Floats, points: list[Floats], places: Floats) -> Floats:
    weights = [_weights(x, places[:, axis]) for axis, x in enumerate(points)]
    found = np.tensordot(weights[0], values, 1)
    for each in weights[1:]:
        found = np.einsum("nj,nj...->n...", each, found)
    return np.asarray(found)


def _weights(points: Floats, at: Floats) -> Floats:
    """Return the barycentric weights (n, p) of Chebyshev points (p,) at places (n,)."""
    signs = np.where(np.arange(points.size) % 2, -1.0, 1.0)
    signs[[0, -1]] *= 0.5
    away = at[:, None] - points
    hit = away == 0.0
    found = signs / np.where(hit, 1.0, away)
    found = np.where(hit.any(axis=1)[:, None], hit, found)
    return np.asarray(found / found.sum(axis=1)[:, None])
