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
from tactgen.tmm.generator.transient.coil import Means, held_current, held_linkage
from tactgen.tmm.generator.transient.system import System
from tactgen.tmm.reluctance.coenergy.cells import CoenergyPoint

#: Newton's corrections before a time step is called too long, and halvings of one of them.
_ITERATIONS, _HALVINGS = 30, 8
#: Relative correction at which the iterated coordinates stand: it leaves less than this share of
#: the energy that a step moves.
_STANDS = 1e-13
#: Roundings of the terms that the coordinates are the sum of; corrections below are noise.
_NOISE = 8.0 * float(np.finfo(float).eps)

_NO_FIELD = CoenergyPoint(0.0, 0.0, 0.0, 0.0, 0.0, 0.0)


@dataclass(frozen=True, eq=False, slots=True)
class State:
    """The machine at one time.

    Attributes
    ----------
    position, velocity : (n,) float
    voltage : float
        Across the bimorph (V).
    current, gap : float
        In the winding (A); m.
    field : CoenergyPoint
        At that current and gap.
    deformations : tuple of float
        Of the elements.
    """

    position: Floats
    velocity: Floats
    voltage: float
    current: float
    gap: float
    field: CoenergyPoint
    deformations: tuple[float, ...]


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


class _Pushed(NamedTuple):
    """Forces (m,) on what is iterated, their slope (m, m) with the sign turned, field, loss (J)."""

    forces: list[float]
    slope: list[list[float]]
    field: CoenergyPoint
    means: Means
    loss: float


class StepTooLongError(ArithmeticError):
    """The iteration of a step did not settle."""


class _Factors(NamedTuple):
    """What a step length fixes: the inverse (n, n), its rows at the iterated coordinates."""

    inverse: Floats
    at_rows: Floats
    compliance: list[list[float]]


