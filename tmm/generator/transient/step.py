"""One time step: the implicit midpoint rule on the structure, discrete gradients on the rest.

With Δ = x₁ − x₀, v₁ = 2Δ/h − v₀ and all means over the step,

    (2 M/h² + C/h + K/2) Δ = 2 M v₀/h − K x₀ + f + θ Ū − Σ d_e f̄_e − b F̄,

    ΔE = Ū ΔQ + ∫ī dλ − Δ·C Δ/h − Σ (f̄_e − f̄_e,elastic) Δδ_e:

the energy of the new state differs from the old one's by what the sources gave and what the
dampers took, whatever the step.  Only the few coordinates that laws and coil read are iterated
on; all others are condensed to them.
"""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from tactgen.geometry.arrays import Floats
from tactgen.tmm.generator.transient.answers import NO_FIELD, Answer, Answers
from tactgen.tmm.generator.transient.system import System
from tactgen.tmm.reluctance.coenergy.cells import CoenergyPoint

#: A correction is halved when the residual has grown by more than this.
_WORSE = 4.0
#: Newton's corrections before a time step is called too long, and halvings of one of them.
_ITERATIONS, _HALVINGS = 30, 8
#: Relative correction at which the iterated coordinates stand: it leaves less than this share of
#: the energy that a step moves.
_STANDS = 1e-13
#: Relative correction after which the next would be below that, and is not tried.
_LAST = 1e-9
#: The same after so many corrections, when what is left goes to and fro with the rounding.
_ROUNDED, _PATIENCE = 1e-11, 6
#: Roundings of the terms that the coordinates are the sum of; corrections below are noise.
_NOISE = 8.0 * float(np.finfo(float).eps)


@dataclass(frozen=True, eq=False, slots=True)
class State:
    """The machine at one time.

    Attributes
    ----------
    position, velocity : (n,) float
    acceleration : (n,) float
        Mean over the step before; 0 at the start.
    voltage : float
        Across the bimorph (V).
    current, gap : float
        In the winding (A); m.
    field : CoenergyPoint
        At that current and gap.
    deformations : tuple of arrays
        Of each element.
    """

    position: Floats
    velocity: Floats
    acceleration: Floats
    voltage: float
    current: float
    gap: float
    field: CoenergyPoint
    deformations: tuple[Floats, ...]


class Energies(NamedTuple):
    """Of motion, structure, springs and stops, constant forces, magnetic field, capacitor (J)."""

    kinetic: float
    strain: float
    springs: float
    load: float
    magnetic: float
    electric: float


class Flow(NamedTuple):
    """What a step exchanged: work of the two sources, losses of structure, elements, wire (J)."""

    bimorph_work: float
    coil_work: float
    structure_loss: float
    element_loss: float
    wire_loss: float


class StepTooLongError(ArithmeticError):
    """The iteration of a step did not settle."""


class _Factors(NamedTuple):
    """What a step length fixes: the inverse (n, n), its rows at the iterated coordinates."""

    inverse: Floats
    at_rows: Floats
    compliance: Floats


