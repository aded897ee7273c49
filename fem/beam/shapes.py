"""What the centre line of the beam elements does between its ends: modes and driven motion.

Read off at the nodes between elements, where w and ψ are unknowns.
"""

from __future__ import annotations

import numpy as np

from tactgen.fem.beam.beam import BeamMatrices
from tactgen.geometry.arrays import Numbers
from tactgen.geometry.bimorph.ends import Ends
from tactgen.geometry.bimorph.row_shape import CentreLine
from tactgen.tmm.ports.elements import base_stiffness, tip_stiffness

#: Elements along a row whose nodes are its stations.
ELEMENTS = 64


def mode_lines(
    matrices: BeamMatrices, ends: Ends, count: int, *, open_circuit: bool
) -> list[CentreLine]:
    """Return the lowest `count` elastic modes of lossless matrices, of unit tip displacement."""
    from scipy.linalg import eigh

    coupling, capacitance = matrices.coupling.real, matrices.capacitance.real
    k, m = (np.array(v.real) for v in (matrices.stiffness, matrices.mass))
    if open_circuit:
        k += np.outer(coupling, coupling) / capacitance
    base, tip = ends.base, ends.conservative_tip
    w0, psi0, w1, _ = matrices.ports
    k[w1, w1] += tip.stiffness
    m[w1, w1] += tip.mass
    if base is not None:
        k[w0, w0] += base.lateral_stiffness
        k[psi0, psi0] += base.rotational_stiffness
        m[psi0, psi0] += base.rotational_inertia
    free = np.setdiff1d(np.arange(k.shape[0]), matrices.ports[: 2 if base is None else 0])
    wanted = ends.rigid_motions + count
    values, vectors = eigh(
        k[np.ix_(free, free)], m[np.ix_(free, free)], subset_by_index=[0, wanted - 1]
    )
    found = []
    for value, vector in list(zip(values, vectors.T, strict=True))[ends.rigid_motions :]:
        motion = np.zeros(k.shape[0])
        motion[free] = vector
        motion /= motion[w1]
        held = float(coupling @ motion)
        voltage = -held / capacitance if open_circuit else 0.0
        charge = 0.0 if open_circuit else held
        found.append(_line(matrices, motion, charge, voltage, np.sqrt(value) / (2.0 * np.pi)))
    return found


def driven_line(
    matrices: BeamMatrices, ends: Ends, frequency: float, voltage: complex
) -> CentreLine:
    """Return the motion at a voltage (V) across each layer."""
    omega2, at = (2.0 * np.pi * frequency) ** 2, np.array([frequency])
    dynamic = matrices.stiffness - omega2 * matrices.mass
    w0, psi0, w1, _ = matrices.ports
    dynamic[w1, w1] += tip_stiffness(ends.tip, at)[0]
    if ends.base is not None:
        for dof, stiffness in zip((w0, psi0), base_stiffness(ends.base, at), strict=True):
            dynamic[dof, dof] += stiffness[0]
    held = matrices.ports[: 2 if ends.base is None else 0]
    free = np.setdiff1d(np.arange(dynamic.shape[0]), held)
    motion = np.zeros(dynamic.shape[0], dtype=complex)
    motion[free] = np.linalg.solve(dynamic[np.ix_(free, free)], matrices.coupling[free] * voltage)
    charge = complex(matrices.coupling @ motion + matrices.capacitance * voltage)
    return _line(matrices, motion, charge, voltage, frequency)


def _line(
    matrices: BeamMatrices, motion: Numbers, charge: complex, voltage: complex, frequency: float
) -> CentreLine:
    z, w, psi = (np.array(column) for column in zip(*matrices.stations, strict=True))
    return CentreLine(z, motion[w], motion[psi], charge, voltage, frequency)
