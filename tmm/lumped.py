"""The lumped model: static closed forms, one consistent mass matrix, one-mode circuit.

Good to about half a percent up to the first bending mode and not meant beyond.  The
statics are exact for the beam (Smits and Choi's bimorph relations with the shim's
stiffness and Timoshenko's shear added); the inertia is that of the static shapes.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from geometry.arrays import Complex, Floats
from geometry.parameters import Beam, Device, Support
from tmm.modes import Fixture
from tmm.multiport import Multiport, condense
from tmm.section import Section
from tmm.transfer_matrix import sections


@dataclass(frozen=True)
class LumpedModel:
    """Port matrices: D(Ω) = stiffness − Ω² mass, shapes (5, 5); see tmm.multiport."""

    stiffness: Complex
    mass: Floats


@dataclass(frozen=True)
class EquivalentCircuit:
    """The first mode as a mass on a spring, driven through a transformer.

    mass · ẅ + stiffness · w = turns_ratio · U,  Q = turns_ratio · w + blocked_capacitance · U,
    with w the tip displacement.

    Attributes
    ----------
    mass, stiffness : float
        kg and N/m, referred to the tip.
    turns_ratio : float
        N/V (equally C/m).
    blocked_capacitance : float
        F, with the mode's tip motion held.
    """

    mass: float
    stiffness: float
    turns_ratio: float
    blocked_capacitance: float

    @property
    def short_circuit_frequency(self) -> float:
        """Natural frequency at U = 0 (Hz)."""
        return float(np.sqrt(self.stiffness / self.mass) / (2.0 * np.pi))


def smits_choi(beam: Section, length: float) -> Complex:
    """Return the static cantilever matrix (3, 3): [ψ, w, Q] at the tip from [M, F, U].

    Smits and Choi (1991) for a bimorph, with the shim inside EI and K and the shear term
    added; the rotation is ψ ≈ −w', hence the signs off their table.
    """
    a = length / beam.EI
    return np.array(
        [
            [a, -0.5 * a * length, a * beam.K],
            [-0.5 * a * length, a * length**2 / 3.0 + length / beam.GA, -0.5 * a * length * beam.K],
            [a * beam.K, -0.5 * a * length * beam.K, length * beam.C + a * beam.K**2],
        ],
        dtype=complex,
    )


def lumped_model(pieces: Sequence[tuple[Section, float]]) -> LumpedModel:
    """Return the port matrices of a row of beams; joints follow statically (Guyan)."""
    n = 2 * len(pieces) + 3
    stiffness, mass = np.zeros((n, n), dtype=complex), np.zeros((n, n))
    for i, (beam, length) in enumerate(pieces):
        ports = np.ix_([*range(2 * i, 2 * i + 4), n - 1], [*range(2 * i, 2 * i + 4), n - 1])
        stiffness[ports] += _static_stiffness(beam, length)
        mass[ports] += _consistent_mass(beam, length)
    keep = [0, 1, n - 3, n - 2, n - 1]
    drop = [i for i in range(n) if i not in keep]
    shapes = np.zeros((n, 5), dtype=complex)
    shapes[keep] = np.eye(5)
    if drop:
        shapes[drop] = -np.linalg.solve(
            stiffness[np.ix_(drop, drop)], stiffness[np.ix_(drop, keep)]
        )
    real = shapes.real
    kept_mass = real.T @ mass @ real
    kept_mass[4] *= -1.0  # the last row is charge, minus what is conjugate to U
    return LumpedModel(condense(stiffness[None], keep)[0], kept_mass)


def multiport(
    device: Device, support: Support, beam: Beam, frequencies: Floats, *, lossy: bool = True
) -> Multiport:
    """Return the lumped model of the device over its five ports (parallel wiring)."""
    frequencies = np.atleast_1d(np.asarray(frequencies, dtype=float))
    model = lumped_model(sections(device, support, beam, lossy=lossy))
    o2 = (2.0 * np.pi * frequencies)[:, None, None] ** 2
    return Multiport(frequencies, model.stiffness - o2 * model.mass)


def equivalent_circuit(
    pieces: Sequence[tuple[Section, float]], fixture: Fixture, *, open_circuit: bool = False
) -> EquivalentCircuit:
    """Return the first mode of lossless pieces on their fixture.

    With `open_circuit` the mode is that at Q = 0, so its stiffness includes the piezo
    stiffening; the transformer is that of the same shape.
    """
    model = lumped_model(pieces)
    k, m = model.stiffness.real[:4, :4].copy(), model.mass[:4, :4].copy()
    coupling, capacitance = -model.stiffness.real[:4, 4], model.stiffness.real[4, 4]
    k[0, 0] += fixture.lateral_stiffness
    k[1, 1] += fixture.rotational_stiffness
    k[2, 2] += fixture.tip_stiffness
    m[1, 1] += fixture.rotational_inertia
    m[2, 2] += fixture.tip_mass
    if open_circuit:
        k += np.outer(coupling, coupling) / capacitance
    free = slice(2, 4) if fixture.clamped else slice(0, 4)
    shape = np.zeros(4)
    shape[free] = _lowest_mode(k[free, free], m[free, free])
    shape /= shape[2]
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


def _lowest_mode(stiffness: Floats, mass: Floats) -> Floats:
    """Return the shape of the lowest mode that is not rigid-body motion."""
    lower = np.linalg.cholesky(mass)
    inverse = np.linalg.inv(lower)
    values, vectors = np.linalg.eigh(inverse @ stiffness @ inverse.T)
    elastic = int(np.flatnonzero(values > 1e-9 * values[-1])[0])
    return np.asarray(inverse.T @ vectors[:, elastic])


def _static_stiffness(beam: Section, length: float) -> Complex:
    """Return the static Timoshenko element (5, 5) over [w, ψ, w, ψ, U]."""
    l, phi = length, 12.0 * beam.EI / (beam.GA * length**2)
    k = np.array(
        [
            [12.0, -6.0 * l, -12.0, -6.0 * l, 0.0],
            [-6.0 * l, (4.0 + phi) * l**2, 6.0 * l, (2.0 - phi) * l**2, 0.0],
            [-12.0, 6.0 * l, 12.0, 6.0 * l, 0.0],
            [-6.0 * l, (2.0 - phi) * l**2, 6.0 * l, (4.0 + phi) * l**2, 0.0],
            [0.0] * 5,
        ],
        dtype=complex,
    ) * (beam.EI / (l**3 * (1.0 + phi)))
    k[[1, 3], 4], k[4, [1, 3]] = (beam.K, -beam.K), (-beam.K, beam.K)
    k[4, 4] = beam.C * l
    return k


def _consistent_mass(beam: Section, length: float) -> Floats:
    """Return the consistent mass (5, 5) of the cubic shapes, with rotary inertia (no shear)."""
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
    out = np.zeros((5, 5))
    out[:4, :4] = translation + rotation
    return out