class Stepper:
    """Steps of one system; matrices are kept for each step length."""

    def __init__(self, system: System) -> None:
        self.system = system
        self._answers = Answers(system)
        self._unit = np.eye(self._answers.at.size)
        self._factors: dict[float, _Factors] = {}

    def start(self, position: Floats, velocity: Floats, voltage: float, current: float) -> State:
        """Return a state (n,), (n,), V, A."""
        near = np.asarray(position, dtype=float)
        deformations = self._answers.deformations(near)
        coil, gap, field = self.system.coil, 0.0, NO_FIELD
        if coil is not None:
            gap = coil.gap + float(coil.direction @ near)
            field = coil.coenergy.at(current, gap)
        speed = np.asarray(velocity, dtype=float)
        still = np.zeros(near.size)
        return State(near, speed, still, voltage, current, gap, field, deformations)

    def energies(self, state: State) -> Energies:
        """Return what is stored, by kind (J)."""
        s, x, v = self.system, state.position, state.velocity
        pairs = zip(self._answers.laws, state.deformations, strict=True)
        laws = sum(float(law.energy(d).sum()) for law, d in pairs)
        return Energies(
            0.5 * float(v @ s.mass @ v),
            0.5 * float(x @ s.stiffness @ x),
            laws,
            -float(s.load @ x),
            state.current * state.field.flux_linkage - state.field.coenergy,
            0.5 * s.capacitance * state.voltage**2,
        )

    def charge(self, state: State) -> float:
        """Return the charge on the bimorph (C)."""
        s = self.system
        return float(s.coupling @ state.position) + s.capacitance * state.voltage

    def jump(self, state: State, voltage: float, current: float) -> tuple[State, Flow]:
        """Return the state after sources jumped while nothing moved; a circuit keeps its λ."""
        coil = self.system.coil
        bimorph = 0.5 * self.system.capacitance * (voltage**2 - state.voltage**2)
        if coil is None or self._answers.by_voltage or current == state.current:
            new = dataclasses.replace(state, voltage=voltage)
            return new, Flow(bimorph, 0.0, 0.0, 0.0, 0.0)
        field = coil.coenergy.at(current, state.gap)
        new = dataclasses.replace(state, voltage=voltage, current=current, field=field)
        stored = current * field.flux_linkage - field.coenergy
        stored -= state.current * state.field.flux_linkage - state.field.coenergy
        return new, Flow(bimorph, stored, 0.0, 0.0, 0.0)

    def step(
        self, state: State, h: float, voltage: float, source: tuple[float, float]
    ) -> tuple[State, Flow]:
        """Return the state after a step of `h` seconds, and what was exchanged.

        Parameters
        ----------
        voltage : float
            Across the bimorph at the end (V).
        source : (float, float)
            What the coil's waveform says at both ends of the step (A, or V).

        Raises
        ------
        StepTooLongError
            If the iteration does not settle.
        """
        s = self.system
        factors = self._factors.get(h) or self._factored(h)
        mean_voltage = 0.5 * (state.voltage + voltage)
        right = s.mass @ ((2.0 / h) * state.velocity) - s.stiffness @ state.position
        right += s.load
        right += s.coupling * mean_voltage
        guess = factors.at_rows @ right
        found, current = self._settled(state, h, factors, guess, source)
        right[self._answers.at] += found.forces
        change = factors.inverse @ right
        position = state.position + change
        velocity = (2.0 / h) * change - state.velocity
        new = State(
            position,
            velocity,
            (velocity - state.velocity) / h,
            voltage,
            current,
            0.0 if s.coil is None else s.coil.gap + float(s.coil.direction @ position),
            found.field,
            self._answers.deformations(position),
        )
        work = mean_voltage * (
            float(s.coupling @ change) + s.capacitance * (voltage - state.voltage)
        )
        wire = 0.0
        coil_work = found.means.work
        if s.coil is not None:
            wire = h * s.coil.resistance * found.means.current**2
            coil_work += wire
        structure = float(change @ s.damping @ change) / h
        return new, Flow(work, coil_work, structure, found.loss, wire)

    def _settled(
        self, state: State, h: float, factors: _Factors, guess: Floats, source: tuple[float, float]
    ) -> tuple[Answer, float]:
        """Iterate on what laws and coil read: the change y, and the current of a circuit.

        Residuals are y − y_without − S f(y) and, of a circuit, Δλ − h (v̄ − R ī).
        """
        answers, count = self._answers, guess.size
        start = (state.current if answers.by_voltage else source[0], state.gap, state.field)
        moved = h * (state.velocity + 0.5 * h * state.acceleration)[answers.at]
        size = np.abs(guess) + np.abs(moved) + np.abs(state.position[answers.at])
        unknown: Floats = np.append(moved, state.current) if answers.by_voltage else moved
        current = state.current if answers.by_voltage else source[1]
        found = answers.over(state.deformations, start, moved, current, h)
        size = size + np.abs(factors.compliance) @ np.abs(found.forces)
        still = np.abs(moved)
        if answers.by_voltage:
            terms = abs(state.field.flux_linkage) + h * max(abs(source[0]), abs(source[1]))
            size, still = np.append(size, terms), np.append(still, terms / state.field.inductance)
        known = size > 0.0
        weight = np.where(known, size, np.inf)
        noise = _NOISE * size
        if answers.by_voltage:
            noise[-1] /= state.field.inductance
        before, halvings = np.inf, 0
        last: Floats = np.zeros(unknown.size)
        for turn in range(_ITERATIONS):
            done = False
            residual, matrix = self._residual(state, found, factors, unknown, guess, h, source)
            off = float((np.abs(residual) / weight).max(initial=0.0))
            if off <= _NOISE and known.all():
                return found, current
            if off > _WORSE * before and halvings < _HALVINGS:
                halvings += 1
                last = 0.5 * last
                unknown = unknown - last
            else:
                before, halvings = off, 0
                last = -np.linalg.solve(matrix, residual)
                share = _STANDS if turn < _PATIENCE else _ROUNDED
                small = share * np.maximum(np.abs(unknown), still)
                if (np.abs(last) <= np.maximum(small, noise)).all():
                    return found, current
                unknown = unknown + last
                done = bool((np.abs(last) <= _LAST * np.maximum(np.abs(unknown), still)).all())
            current = float(unknown[-1]) if answers.by_voltage else current
            found = answers.over(state.deformations, start, unknown[:count], current, h)
            if done:
                return found, current
        raise StepTooLongError(f"a step of {h:.3g} s does not settle")

    def _residual(
        self,
        state: State,
        found: Answer,
        factors: _Factors,
        unknown: Floats,
        guess: Floats,
        h: float,
        source: tuple[float, float],
    ) -> tuple[Floats, Floats]:
        """Return the residuals and their derivatives by y, and by the current of a circuit."""
        answers, count = self._answers, guess.size
        residual = unknown[:count] - guess - factors.compliance @ found.forces
        matrix = self._unit + factors.compliance @ found.slope
        coil = self.system.coil
        if coil is None or not answers.by_voltage:
            return residual, matrix
        field = found.field
        whole = np.empty((count + 1, count + 1))
        whole[:count, :count] = matrix
        whole[:count, count] = -0.5 * field.motional * (factors.compliance @ answers.opens)
        whole[count, :count] = field.motional * answers.opens
        whole[count, count] = field.inductance + 0.5 * h * coil.resistance
        drop = 0.5 * (source[0] + source[1]) - coil.resistance * found.means.current
        off = field.flux_linkage - state.field.flux_linkage - h * drop
        return np.append(residual, off), whole

    def _factored(self, h: float) -> _Factors:
        s = self.system
        matrix = (2.0 / h**2) * s.mass + s.damping / h + 0.5 * s.stiffness
        scale = 1.0 / np.sqrt(np.diag(matrix))
        inverse = np.linalg.inv(matrix * scale[:, None] * scale) * scale[:, None] * scale
        inverse = 0.5 * (inverse + inverse.T)
        rows = inverse[self._answers.at]
        found = _Factors(inverse, rows, rows[:, self._answers.at])
        self._factors[h] = found
        return found
