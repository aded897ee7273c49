"""The machine in small motions as a state space, for control engineers' tools.

    x' = a x + b u,   y = c x + d u,

about the place where the rod rests: the rod over w, ψ and its lift, on contact, spring and field
as :mod:`tmm.generator.small_signal` linearises them; the bimorph as modes over it; with a voltage
held in the coil its flux linkage too, λ' = v − R i, λ = L i + T u.  Energies and signs are those
of the ports, so the axial poles are those of `axial_poles`.  Each mode has the viscous damping
that loses at its own frequency what the constant loss factor loses there.  The tip is free: what
touches it is connected from outside, at the input "tip force".
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np

from tactgen.geometry.arrays import Floats
from tactgen.tmm.generator.small_signal import Linearised
from tactgen.tmm.generator.transient.bimorph import BimorphModes

#: Inputs besides the coil's, and outputs besides the coil's current, each with its unit.
_INPUTS = ("bimorph voltage (V)", "tip force (N)")
_OUTPUTS = ("lateral tip (m)", "lift (m)")
_LIFT = 2


@dataclass(frozen=True)
class MachineStateSpace:
    """Matrices in SI units, (m, m), (m, 3), (p, m), (p, 3), and what the columns and rows are."""

    a: Floats
    b: Floats
    c: Floats
    d: Floats
    inputs: tuple[str, ...]
    outputs: tuple[str, ...]


def machine_state_space(
    rod: Linearised, modes: BimorphModes, *, supply: Literal["current", "voltage"]
) -> MachineStateSpace:
    """Return the machine with changes of the coil's current, or of its voltage, as third input.

    Parameters
    ----------
    rod : Linearised
        About its resting place; the bimorph's mass along the axis is in it.
    modes : BimorphModes
        Of the bimorph over the rod's head, wired as it is.
    """
    k = modes.omega.size
    n, own = 3 + k, slice(3, 3 + k)
    mass, damping, stiffness = np.eye(n), np.zeros((n, n)), np.zeros((n, n))
    mass[:3, :3] = rod.mass
    mass[:2, :2] += modes.rigid
    mass[own, :2], mass[:2, own] = modes.inertia, modes.inertia.T
    damping[:3, :3], damping[own, own] = rod.damping, np.diag(modes.damping)
    stiffness[:3, :3], stiffness[own, own] = rod.stiffness, np.diag(modes.omega**2)
    tip = np.concatenate([modes.tip[:2], [0.0], modes.tip[2:]])
    lift = np.eye(n)[_LIFT]
    forces = np.stack([np.concatenate([np.zeros(3), modes.coupling]), tip, rod.motional * lift], 1)
    pushed = np.linalg.solve(mass, np.hstack([-stiffness, -damping, forces]))
    a = np.zeros((2 * n, 2 * n))
    a[:n, n:], a[n:] = np.eye(n), pushed[:, : 2 * n]
    b = np.vstack([np.zeros((n, 3)), pushed[:, 2 * n :]])
    c = np.hstack([np.stack([tip, lift]), np.zeros((2, n))])
    inputs: tuple[str, ...] = (*_INPUTS, "coil current (A)")
    outputs: tuple[str, ...] = _OUTPUTS
    if supply == "voltage":
        # the current i = (λ − T u)/L takes the place of the third input
        reads = np.append(np.zeros(2 * n), 1.0 / rod.inductance)
        reads[_LIFT] = -rod.motional / rod.inductance
        a = np.pad(a, (0, 1))
        a[:-1] += np.outer(b[:, 2], reads)
        a[-1] = -rod.resistance * reads
        b = np.vstack([b, np.zeros(3)])
        b[:-1, 2], b[-1, 2] = 0.0, 1.0
        c = np.vstack([np.pad(c, ((0, 0), (0, 1))), reads])
        inputs, outputs = (*_INPUTS, "coil voltage (V)"), (*_OUTPUTS, "coil current (A)")
    return MachineStateSpace(a, b, c, np.zeros((c.shape[0], 3)), inputs, outputs)
