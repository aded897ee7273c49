"""One time step: the implicit midpoint rule on the structure, discrete gradients on the rest.

With Δ = x₁ − x₀, v₁ = 2Δ/h − v₀ and all means over the step,

    (2 M/h² + C/h + K/2) Δ = 2 M v₀/h − K x₀ + f + θ Ū − Σ d_e f̄_e − b F̄,

    ΔE = Ū ΔQ + ∫ī dλ − Δ·C Δ/h − Σ (f̄_e − f̄_e,elastic) Δδ_e:

the energy of the new state differs from the old one's by what the sources gave and what the
dampers took, whatever the step.  Only the few coordinates that laws and coil read are iterated
on; all others are condensed to them, once for each step length.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterable
from dataclasses import dataclass
from functools import lru_cache
from operator import add, mul, sub
from typing import NamedTuple

import numpy as np

from tactgen.geometry.arrays import Floats, Ints
from tactgen.tmm.generator.transient.system import Element, Friction, System
from tactgen.tmm.reluctance.coenergy_map import CoenergyPoint

#: Of a system without a coil.
NO_FIELD = CoenergyPoint(0.0, 0.0, 0.0, 0.0, 0.0, 0.0)


#: Below this square of the relative change no correction is made: the mean's own error, of third
#: order, is then 1e-15 of the energy, and the correction would be made of rounding.
_LEAST_CHANGE = 1e-10


class Means(NamedTuple):
    """Pull (N), current (A) and the source's work (J) over a step."""

    pull: float
    current: float
    work: float


def coil_means(
    start: tuple[float, float, CoenergyPoint],
    end: tuple[float, float, CoenergyPoint],
    width: float,
    *,
    by_voltage: bool,
) -> Means:
    """Means between two states of current, gap and field; the work is ∫ i dλ.

    Of a circuit whose flux linkages are given, by_voltage, else of given currents.  `width` (m) is
    the gap that the whole circuit is worth.
    """
    (i0, g0, p0), (i1, g1, p1) = start, end
    change, more = g1 - g0, p1.flux_linkage - p0.flux_linkage
    pull = 0.5 * (p0.force + p1.force)
    linkage = 0.5 * (p0.flux_linkage + p1.flux_linkage)
    current = 0.5 * (i0 + i1)
    rise = p1.coenergy - p0.coenergy
    if by_voltage:  # by the energy i λ − W' over λ
        stored = i1 * p1.flux_linkage - i0 * p0.flux_linkage - rise
        ends = p0.flux_linkage, p1.flux_linkage
        current, pull = _discrete_gradient(stored, ends, change, current, pull, width)
        return Means(pull, current, current * more)
    exact, push = _discrete_gradient(rise, (i0, i1), change, linkage, -pull, width)
    # the means of i and λ give ∫ i dλ + ∫ λ di, the change of their product
    return Means(-push, current, current * more + (linkage - exact) * (i1 - i0))


