"""Forces of springs, stops, friction and coil over a time step.

Plain numbers in lists: for three coordinates and a rim of eight points that is several times
faster than arrays, whose every operation costs as much as a dozen numbers.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from operator import mul, sub
from typing import NamedTuple

import numpy as np

from tactgen.geometry.arrays import Floats, Ints
from tactgen.tmm.generator.transient.machine import Means, held_current, held_linkage
from tactgen.tmm.generator.transient.system import Element, Friction, System
from tactgen.tmm.reluctance.coenergy_map import CoenergyPoint

#: Of a system without a coil.
NO_FIELD = CoenergyPoint(0.0, 0.0, 0.0, 0.0, 0.0, 0.0)


class Answer(NamedTuple):
    """Mean forces over a step.

    `forces` (m,) on the coordinates, `pushed` by each element (N), `slope` (m, m) the forces'
    derivative by the change with the sign turned, `field` after the step, `means` of the coil,
    `loss` in elements and friction (J).
    """

    forces: list[float]
    pushed: list[float]
    slope: list[list[float]]
    field: CoenergyPoint
    means: Means
    loss: float


class _Points:
    """An element's springs: the q coordinates that they read, and how far each could reach.

    `columns` are those of the (p, q) directions, `pairs` their products for the slope's entries on
    and above its diagonal.
    """

    def __init__(self, element: Element, at: Ints) -> None:
        self.law = element.law
        self.directions = np.atleast_2d(element.direction)[:, at]
        self.offsets = np.broadcast_to(
            np.asarray(element.offset, dtype=float), self.directions.shape[:1]
        )
        read = np.flatnonzero(np.any(self.directions != 0.0, axis=0)).tolist()
        columns = self.directions.T[read]
        self.columns = list(zip(read, columns.tolist(), strict=True))
        self.pairs = [
            (k, j, (columns[a] * columns[b]).tolist())
            for a, k in enumerate(read)
            for b, j in enumerate(read)
            if a <= b
        ]
        self.reach = np.abs(self.directions).max(axis=0, initial=0.0).tolist()


class Answers:
    """The laws of a system over the m coordinates that any of them reads, `at`."""

    def __init__(self, system: System) -> None:
        coil = system.coil
        read = [np.atleast_2d(e.direction) for e in system.elements]
        read += [np.atleast_2d(f.direction) for f in system.frictions]
        read += [] if coil is None else [np.atleast_2d(coil.direction)]
        self.at = np.flatnonzero(np.any(np.vstack(read) != 0.0, axis=0)) if read else np.arange(0)
        self.coil = coil
        self.by_voltage = coil is not None and coil.source == "voltage"
        self._points = [_Points(e, self.at) for e in system.elements]
        self._frictions = [(f, np.asarray(f.direction)[self.at].tolist()) for f in system.frictions]
        opens = np.zeros(self.at.size) if coil is None else np.asarray(coil.direction)[self.at]
        self.opens: list[float] = opens.tolist()
        self._opening = [(k, opened) for k, opened in enumerate(self.opens) if opened]
        count = [p.offsets.size for p in self._points]
        self._split = [slice(sum(count[:k]), sum(count[: k + 1])) for k in range(len(count))]
        if count:
            self._directions = np.vstack([p.directions for p in self._points])
            self._offsets = np.concatenate([p.offsets for p in self._points])

    def deformations(self, near: Floats) -> tuple[list[float], ...]:
        """Deformation of each element, from the coordinates (m,) that are read."""
        if not self._points:
            return ()
        each = (self._directions @ near + self._offsets).tolist()
        return tuple(each[part] for part in self._split)

    def over(
        self,
        before: tuple[list[float], ...],
        start: tuple[float, float, CoenergyPoint],
        y: list[float],
        current: float,
        h: float,
    ) -> Answer:
        """Mean forces over a step of `h` seconds with change `y` (m,).

        Parameters
        ----------
        before : tuple of lists
            Deformations before the step.
        start : (float, float, CoenergyPoint)
            Current, gap and field before the step.
        current : float
            After it (A).
        """
        forces = [0.0] * len(y)
        slope = [[0.0] * len(y) for _ in y]
        pushed, steep, loss = [], [], 0.0
        for points, deformed in zip(self._points, before, strict=True):
            push, by_change, lost = _pushed(points, deformed, y, h, forces, slope)
            pushed.append(push)
            steep.append(by_change)
            loss += lost
        for friction, along in self._frictions:
            normal = pushed[friction.element], steep[friction.element]
            loss += _rubbed(friction, along, normal, y, h, forces, slope)
        if self.coil is None:
            return Answer(forces, pushed, slope, NO_FIELD, Means(0.0, 0.0, 0.0), loss)
        gap = start[1] + _product(self.opens, y)
        field = self.coil.coenergy.at(current, gap)
        mean = held_linkage if self.by_voltage else held_current
        means = mean(*start, current, gap, field, self.coil.width)
        half = 0.5 * field.force_gradient
        for k, opened in self._opening:
            forces[k] -= opened * means.pull
            row = slope[k]
            for j, other in self._opening:
                row[j] += half * opened * other
        return Answer(forces, pushed, slope, field, means, loss)

    def sizes(self, found: Answer) -> list[float]:
        """Sizes (m,) of the terms that an answer's forces are sums of."""
        sizes = list(map(abs, found.forces))
        for points, push in zip(self._points, found.pushed, strict=True):
            for k, reach in enumerate(points.reach):
                sizes[k] += push * reach
        for k, opened in self._opening:
            sizes[k] += abs(opened * found.means.pull)
        return sizes


