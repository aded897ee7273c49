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
from dataclasses import dataclass
from operator import add, mul, sub
from typing import NamedTuple

import numpy as np

from tactgen.geometry.arrays import Floats
from tactgen.tmm.generator.transient.nonlinear_forces import NO_FIELD, Answer, Answers
from tactgen.tmm.generator.transient.system import System
from tactgen.tmm.reluctance.coenergy_map import CoenergyPoint

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

Lists = list[list[float]]


class StepTooLongError(ArithmeticError):
    """The iteration of a step did not settle."""


class Structure(NamedTuple):
    """Linear response of the structure over a step, at the m coordinates read."""

    stiffness: Lists  #: (m, m) D, force per change over the step, symmetric and positive definite
    #: (m, m) |D|, and roundings of |D⁻¹|, below which a correction is noise
    sizes: Lists
    noises: Lists


def structure_of(stiffness: Floats, compliance: Floats) -> Structure:
    """Structure from a stiffness (m, m) and its inverse."""
    return Structure(
        stiffness.tolist(), np.abs(stiffness).tolist(), (_NOISE * np.abs(compliance)).tolist()
    )


class Before(NamedTuple):
    """State at the start of a step, as laws and coil read it."""

    near: list[float]  #: (m,) Coordinates (m or rad)
    deformations: tuple[list[float], ...]  #: Of each element (m)
    #: A, m
    current: float
    gap: float
    field: CoenergyPoint  #: At that current and gap


def settled(
    answers: Answers,
    before: Before,
    h: float,
    free: list[float],
    structure: Structure,
    first: list[float],
    source: tuple[float, float],
) -> tuple[Answer, float]:
    """Converged forces over a step of `h` seconds, and the current after it.

    Parameters
    ----------
    free : (m,) list
        Changes without laws and coil.
    structure : Structure
    first : (m,) list
        A first guess of the changes.
    source : (float, float)
        What the coil's waveform says at both ends of the step (A, or V).

    Raises StepTooLongError if the iteration does not settle.
    """
    count, by_voltage = len(free), answers.by_voltage
    stiffness = structure.stiffness
    start = (before.current if by_voltage else source[0], before.gap, before.field)
    deformed = before.deformations
    unknown = [*first, before.current] if by_voltage else first
    current = before.current if by_voltage else source[1]
    found = answers.over(deformed, start, first, current, h)
    terms = [abs(a) + abs(b) + abs(c) for a, b, c in zip(free, first, before.near, strict=True)]
    size = [
        sum(map(mul, row, terms)) + f
        for row, f in zip(structure.sizes, answers.sizes(found), strict=True)
    ]
    still = list(map(abs, first))
    noise = [sum(map(mul, row, size)) for row in structure.noises]
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
        residual = _residual(answers, before, found, stiffness, unknown, free, h, source)
        off = max([abs(r) / s for r, s in zip(residual, size, strict=True) if s], default=0.0)
        if off <= _NOISE and known:
            return found, current
        if off > _WORSE * worst and halvings < _HALVINGS:
            halvings += 1
            last, came = [0.5 * step for step in last], 0.0
            unknown = [u + step for u, step in zip(unknown, last, strict=True)]
        else:
            worst, halvings = off, 0
            matrix = _slopes(answers, found, stiffness, h)
            last = _solved(matrix, residual)
            share = _STANDS if turn < _PATIENCE else _ROUNDED
            sizes = list(map(abs, last))
            ample = list(map(max, map(abs, unknown), still))
            if all(c <= max(share * a, n) for c, a, n in zip(sizes, ample, noise, strict=True)):
                return found, current
            unknown = list(map(sub, unknown, last))
            ample = list(map(max, map(abs, unknown), still))
            rest = max([c / a for c, a in zip(sizes, ample, strict=True) if a], default=0.0)
            done = rest <= _LAST or rest**3 <= _LEFT * came**2
            came = rest
        current = unknown[-1] if by_voltage else current
        found = answers.over(deformed, start, unknown[:count], current, h)
        if done:
            return found, current
    raise StepTooLongError(f"a step of {h:.3g} s does not settle")


