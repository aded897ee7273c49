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
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from tactgen.geometry.arrays import Floats
from tactgen.tmm.generator.transient.answers import NO_FIELD, Answers
from tactgen.tmm.generator.transient.newton import Before, Structure, settled, structure_of
from tactgen.tmm.generator.transient.system import System
from tactgen.tmm.reluctance.coenergy.cells import CoenergyPoint

#: Step lengths whose matrices are kept at once.
_KEPT = 512


@dataclass(frozen=True, slots=True)
class State:
    """The machine at one time.

    Attributes
    ----------
    position, velocity : (n,) float
    change : (n,) float
        Of the position over the step before; 0 at the start.
    acceleration : (n,) float
        Mean over the step before; 0 at the start.
    jerk : (m,) float
        Of the coordinates that are read, by the two steps before; 0 where there are none.
    lasted : float
        The step before (s); 0 at the start and after a jump.
    voltage : float
        Across the bimorph (V).
    current, gap : float
        In the winding (A); m.
    field : CoenergyPoint
        At that current and gap.
    deformations : tuple of lists
        Of each element.
    """

    position: Floats
    velocity: Floats
    change: Floats
    acceleration: Floats
    jerk: Floats
    lasted: float
    voltage: float
    current: float
    gap: float
    field: CoenergyPoint
    deformations: tuple[list[float], ...]


class Flow(NamedTuple):
    """Work of the coil's source over a step, what laws and wire took (J).

    What the voltage gave and the dampers took follows from the states.
    """

    coil_work: float
    element_loss: float
    wire_loss: float


_STILL = Flow(0.0, 0.0, 0.0)


class _Factors(NamedTuple):
    """What a step length fixes, so that the change is linear in the state and the few forces."""

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
        """Return a state (n,), (n,), V, A."""
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
        """Return the charge on the bimorph (C)."""
        s = self.system
        return float(s.coupling @ state.position) + s.capacitance * state.voltage

    def jump(self, state: State, voltage: float, current: float) -> tuple[State, Flow]:
        """Return the state after sources jumped while nothing moved; a circuit keeps its λ."""
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
    """Return the inverse of a symmetric positive definite matrix of mixed units."""
    scale = 1.0 / np.sqrt(np.diag(matrix))
    found = np.linalg.inv(matrix * scale[:, None] * scale) * scale[:, None] * scale
    return np.asarray(0.5 * (found + found.T))
