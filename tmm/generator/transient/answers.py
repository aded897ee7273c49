"""What springs, stops, friction and coil answer to the few coordinates that they read."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from tactgen.geometry.arrays import Floats
from tactgen.tmm.generator.transient.coil import Means, held_current, held_linkage
from tactgen.tmm.generator.transient.system import Friction, System
from tactgen.tmm.reluctance.coenergy.cells import CoenergyPoint

#: Of a system without a coil.
NO_FIELD = CoenergyPoint(0.0, 0.0, 0.0, 0.0, 0.0, 0.0)


class Answer(NamedTuple):
    """What acts over a step.

    `forces` (m,) on the coordinates, `slope` (m, m) their derivative by the change with the sign
    turned, `field` after the step, `means` of the coil, `loss` in elements and friction (J).
    """

    forces: Floats
    slope: Floats
    field: CoenergyPoint
    means: Means
    loss: float


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
        self.laws = [e.law for e in system.elements]
        self._rows = [np.atleast_2d(e.direction)[:, self.at] for e in system.elements]
        self._offsets = [e.offset for e in system.elements]
        self._frictions = [(f, np.asarray(f.direction)[self.at]) for f in system.frictions]
        self.opens = np.zeros(0) if coil is None else np.asarray(coil.direction)[self.at]

    def deformations(self, position: Floats) -> tuple[Floats, ...]:
        """Return those of each element, from a position (n,)."""
        near = position[self.at]
        return tuple(
            row @ near + offset for row, offset in zip(self._rows, self._offsets, strict=True)
        )

    def over(
        self,
        before: tuple[Floats, ...],
        start: tuple[float, float, CoenergyPoint],
        y: Floats,
        current: float,
        h: float,
    ) -> Answer:
        """Return what acts over a step of `h` seconds that changes the coordinates by `y` (m,).

        Parameters
        ----------
        before : tuple of arrays
            Deformations before the step.
        start : (float, float, CoenergyPoint)
            Current, gap and field before the step.
        current : float
            After it (A).
        """
        forces, slope, loss = np.zeros(y.size), np.zeros((y.size, y.size)), 0.0
        normal: list[tuple[float, Floats]] = []
        for law, rows, deformed in zip(self.laws, self._rows, before, strict=True):
            moved = rows @ y
            after = deformed + moved
            if law.apart(deformed, after):
                normal.append((0.0, y))
                continue
            found = law.mean(deformed, after, h)
            stiff = found.slope[:, None] * rows
            forces -= found.force @ rows
            slope += rows.T @ stiff
            loss += float((found.force - found.elastic) @ moved)
            normal.append((float(found.force.sum()), stiff.sum(axis=0)))
        for friction, along in self._frictions:
            loss += _rubbed(friction, along, normal[friction.element], y, h, forces, slope)
        if self.coil is None:
            return Answer(forces, slope, NO_FIELD, Means(0.0, 0.0, 0.0), loss)
        gap = start[1] + float(self.opens @ y)
        field = self.coil.coenergy.at(current, gap)
        mean = held_linkage if self.by_voltage else held_current
        means = mean(*start, current, gap, field, self.coil.width)
        forces -= self.opens * means.pull
        slope += (0.5 * field.force_gradient) * np.outer(self.opens, self.opens)
        return Answer(forces, slope, field, means, loss)


def _rubbed(
    friction: Friction,
    along: Floats,
    normal: tuple[float, Floats],
    y: Floats,
    h: float,
    forces: Floats,
    slope: Floats,
) -> float:
    """Add a friction to forces and slope, and return what it takes (J)."""
    pushed, by_change = normal
    if pushed == 0.0:
        return 0.0
    moved = float(along @ y)
    speed, creep = moved / h, friction.speed
    size = math.hypot(speed, creep)
    share = friction.coefficient * speed / size
    stiff = friction.coefficient * pushed * creep * creep / (size**3 * h)
    forces -= along * (share * pushed)
    slope += np.outer(along, share * by_change + stiff * along)
    return share * pushed * moved