class Stepper:
    """Steps of one system; matrices are kept for each step length."""

    def __init__(self, system: System) -> None:
        self.system = system
        coil = system.coil
        directions = [e.direction for e in system.elements]
        if coil is not None:
            directions = [*directions, coil.direction]
        read = np.any(np.array(directions) != 0.0, axis=0) if directions else []
        self._at = np.flatnonzero(read)
        self._laws = [e.law for e in system.elements]
        self._rows = [np.asarray(e.direction)[self._at].tolist() for e in system.elements]
        self._offsets = [e.offset for e in system.elements]
        self._opens = [] if coil is None else np.asarray(coil.direction)[self._at].tolist()
        self._by_voltage = coil is not None and coil.source == "voltage"
        self._factors: dict[float, _Factors] = {}

    def start(self, position: Floats, velocity: Floats, voltage: float, current: float) -> State:
        """Return a state (n,), (n,), V, A."""
        near = np.asarray(position, dtype=float)
        deformations = tuple(self._deformations(near))
        coil, gap, field = self.system.coil, 0.0, _NO_FIELD
        if coil is not None:
            gap = coil.gap + float(coil.direction @ near)
            field = coil.coenergy.at(current, gap)
        speed = np.asarray(velocity, dtype=float)
        return State(near, speed, voltage, current, gap, field, deformations)

    def energies(self, state: State) -> Energies:
        """Return what is stored, by kind (J)."""
        s, x, v = self.system, state.position, state.velocity
        laws = sum(law.energy(d) for law, d in zip(self._laws, state.deformations, strict=True))
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
        if coil is None or self._by_voltage or current == state.current:
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
        guess = (factors.at_rows @ right).tolist()
        forces, current, field, means, loss = self._settled(state, h, factors, guess, source)
        right[self._at] += forces
        change = factors.inverse @ right
        position = state.position + change
        new = State(
            position,
            (2.0 / h) * change - state.velocity,
            voltage,
            current,
            0.0 if s.coil is None else s.coil.gap + float(s.coil.direction @ position),
            field,
            tuple(self._deformations(position)),
        )
        work = mean_voltage * (
            float(s.coupling @ change) + s.capacitance * (voltage - state.voltage)
        )
        wire = 0.0
        coil_work = means.work
        if s.coil is not None:
            wire = h * s.coil.resistance * means.current**2
            coil_work += wire
        structure = float(change @ s.damping @ change) / h
        return new, Flow(work, coil_work, structure, loss, wire)

    def _settled(
        self,
        state: State,
        h: float,
        factors: _Factors,
        guess: list[float],
        source: tuple[float, float],
    ) -> tuple[list[float], float, CoenergyPoint, Means, float]:
        """Iterate on what laws and coil read: the change y, and the current of a circuit.

        Residuals are y − y_without − S f(y) and, of a circuit, Δλ − h (v̄ − R ī).
        """
        count = len(guess)
        moved = (h * state.velocity[self._at]).tolist()
        sizes = [
            abs(g) + abs(m) + abs(x)
            for g, m, x in zip(guess, moved, state.position[self._at].tolist(), strict=True)
        ]
        terms = abs(state.field.flux_linkage) + h * max(abs(source[0]), abs(source[1]))
        still = _STANDS * terms / state.field.inductance if self._by_voltage else 0.0
        unknown = [*moved, state.current if self._by_voltage else source[1]]
        found = self._pushed(state, h, moved, unknown[-1], source)
        for j, row in enumerate(factors.compliance):
            sizes[j] += sum(abs(a * f) for a, f in zip(row, found.forces, strict=True))
        weights = [*sizes, terms]
        last = [0.0] * (count + 1)
        before, halvings = np.inf, 0
        for _ in range(_ITERATIONS):
            y, current = unknown[:count], unknown[count]
            residual, matrix = self._residual(state, found, factors, y, guess, h, source)
            off = max(
                (abs(r) / s if s else abs(r) and np.inf)
                for r, s in zip([*residual, 0.0], [*weights, 1.0], strict=False)
            )
            if off <= _NOISE:
                return found.forces, current, found.field, found.means, found.loss
            if off > before and halvings < _HALVINGS:
                halvings += 1
                last = [0.5 * c for c in last]
                unknown = [u - c for u, c in zip(unknown, last, strict=True)]
                found = self._pushed(state, h, unknown[:count], unknown[count], source)
                continue
            before, halvings = off, 0
            change = _solved(matrix, [-r for r in residual])
            if not self._by_voltage:
                change.append(0.0)
            if (
                all(
                    abs(c) <= _STANDS * max(abs(u), abs(m)) or abs(c) <= _NOISE * s
                    for c, u, m, s in zip(change, y, moved, sizes, strict=False)
                )
                and abs(change[-1]) <= still
            ):
                return found.forces, current, found.field, found.means, found.loss
            unknown = [u + c for u, c in zip(unknown, change, strict=True)]
            found = self._pushed(state, h, unknown[:count], unknown[count], source)
            last = change
        raise StepTooLongError(f"a step of {h:.3g} s does not settle")

    def _pushed(
        self, state: State, h: float, y: list[float], current: float, source: tuple[float, float]
    ) -> _Pushed:
        """Return what laws and coil answer to a change y of what they read."""
        count = len(y)
        forces, slope, loss = [0.0] * count, [[0.0] * count for _ in y], 0.0
        for law, row, before in zip(self._laws, self._rows, state.deformations, strict=True):
            moved = sum(a * b for a, b in zip(row, y, strict=True))
            force, by_after, elastic = law.mean(before, before + moved, h)
            if force == 0.0 and elastic == 0.0:
                continue
            loss += (force - elastic) * moved
            for j, a in enumerate(row):
                forces[j] -= a * force
                for k, b in enumerate(row):
                    slope[j][k] += a * b * by_after
        coil = self.system.coil
        if coil is None:
            return _Pushed(forces, slope, _NO_FIELD, Means(0.0, 0.0, 0.0), loss)
        gap = state.gap + sum(a * b for a, b in zip(self._opens, y, strict=True))
        field = coil.coenergy.at(current, gap)
        mean = held_linkage if self._by_voltage else held_current
        begin = state.current if self._by_voltage else source[0]
        means = mean(begin, state.gap, state.field, current, gap, field, coil.width)
        for j, a in enumerate(self._opens):
            forces[j] -= a * means.pull
            for k, b in enumerate(self._opens):
                slope[j][k] += 0.5 * a * b * field.force_gradient
        return _Pushed(forces, slope, field, means, loss)

    def _residual(
        self,
        state: State,
        found: _Pushed,
        factors: _Factors,
        y: list[float],
        guess: list[float],
        h: float,
        source: tuple[float, float],
    ) -> tuple[list[float], list[list[float]]]:
        """Return the residuals and their derivatives by y, and by the current of a circuit."""
        compliance, count = factors.compliance, len(y)
        residual = [
            y[j] - guess[j] - sum(a * f for a, f in zip(row, found.forces, strict=True))
            for j, row in enumerate(compliance)
        ]
        matrix = [
            [
                float(j == k) + sum(row[l] * found.slope[l][k] for l in range(count))
                for k in range(count)
            ]
            for j, row in enumerate(compliance)
        ]
        coil = self.system.coil
        if coil is not None and self._by_voltage:
            field = found.field
            half = 0.5 * field.motional
            for line, row in zip(matrix, compliance, strict=True):
                line.append(-half * sum(a * b for a, b in zip(row, self._opens, strict=True)))
            drop = 0.5 * (source[0] + source[1]) - coil.resistance * found.means.current
            residual.append(field.flux_linkage - state.field.flux_linkage - h * drop)
            matrix.append(
                [
                    *(field.motional * b for b in self._opens),
                    field.inductance + 0.5 * h * coil.resistance,
                ]
            )
        return residual, matrix

    def _deformations(self, position: Floats) -> list[float]:
        near = position[self._at].tolist()
        return [
            o + sum(a * b for a, b in zip(row, near, strict=True))
            for row, o in zip(self._rows, self._offsets, strict=True)
        ]

    def _factored(self, h: float) -> _Factors:
        s = self.system
        matrix = (2.0 / h**2) * s.mass + s.damping / h + 0.5 * s.stiffness
        scale = 1.0 / np.sqrt(np.diag(matrix))
        inverse = np.linalg.inv(matrix * scale[:, None] * scale) * scale[:, None] * scale
        inverse = 0.5 * (inverse + inverse.T)
        rows = inverse[self._at]
        found = _Factors(inverse, rows, rows[:, self._at].tolist())
        self._factors[h] = found
        return found


def _solved(matrix: list[list[float]], right: list[float]) -> list[float]:
    """Return the solution of a system of very few equations."""
    if len(right) == 1:
        return [right[0] / matrix[0][0]]
    if len(right) == 2:
        (a, b), (c, d) = matrix
        determinant = a * d - b * c
        return [
            (right[0] * d - b * right[1]) / determinant,
            (a * right[1] - c * right[0]) / determinant,
        ]
    return list(np.linalg.solve(np.array(matrix), np.array(right)).tolist()) if right else []