def _discrete_gradient(
    rise: float, ends: tuple[float, float], opened: float, by_x: float, by_gap: float, width: float
) -> tuple[float, float]:
    """Slopes with which changes of x and of the gap make up a function's `rise` (Gonzalez 1996).

    From the means of the slopes at both ends, corrected along the relative changes.
    """
    first, last = ends
    size = max(abs(first), abs(last))
    cx = (last - first) / size if size > 0.0 else 0.0
    cg = opened / width
    square = cx * cx + cg * cg
    if square <= _LEAST_CHANGE:
        return by_x, by_gap
    short = (rise - by_x * (last - first) - by_gap * opened) / square
    return by_x + (short * cx / size if size > 0.0 else 0.0), by_gap + short * cg / width


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

    def deformations(self, near: Floats) -> tuple[list[float], ...]:
        """Deformation of each element, from the coordinates (m,) that are read."""
        return tuple((p.directions @ near + p.offsets).tolist() for p in self._points)

    def over(
        self,
        before: tuple[list[float], ...],
        start: tuple[float, float, CoenergyPoint],
        y: list[float],
        current: float,
        h: float,
    ) -> Answer:
        """Mean forces over a step of `h` seconds with change `y` (m,) and `current` (A) after it.

        `before` are the deformations before the step, `start` current, gap and field.
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
            normal = friction.load, [0.0] * len(y)
            if friction.element is not None:
                normal = pushed[friction.element], steep[friction.element]
            loss += _rubbed(friction, along, normal, y, h, forces, slope)
        if self.coil is None:
            return Answer(forces, pushed, slope, NO_FIELD, Means(0.0, 0.0, 0.0), loss)
        gap = start[1] + _product(self.opens, y)
        field = self.coil.coenergy.at(current, gap)
        end = current, gap, field
        means = coil_means(start, end, self.coil.width, by_voltage=self.by_voltage)
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

    Returns the sum of the forces (N), its slope (m,) by the changes (N/m), what they take (J).
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


#: A correction is halved when the residual has grown by more than this.
_WORSE = 4.0
#: Newton's corrections before a time step is called too long, and halvings of one of them.
_ITERATIONS, _HALVINGS = 30, 8
#: Relative correction at which the iterated coordinates stand: it leaves less than this share of
#: the energy that a step moves.
_STANDS = 1e-13
#: Relative correction after which the next, quadratically smaller, is not tried; and what the next
#: may be by the two before it, c³/b², and is not tried either.
_LAST, _LEFT = 1e-9, 1e-14
#: The same after so many corrections, when what is left goes to and fro with the rounding.
_ROUNDED, _PATIENCE = 1e-11, 6
#: Roundings of the terms that the coordinates are the sum of; corrections below are noise.
_NOISE = 8.0 * 2.0**-52
#: Ratio of the laws' forces to the structure's beyond which a guess lies deep inside a stop.  In
#: the answer both balance; a thousand leaves good guesses alone and their rounding at 1e-12.
_DEEP = 1e3

Lists = list[list[float]]


class StepTooLongError(ArithmeticError):
    """The iteration of a step did not settle."""


class Factors(NamedTuple):
    """The structure over one step length: the change is linear in state and few forces."""

    by_velocity: Floats
    by_position: Floats
    by_load: Floats
    by_voltage: Floats
    by_forces: Floats
    #: At the m coordinates read: (m, m) D, force per change over the step, symmetric and positive
    #: definite; |D|; and roundings of |D⁻¹|, below which a correction is noise
    stiffness: Lists
    sizes: Lists
    noises: Lists


@dataclass(frozen=True, slots=True)
class State:
    """The machine at one time."""

    #: (n,)
    position: Floats
    velocity: Floats
    change: Floats  #: (n,) Of the position over the step before; 0 at the start
    acceleration: Floats  #: (n,) Mean over the step before; 0 at the start
    #: (m,) Of the coordinates that are read, by the two steps before; 0 where there are none
    jerk: Floats
    lasted: float  #: The step before (s); 0 at the start and after a jump
    voltage: float  #: Across the bimorph (V)
    #: In the winding (A); m
    current: float
    gap: float
    field: CoenergyPoint  #: At that current and gap
    deformations: tuple[list[float], ...]  #: Of each element


@dataclass(frozen=True, slots=True)
class Equations:
    """What a step has to fulfil at the m coordinates read, and a circuit's current."""

    answers: Answers  #:
    before: State  #:
    near: list[float]  #: (m,) Coordinates before (m or rad)
    h: float  #: Length of the step (s)
    free: list[float]  #: (m,) Changes without laws and coil
    structure: Factors  #: For such a step
    source: tuple[float, float]  #: What the coil's waveform says at both ends of the step (A or V)

    def answer(self, unknown: list[float]) -> Answer:
        """Forces with the changes, and the current after the step, of a guess."""
        before, (first, last) = self.before, self.source
        if self.answers.by_voltage:
            first, last = before.current, unknown[-1]
        start = first, before.gap, before.field
        y = unknown[: len(self.free)]
        return self.answers.over(before.deformations, start, y, last, self.h)

    def sizes(self, found: Answer, change: list[float]) -> tuple[list[float], list[float]]:
        """Sizes (m,) of the structure's and of the laws' forces at a change (N or N m)."""
        three = zip(self.free, change, self.near, strict=False)  # without a circuit's current
        terms = [abs(a) + abs(b) + abs(c) for a, b, c in three]
        rows = self.structure.sizes
        return [sum(map(mul, row, terms)) for row in rows], self.answers.sizes(found)

    def residual(self, found: Answer, unknown: list[float]) -> list[float]:
        """Residuals (N or N m, and Wb of a circuit)."""
        extra = list(map(sub, unknown, self.free))  # without a circuit's current
        residual = [
            sum(map(mul, row, extra)) - force
            for row, force in zip(self.structure.stiffness, found.forces, strict=True)
        ]
        coil = self.answers.coil
        if coil is not None and self.answers.by_voltage:
            drop = 0.5 * sum(self.source) - coil.resistance * found.means.current
            more = found.field.flux_linkage - self.before.field.flux_linkage
            residual.append(more - self.h * drop)
        return residual

    def slopes(self, found: Answer) -> Lists:
        """Residuals' derivatives by the changes, and by the current of a circuit."""
        pairs = zip(self.structure.stiffness, found.slope, strict=True)
        matrix = [list(map(add, row, steep)) for row, steep in pairs]
        coil, opens, field = self.answers.coil, self.answers.opens, found.field
        if coil is None or not self.answers.by_voltage:
            return matrix
        for row, opened in zip(matrix, opens, strict=True):
            row.append(-0.5 * field.motional * opened)
        own = field.inductance + 0.5 * self.h * coil.resistance
        matrix.append([*(field.motional * b for b in opens), own])
        return matrix