def _residual(
    answers: Answers,
    before: Before,
    found: Answer,
    stiffness: Lists,
    unknown: list[float],
    free: list[float],
    h: float,
    source: tuple[float, float],
) -> list[float]:
    """Residuals (N or N m, and Wb of a circuit)."""
    extra = list(map(sub, unknown, free))  # without a circuit's current
    residual = [
        sum(map(mul, row, extra)) - force
        for row, force in zip(stiffness, found.forces, strict=True)
    ]
    coil = answers.coil
    if coil is not None and answers.by_voltage:
        drop = 0.5 * (source[0] + source[1]) - coil.resistance * found.means.current
        residual.append(found.field.flux_linkage - before.field.flux_linkage - h * drop)
    return residual


def _slopes(answers: Answers, found: Answer, stiffness: Lists, h: float) -> Lists:
    """Residuals' derivatives by the changes, and by the current of a circuit."""
    matrix = [list(map(add, row, steep)) for row, steep in zip(stiffness, found.slope, strict=True)]
    coil = answers.coil
    if coil is None or not answers.by_voltage:
        return matrix
    field = found.field
    for row, opened in zip(matrix, answers.opens, strict=True):
        row.append(-0.5 * field.motional * opened)
    matrix.append(
        [field.motional * b for b in answers.opens] + [field.inductance + 0.5 * h * coil.resistance]
    )
    return matrix


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


class Flow(NamedTuple):
    """Work of the coil's source over a step, losses of laws and wire (J).

    What the voltage gave and the dampers took follows from the states.
    """

    coil_work: float
    element_loss: float
    wire_loss: float


_STILL = Flow(0.0, 0.0, 0.0)


class _Factors(NamedTuple):
    """Factors of one step length: the change is linear in state and few forces."""

    by_velocity: Floats
    by_position: Floats
    by_load: Floats
    by_voltage: Floats
    by_forces: Floats
    structure: Structure


class Stepper:
    """Steps of one system; matrices are kept for each step length."""

    def __init__(self, system: System) -> None:
        self.system = system
        self._answers = Answers(system)
        self._at = self._answers.at
        self._factors: dict[float, _Factors] = {}

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

    def charge(self, state: State) -> float:
        """Charge on the bimorph (C)."""
        s = self.system
        return float(s.coupling @ state.position) + s.capacitance * state.voltage

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

        Parameters
        ----------
        voltage : float
            Across the bimorph at the end (V).
        source : (float, float)
            What the coil's waveform says at both ends of the step (A, or V).

        Raises StepTooLongError if the iteration does not settle.
        """
        at, coil = self._at, self.system.coil
        factors = self._factors.get(h) or self._factored(h)
        change = factors.by_velocity @ state.velocity
        change += factors.by_position @ state.position
        change += factors.by_load
        change += factors.by_voltage * (0.5 * (state.voltage + voltage))
        lasted, was = state.lasted, state.acceleration[at]
        # the mean acceleration on which the iteration starts, by that of the steps before
        ahead = was + (0.5 * (h + lasted)) * state.jerk
        first = h * (state.velocity[at] + (0.5 * h) * ahead)
        near = state.position[at]
        before = Before(near.tolist(), state.deformations, state.current, state.gap, state.field)
        found, current = settled(
            self._answers, before, h, change[at].tolist(), factors.structure,
            first.tolist(), source,
        )  # fmt: skip
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

    def _factored(self, h: float) -> _Factors:
        s, at = self.system, self._at
        matrix = (2.0 / h**2) * s.mass + s.damping / h + 0.5 * s.stiffness
        inverse = _inverted(matrix)
        compliance = inverse[np.ix_(at, at)]
        found = _Factors(
            inverse @ ((2.0 / h) * s.mass),
            -inverse @ s.stiffness,
            inverse @ s.load,
            inverse @ s.coupling,
            inverse[:, at],
            structure_of(_inverted(compliance), compliance),
        )
        if len(self._factors) >= _KEPT:
            self._factors.clear()
        self._factors[h] = found
        return found


def _inverted(matrix: Floats) -> Floats:
    """Inverse of a symmetric positive definite matrix of mixed units."""
    scale = 1.0 / np.sqrt(np.diag(matrix))
    found = np.linalg.inv(matrix * scale[:, None] * scale) * scale[:, None] * scale
    return np.asarray(0.5 * (found + found.T))
