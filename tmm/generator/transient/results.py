"""Record of a run over time, with its energy balance."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tactgen.geometry.arrays import Floats
from tactgen.tmm.generator.transient.step import Flow, State
from tactgen.tmm.generator.transient.system import System


@dataclass(frozen=True)
class Run:
    """Results of a run at its times (k,)."""

    time: Floats  #: (k,) s; a time at which a source jumps appears twice
    #: (k, n) Coordinates of the system
    position: Floats
    velocity: Floats
    #: (k,) V; A or V
    voltage: Floats
    coil_source: Floats
    #: (k,) A, Wb, m, N, C
    current: Floats
    flux_linkage: Floats
    gap: Floats
    pull: Floats
    charge: Floats
    #: (k,) Energies: of motion, of the structure, of springs and stops, of constant forces, of the
    #: magnetic field, of the bimorph's capacitance (J)
    kinetic: Floats
    strain: Floats
    springs: Floats
    load: Floats
    magnetic: Floats
    electric: Floats
    #: (k,) Given by the sources since the start (J)
    bimorph_work: Floats
    coil_work: Floats
    #: (k,) Taken by dampers, by springs and stops, by the circuit's resistance since the start (J)
    structure_loss: Floats
    element_loss: Floats
    wire_loss: Floats
    #: (k,) Sum since the start of the sizes of all works, losses and changes of one kind of energy
    #: (J): what the balance is judged by
    throughput: Floats

    @property
    def energy(self) -> Floats:
        """All that is stored (k,), in J."""
        mechanical = self.kinetic + self.strain + self.springs + self.load
        return mechanical + self.magnetic + self.electric

    @property
    def imbalance(self) -> Floats:
        """Stored energy less start, works and losses (k,), in J: rounding only."""
        lost = self.structure_loss + self.element_loss + self.wire_loss
        given = self.bimorph_work + self.coil_work
        return np.asarray(self.energy - self.energy[0] - given + lost)

    @property
    def worst_imbalance(self) -> float:
        """Largest energy imbalance relative to throughput or stored energy.

        What rests exchanges rounding only, of which nothing is a share; 0 without any energy.
        """
        kinds = (self.kinetic, self.strain, self.springs, self.load, self.magnetic, self.electric)
        stored = sum(float(np.abs(kind).max()) for kind in kinds)
        whole = max(float(self.throughput[-1]), stored)
        return float(np.abs(self.imbalance).max()) / whole if whole > 0.0 else 0.0


class Record:
    """Collects a run, state by state; its energies are worked out at the end, all at once."""

    def __init__(self, system: System) -> None:
        self._system = system
        self._states: list[State] = []
        self._rows: list[tuple[float, ...]] = []

    def __len__(self) -> int:
        return len(self._rows)

    def add(self, time: float, state: State, flow: Flow, source: float) -> None:
        """Add a state and the energies exchanged on the way."""
        field = state.field
        self._states.append(state)
        self._rows.append(
            (
                time, state.voltage, source, state.current, state.gap, field.flux_linkage,
                field.force, field.coenergy, *flow,
            )
        )  # fmt: skip

    def run(self) -> Run:
        """Collected run."""
        s, states = self._system, self._states
        position = np.array([state.position for state in states])
        velocity = np.array([state.velocity for state in states])
        change = np.array([state.change for state in states])
        time, voltage, source, current, gap, linkage, pull, coenergy, *flows = np.array(
            self._rows
        ).T
        step = np.array([state.lasted for state in states])
        before = np.concatenate([voltage[:1], voltage[:-1]])
        given = change @ s.coupling + s.capacitance * (voltage - before)
        bimorph = 0.5 * (before + voltage) * given
        # nothing moves where no time passes
        structure = _squares(change, s.damping) / np.where(step > 0.0, step, 1.0)
        energies = np.array(
            [
                0.5 * _squares(velocity, s.mass),
                0.5 * _squares(position, s.stiffness),
                self._stored(position),
                -position @ s.load,
                current * linkage - coenergy,
                0.5 * s.capacitance * voltage**2,
            ]
        )
        coil, elements, wire = flows
        exchanged = np.array([bimorph, coil, structure, elements, wire])
        moved = np.abs(np.diff(energies, prepend=energies[:, :1])).sum(axis=0)
        sums = np.cumsum(np.vstack([exchanged, moved + np.abs(exchanged).sum(axis=0)]), axis=1)
        return Run(
            time, position, velocity, voltage, source, current, linkage, gap, pull,
            position @ s.coupling + s.capacitance * voltage, *energies, *sums,
        )  # fmt: skip

    def _stored(self, position: Floats) -> Floats:
        """Energy stored in springs and stops (k,), in J."""
        whole = np.zeros(position.shape[0])
        for element in self._system.elements:
            rows = np.atleast_2d(element.direction)
            whole += element.law.energy(position @ rows.T + element.offset).sum(axis=1)
        return whole


def _squares(rows: Floats, matrix: Floats) -> Floats:
    """Row · matrix · row for each row (k,)."""
    return np.asarray(np.einsum("ki,ki->k", rows @ matrix, rows))


def output_at(run: Run, row: Floats, at: Floats) -> Floats:
    """Output of a run at other times (s): cubics through its values and rates."""
    value, rate = run.position @ row, run.velocity @ row
    k = np.clip(np.searchsorted(run.time, at, "right") - 1, 0, run.time.size - 2)
    h = run.time[k + 1] - run.time[k]
    s = (at - run.time[k]) / h
    rise = value[k + 1] - value[k]
    bend = s * (1.0 - s)
    start, end = h * rate[k] - rise, rise - h * rate[k + 1]
    return np.asarray(value[k] + s * rise + bend * ((1.0 - s) * start + s * end))