def settled(equations: Equations, first: list[float]) -> tuple[Answer, float]:
    """Converged forces over a step from a first guess (m,) of the changes; the current after it.

    Raises StepTooLongError if the iteration does not settle.
    """
    before, source, h = equations.before, equations.source, equations.h
    by_voltage = equations.answers.by_voltage
    currents = [before.current] if by_voltage else []
    unknown = [*first, *currents]
    found = equations.answer(unknown)
    inertia, forces = equations.sizes(found, unknown)
    if any(f > _DEEP * i for f, i in zip(forces, inertia, strict=True)):
        # Rough surfaces push as an exponential: from deep inside, a correction changes the force
        # by a factor of e only, and rounding of such forces covers it.  Standing still is safe.
        unknown = [*([0.0] * len(first)), *currents]
        found = equations.answer(unknown)
        inertia, forces = equations.sizes(found, unknown)
    size = list(map(add, inertia, forces))
    still = list(map(abs, unknown[: len(first)]))
    noise = [sum(map(mul, row, size)) for row in equations.structure.noises]
    if by_voltage:
        linked = abs(before.field.flux_linkage) + h * max(abs(source[0]), abs(source[1]))
        size.append(linked)
        still.append(linked / before.field.inductance)
        noise.append(_NOISE * linked / before.field.inductance)
    known = all(size)
    worst, halvings, came = math.inf, 0, 0.0
    last = [0.0] * len(unknown)
    for turn in range(_ITERATIONS):
        done = False
        residual = equations.residual(found, unknown)
        off = max([abs(r) / s for r, s in zip(residual, size, strict=True) if s], default=0.0)
        if off <= _NOISE and known:
            break
        if off > _WORSE * worst and halvings < _HALVINGS:
            halvings += 1
            last, came = [0.5 * step for step in last], 0.0
            unknown = [u + step for u, step in zip(unknown, last, strict=True)]
        else:
            worst, halvings = off, 0
            last = _solved(equations.slopes(found), residual)
            share = _STANDS if turn < _PATIENCE else _ROUNDED
            sizes = list(map(abs, last))
            ample = list(map(max, map(abs, unknown), still))
            if all(c <= max(share * a, n) for c, a, n in zip(sizes, ample, noise, strict=True)):
                break
            unknown = list(map(sub, unknown, last))
            ample = list(map(max, map(abs, unknown), still))
            rest = max([c / a for c, a in zip(sizes, ample, strict=True) if a], default=0.0)
            done = rest <= _LAST or rest**3 <= _LEFT * came**2
            came = rest
        found = equations.answer(unknown)
        if done:
            break
    else:
        raise StepTooLongError(f"a step of {h:.3g} s does not settle")
    return found, unknown[-1] if by_voltage else source[1]


def _solved(rows: Lists, right: list[float]) -> list[float]:
    """Solution of a small system by elimination, which changes `rows`.

    Without pivots: the structure's stiffness and pushing springs make them positive.
    """
    n = len(rows)
    found = list(right)
    for k in range(n):
        pivot, own = rows[k], found[k]
        if pivot[k] <= 0.0:
            raise StepTooLongError("pulls beat the structure's inertia over the step")
        for i in range(k + 1, n):
            row = rows[i]
            factor = row[k] / pivot[k]
            if factor:
                for j in range(k + 1, n):
                    row[j] -= factor * pivot[j]
                found[i] -= factor * own
    for k in range(n - 1, -1, -1):
        row, rest = rows[k], found[k]
        for j in range(k + 1, n):
            rest -= row[j] * found[j]
        found[k] = rest / row[k]
    return found


#: Step lengths whose matrices are kept at once.
_KEPT = 512


class Flow(NamedTuple):
    """Work of the coil's source over a step, losses of laws and wire (J).

    What the voltage gave and the dampers took follows from the states.
    """

    coil_work: float
    element_loss: float
    wire_loss: float