def _pushed(
    points: _Points,
    deformed: list[float],
    y: list[float],
    h: float,
    forces: list[float],
    slope: list[list[float]],
) -> tuple[float, list[float], float]:
    """Add an element's springs to forces and slope.

    Returns
    -------
    tuple of float, (m,) list, float
        Sum of the forces (N), its slope by the changes (N/m), what the springs take (J).
    """
    by_change = [0.0] * len(y)
    farthest = max(deformed) + _product(points.reach, map(abs, y))
    if farthest <= points.law.apart:
        return 0.0, by_change, 0.0
    moved = [0.0] * len(deformed)
    for k, column in points.columns:
        own = y[k]
        moved = [m + own * c for m, c in zip(moved, column, strict=True)]
    pushes, stiff, elastic = points.law.means(deformed, moved, h)
    for k, column in points.columns:
        forces[k] -= _product(pushes, column)
        by_change[k] = _product(stiff, column)
    for k, j, products in points.pairs:
        entry = _product(stiff, products)
        slope[k][j] += entry
        if j != k:
            slope[j][k] += entry
    return sum(pushes), by_change, _product(map(sub, pushes, elastic), moved)


def _rubbed(
    friction: Friction,
    along: list[float],
    normal: tuple[float, list[float]],
    y: list[float],
    h: float,
    forces: list[float],
    slope: list[list[float]],
) -> float:
    """Add a friction to forces and slope, and return its dissipation (J).

    `normal` is what pushes (N) and its slope by the changes (N/m).
    """
    pushed, by_change = normal
    if pushed == 0.0:
        return 0.0
    moved = _product(along, y)
    speed, creep = moved / h, friction.speed
    size = math.hypot(speed, creep)
    share = friction.coefficient * speed / size
    stiff = friction.coefficient * pushed * creep * creep / (size**3 * h)
    for k, c in enumerate(along):
        if c:
            forces[k] -= c * share * pushed
            row = slope[k]
            for j, (b, own) in enumerate(zip(by_change, along, strict=True)):
                row[j] += c * (share * b + stiff * own)
    return share * pushed * moved


def _product(a: Iterable[float], b: Iterable[float]) -> float:
    return float(sum(map(mul, a, b)))
