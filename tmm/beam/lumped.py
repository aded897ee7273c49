"""The lumped model: static closed forms, one consistent mass matrix, one-mode circuit.

Good to about half a percent up to the first bending mode and not meant beyond.  The
statics are exact for the beam (Smits and Choi's bimorph relations with the shim's
stiffness and Timoshenko's shear added); the inertia is that of the static shapes.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import reduce

import numpy as np

from tactgen.geometry.arrays import Complex, Floats
from tactgen.geometry.bimorph.boundary_conditions import Ends
from tactgen.geometry.device.checks import check_read_at_tip
from tactgen.geometry.device.parameters import Beam, Device, Support
from tactgen.tmm.beam.scattering import Element
from tactgen.tmm.beam.sections import Joint, Section
from tactgen.tmm.beam.transfer_matrix import SEGMENTS, sections
from tactgen.tmm.ports.multiport import BIMORPH, Multiport


@dataclass(frozen=True)
class LumpedModel:
    """Port matrices: D(Ω) = stiffness − Ω² mass, shapes (5, 5); see tmm.ports.multiport.BIMORPH."""

    stiffness: Complex
    mass: Floats


@dataclass(frozen=True)
class EquivalentCircuit:
    """The first mode as a mass on a spring, driven through a transformer.

    mass · ẅ + stiffness · w = turns_ratio · U,  Q = turns_ratio · w + blocked_capacitance · U,
    with w the tip displacement.
    """

    #: kg and N/m, referred to the tip
    mass: float
    stiffness: float
    turns_ratio: float  #: N/V (equally C/m)
    blocked_capacitance: float  #: F, with the mode's tip motion held

    @property
    def short_circuit_frequency(self) -> float:
        """Natural frequency at U = 0 (Hz)."""
        return float(np.sqrt(self.stiffness / self.mass) / (2.0 * np.pi))


def lumped_model(row: Sequence[Element]) -> LumpedModel:
    """Port matrices of a row of beams; joints follow statically (Guyan).

    The static state is carried from base to tip: a sum of compliances, which loses no
    digits however short the elements are.
    """
    transfers = [_static_transfer(element, length) for element, length in row]
    whole = reduce(lambda before, after: after @ before, transfers)
    # [w, ψ, F, M, U] at the base, a column for one unit of each port variable
    state = np.zeros((5, 5), dtype=complex)
    state[0, 0] = state[1, 1] = state[4, 4] = 1.0
    state[2:4] = np.linalg.solve(whole[:2, 2:4], np.eye(5)[2:4] - whole[:2] @ state)
    stiffness, mass = np.zeros((5, 5), dtype=complex), np.zeros((5, 5))
    stiffness[:2] = -state[2:4]
    for (element, length), transfer in zip(row, transfers, strict=True):
        after = transfer @ state
        if isinstance(element, Section):
            shape = np.concatenate([state[:2], after[:2]]).real
            mass += shape.T @ _consistent_mass(element, length) @ shape
            stiffness[4] += element.K * (after[1] - state[1])
            stiffness[4, 4] += element.C * length
        state = after
    stiffness[2:4] = state[2:4]
    mass[4] *= -1.0  # the last row is charge, minus what is conjugate to U
    return LumpedModel(stiffness, mass)


def multiport(
    device: Device,
    support: Support,
    beam: Beam,
    frequencies: Floats,
    *,
    lossy: bool = True,
    segments: int = SEGMENTS,
) -> Multiport:
    """Lumped model of the device over its five ports (parallel wiring)."""
    check_read_at_tip(device)
    frequencies = np.atleast_1d(np.asarray(frequencies, dtype=float))
    model = lumped_model(sections(device, support, beam, lossy=lossy, segments=segments))
    o2 = (2.0 * np.pi * frequencies)[:, None, None] ** 2
    return Multiport(frequencies, model.stiffness - o2 * model.mass, BIMORPH)


def equivalent_circuit(
    row: Sequence[Element], ends: Ends, *, open_circuit: bool = False
) -> EquivalentCircuit:
    """First mode of a lossless row, damping at its ends left out.

    With `open_circuit` the mode is that at Q = 0, so its stiffness includes the piezo
    stiffening; the transformer is that of the same shape.
    """
    model = lumped_model(row)
    k, m, coupling, free = _attached(model, ends, open_circuit=open_circuit)
    capacitance = model.stiffness.real[4, 4]
    shape = _first_mode(k, m, free)
    stiffness, turns = float(shape @ k @ shape), float(shape @ coupling)
    # least squares: on a free actuator the rigid motions, which the moments do not drive, drop out
    static = np.linalg.lstsq(k[free, free], coupling[free], rcond=None)[0]
    blocked = capacitance + coupling[free] @ static - turns**2 / stiffness
    return EquivalentCircuit(
        mass=float(shape @ m @ shape),
        stiffness=stiffness,
        turns_ratio=turns,
        blocked_capacitance=float(blocked),
    )


def first_mode(row: Sequence[Element], ends: Ends, *, open_circuit: bool = False) -> Floats:
    """First mode's [w_base, ψ_base, w_tip, ψ_tip, U] per unit of w_tip, and its charge.

    (6,) in m, rad, V and C, each per m.  Remarks as of :func:`equivalent_circuit`.
    """
    model = lumped_model(row)
    k, m, coupling, free = _attached(model, ends, open_circuit=open_circuit)
    shape = _first_mode(k, m, free)
    charge = float(coupling @ shape)
    if open_circuit:
        return np.array([*shape, -charge / model.stiffness.real[4, 4], 0.0])
    return np.array([*shape, 0.0, charge])


def _attached(
    model: LumpedModel, ends: Ends, *, open_circuit: bool
) -> tuple[Floats, Floats, Floats, slice]:
    """Stiffness, mass (4, 4), charge per motion (4,), and which motions are free."""
    k, m = model.stiffness.real[:4, :4].copy(), model.mass[:4, :4].copy()
    coupling, capacitance = -model.stiffness.real[:4, 4], model.stiffness.real[4, 4]
    base, tip = ends.base, ends.conservative_tip
    if base is not None:
        k[0, 0] += base.lateral_stiffness
        k[1, 1] += base.rotational_stiffness
        m[1, 1] += base.rotational_inertia
    for matrix, loaded in zip((k, m), tip.at_tip, strict=True):
        matrix[2:, 2:] += loaded
    if open_circuit:
        k += np.outer(coupling, coupling) / capacitance
    return k, m, coupling, slice(2, 4) if base is None else slice(0, 4)


def _first_mode(stiffness: Floats, mass: Floats, free: slice) -> Floats:
    """Lowest elastic mode (4,) with a unit tip displacement."""
    inverse = np.linalg.inv(np.linalg.cholesky(mass[free, free]))
    values, vectors = np.linalg.eigh(inverse @ stiffness[free, free] @ inverse.T)
    elastic = int(np.flatnonzero(values > 1e-9 * values[-1])[0])  # not a rigid motion
    shape = np.zeros(4)
    shape[free] = inverse.T @ vectors[:, elastic]
    return np.asarray(shape / shape[2])


def _static_transfer(element: Section | Joint, length: float) -> Complex:
    """T (5, 5) with [w, ψ, F, M, U] at the upper end = T · the same at the lower end.

    F is constant and M = M_0 + F z; integrate ψ' = (M + K U)/EI and w' = F/GA − ψ.
    """
    t = np.eye(5, dtype=complex)
    if isinstance(element, Joint):
        t[:2, 2:4] = element.compliance
        return t
    l, ei = length, element.EI
    t[0, 1:] = -l, l / element.GA - l**3 / (6.0 * ei), -(l**2) / (2.0 * ei), 0.0
    t[1, 2:4] = l**2 / (2.0 * ei), l / ei
    t[3, 2] = l
    t[:2, 4] = element.K * t[:2, 3]
    return t


def _consistent_mass(beam: Section, length: float) -> Floats:
    """Consistent mass (4, 4) of the cubic shapes, with rotary inertia (no shear)."""
    l = length
    translation = np.array(
        [
            [156.0, -22.0 * l, 54.0, 13.0 * l],
            [-22.0 * l, 4.0 * l**2, -13.0 * l, -3.0 * l**2],
            [54.0, -13.0 * l, 156.0, 22.0 * l],
            [13.0 * l, -3.0 * l**2, 22.0 * l, 4.0 * l**2],
        ]
    ) * (beam.m * l / 420.0)
    rotation = np.array(
        [
            [36.0, -3.0 * l, -36.0, -3.0 * l],
            [-3.0 * l, 4.0 * l**2, 3.0 * l, -(l**2)],
            [-36.0, 3.0 * l, 36.0, 3.0 * l],
            [-3.0 * l, -(l**2), 3.0 * l, 4.0 * l**2],
        ]
    ) * (beam.rhoI / (30.0 * l))
    return np.asarray(translation + rotation)