_STILL = Flow(0.0, 0.0, 0.0)


class Stepper:
    """Steps of one system; matrices are kept for each step length."""

    def __init__(self, system: System) -> None:
        self.system = system
        self._answers = Answers(system)
        self._at = self._answers.at
        self._factored = lru_cache(_KEPT)(self._factors)

    def start(self, position: Floats, velocity: Floats, voltage: float, current: float) -> State:
        """State (n,), (n,), V, A."""
        where = np.array(position, dtype=float)
        deformations = self._answers.deformations(where[self._at])
        coil, gap, field = self.system.coil, 0.0, NO_FIELD
        if coil is not None:
            gap = coil.gap + float(coil.direction @ where)
            field = coil.coenergy.at(current, gap)
        speed, still = np.array(velocity, dtype=float), np.zeros(where.size)
        calm = np.zeros(self._at.size)
        return State(
            where, speed, still, still, calm, 0.0, voltage, current, gap, field, deformations
        )

    def jump(self, state: State, voltage: float, current: float) -> tuple[State, Flow]:
        """State after sources jumped while nothing moved; a circuit keeps its λ."""
        coil = self.system.coil
        new = dataclasses.replace(
            state,
            change=np.zeros(state.position.size),
            jerk=np.zeros(self._at.size),
            lasted=0.0,
            voltage=voltage,
        )
        if coil is None or self._answers.by_voltage or current == state.current:
            return new, _STILL
        field = coil.coenergy.at(current, state.gap)
        new = dataclasses.replace(new, current=current, field=field)
        stored = current * field.flux_linkage - field.coenergy
        stored -= state.current * state.field.flux_linkage - state.field.coenergy
        return new, Flow(stored, 0.0, 0.0)

    def step(
        self, state: State, h: float, voltage: float, source: tuple[float, float]
    ) -> tuple[State, Flow]:
        """State after a step of `h` seconds, and the exchanged energies.

        `voltage` (V) is that across the bimorph at the end, `source` as of :class:`Equations`.

        Raises StepTooLongError if the iteration does not settle.
        """
        at, coil = self._at, self.system.coil
        factors = self._factored(h)
        change = factors.by_velocity @ state.velocity
        change += factors.by_position @ state.position
        change += factors.by_load
        change += factors.by_voltage * (0.5 * (state.voltage + voltage))
        lasted, was = state.lasted, state.acceleration[at]
        # the mean acceleration on which the iteration starts, by that of the steps before
        ahead = was + (0.5 * (h + lasted)) * state.jerk
        first = h * (state.velocity[at] + (0.5 * h) * ahead)
        equations = Equations(
            self._answers, state, state.position[at].tolist(), h, change[at].tolist(),
            factors, source,
        )  # fmt: skip
        found, current = settled(equations, first.tolist())
        change += factors.by_forces @ found.forces
        position = state.position + change
        velocity = (2.0 / h) * change - state.velocity
        acceleration = (velocity - state.velocity) / h
        jerk = state.jerk
        if lasted > 0.0:
            jerk = (acceleration[at] - was) / (0.5 * (h + lasted))
        new = State(
            position,
            velocity,
            change,
            acceleration,
            jerk,
            h,
            voltage,
            current,
            0.0 if coil is None else coil.gap + float(coil.direction @ position),
            found.field,
            self._answers.deformations(position[at]),
        )
        work, wire = found.means.work, 0.0
        if coil is not None:
            wire = h * coil.resistance * found.means.current**2
        return new, Flow(work + wire, found.loss, wire)

    def _factors(self, h: float) -> Factors:
        s, at = self.system, self._at
        matrix = (2.0 / h**2) * s.mass + s.damping / h + 0.5 * s.stiffness
        inverse = _inverted(matrix)
        compliance = inverse[np.ix_(at, at)]
        stiffness = _inverted(compliance)
        noises = _NOISE * np.abs(compliance)
        return Factors(
            inverse @ ((2.0 / h) * s.mass),
            -inverse @ s.stiffness,
            inverse @ s.load,
            inverse @ s.coupling,
            inverse[:, at],
            stiffness.tolist(),
            np.abs(stiffness).tolist(),
            noises.tolist(),
        )


def _inverted(matrix: Floats) -> Floats:
    """Inverse of a symmetric positive definite matrix of mixed units."""
    scale = 1.0 / np.sqrt(np.diag(matrix))
    found = np.linalg.inv(matrix * scale[:, None] * scale) * scale[:, None] * scale
    return np.asarray(0.5 * (found + found.T))
