"""What the solid does everywhere: natural modes and driven motion as values at all nodes.

Modes come with the potential that they raise and the voltage of an open circuit; driven
states are direct solutions with support, load and losses, by one factorisation each.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tactgen.fem.bimorph.modes import eigenpairs
from tactgen.fem.bimorph.motions import ModeClass, classify
from tactgen.fem.bimorph.system import SolidSystem
from tactgen.fem.solvers.linear_solver import factorise
from tactgen.geometry.arrays import Numbers
from tactgen.geometry.bimorph.ends import Ends
from tactgen.tmm.ports.elements import base_stiffness, tip_stiffness


@dataclass(frozen=True)
class SolidState:
    """One state of motion of the solid, lossless modes real and driven states complex.

    Attributes
    ----------
    frequency : float
        Hz; 0 of a static state.
    values : (n_nodes, 4) array
        (u_x, u_y, u_z) in m and φ in V at the system's nodes.
    tip : complex
        Mean of u_x over the tip face (m).
    charge : complex
        On the outer electrodes (C), layers in parallel.
    kind : str
        Class of a mode; "bending_x" of driven states, the only motion that the ports drive.
    """

    frequency: float
    values: Numbers
    tip: complex
    charge: complex
    kind: ModeClass = "bending_x"

    def scaled(self, factor: float) -> SolidState:
        """Return the state times a real factor."""
        return SolidState(
            self.frequency, factor * self.values, factor * self.tip, factor * self.charge, self.kind
        )


def mode_states(
    system: SolidSystem, ends: Ends, count: int, *, open_circuit: bool = False
) -> list[SolidState]:
    """Return the lowest `count` modes of a lossless system, ascending, of unit modal mass."""
    pairs = zip(*eigenpairs(system, ends, count, open_circuit=open_circuit), strict=True)
    return [_mode(system, value, vector, open_circuit=open_circuit) for value, vector in pairs]


def _mode(system: SolidSystem, value: float, vector: Numbers, *, open_circuit: bool) -> SolidState:
    y = np.zeros(system.size)
    y[: vector.size] = vector
    charges = system.stiffness.border[:, -1], system.stiffness.corner[:, -1]
    minus_charge = np.concatenate(charges)
    if open_circuit and system.has_ports:
        # the last row, minus the charge, is empty
        y[-1] = -(minus_charge[:-1] @ y[:-1]) / minus_charge[-1]
    state = _state(system, float(np.sqrt(value)) / (2.0 * np.pi), y, -complex(minus_charge @ y))
    kind, _ = classify(system.nodes, system.node_mass, state.values[:, :3].real)
    return SolidState(state.frequency, state.values, state.tip, state.charge, kind)


def driven_state(system: SolidSystem, ends: Ends, frequency: float, voltage: complex) -> SolidState:
    """Return the motion at a voltage (V) across each layer, with support and load.

    Base motion and tip force are unknowns beside the voltage: with X the states per unit of
    each, base reactions and the support's forces cancel, and the tip force is minus the
    load's stiffness times the tip displacement.

    Parameters
    ----------
    system : SolidSystem
        Lossy for harmonic states; a lossless one at 0 Hz gives a real static state.
    frequency : float
        Hz.
    """
    omega2 = (2.0 * np.pi * frequency) ** 2
    n, at = system.inner, np.array([frequency])
    if omega2 == 0.0:
        factor = system.held_factor
    else:
        inner = system.stiffness.inner - omega2 * system.mass.inner
        factor = factorise(inner, order=system.elimination)
    ports = system.stiffness.border - omega2 * system.mass.border
    # columns: w_base, ψ_base, U, F_tip
    x = np.zeros((system.size, 4), dtype=np.result_type(ports, system.stiffness.inner.dtype))
    x[n:, :3] = np.eye(3)
    x[:n] = -factor.solve(np.hstack([ports, -system.tip[:n, :1]]))
    reaction = (system.stiffness @ x - omega2 * (system.mass @ x))[n:]
    reaction[:, 3] -= system.tip[n:, 0]  # what the tip force does there is no reaction
    seen = system.tip[:, 0] @ x
    load = tip_stiffness(ends.tip, at)[0]
    rows = np.vstack([reaction[:2], load * seen]).astype(complex)
    rows[2, 3] += 1.0
    free = [0, 1, 3] if ends.base is not None else [3]
    if ends.base is not None:
        for row, stiffness in enumerate(base_stiffness(ends.base, at)):
            rows[row, row] += stiffness[0]
    else:
        rows = rows[2:]
    amplitude = np.zeros(4, dtype=complex)
    amplitude[2] = voltage
    amplitude[free] = np.linalg.solve(rows[:, free], -rows[:, 2] * voltage)
    y = x @ amplitude
    return _state(system, frequency, y, complex(-reaction[2] @ amplitude))


def _state(system: SolidSystem, frequency: float, y: Numbers, charge: complex) -> SolidState:
    values = (system.expand @ y).reshape(4, -1).T
    return SolidState(frequency, values, complex(system.tip[:, 0] @ y), complex(charge))
