"""Answers of members of a family over frequency, each with the bound of what the basis misses.

The small system is that of :mod:`.answers` with losses and inertia, Z = K − Ω² M.  With r_f and
r_g the residuals of the states that two loads cause, the error of what f does at g is
r_gᵀ Z⁻¹ r_f, and |Z⁻¹| is K⁻¹ times 1 / min_j |κ_j − Ω² / λ_j| over the modes, κ_j the complex
stiffness of mode j over its real part: 1 at rest, Q at a resonance of the held base.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from tactgen.fem.bimorph.reduction.parametric.answers import softest
from tactgen.fem.bimorph.reduction.parametric.reduced import Members
from tactgen.geometry.arrays import Complex, Floats

#: Modes of the held base that decide how far the error at a frequency is magnified.
_MODES = 8


@dataclass(frozen=True)
class FamilyHarmonic:
    """Mixed form of D(Ω) of n members at f frequencies, and the bounds of what the basis misses.

    Attributes
    ----------
    held, through, follows, compliance : (n, f, 3, 3), (n, f, 3, 2), (n, f, 2, 3), (n, f, 2, 2)
        See :func:`fem.piezo.ports.ports_from_blocks`.
    missing : (n, f, 5) array
        Norms of the residuals of (w_base, ψ_base, U, tip force, tip moment), the roots of
        margin and magnification included: the error of what two of them do to one another is
        at most the product of their norms.
    magnified : (n, f) array
        The magnification; infinite beyond the modes that the basis is made of.
    """

    held: Complex
    through: Complex
    follows: Complex
    compliance: Complex
    missing: Floats
    magnified: Floats


def family_harmonic(members: Members, frequencies: Floats) -> FamilyHarmonic:
    """Return D(Ω) of members that have ports, at frequencies (f,) in Hz."""
    ports = members.ports
    assert ports is not None
    n, k = members.stiffness.shape[:2]
    mass, tip = members.mass[:, :k, :k], ports.tip[:, :k]
    on_base, rigid = members.mass[:, :k, k:], ports.tip[:, k:]
    volt = -ports.charge[:, :, None]
    shape = (n, frequencies.size)
    held = np.zeros((*shape, 3, 3), dtype=complex)
    follows = np.zeros((*shape, 2, 3), dtype=complex)
    compliance = np.zeros((*shape, 2, 2), dtype=complex)
    missing = np.zeros((*shape, 5))
    magnified = _magnified(members, frequencies)
    for at, frequency in enumerate(frequencies):
        omega2 = (2.0 * np.pi * frequency) ** 2
        loads = np.concatenate([omega2 * on_base, volt, tip], axis=2)
        states = np.linalg.solve(members.stiffness - omega2 * mass, loads)
        moved = np.swapaxes(tip, 1, 2) @ states
        follows[:, at] = moved[:, :, :3]
        follows[:, at, :, :2] += np.swapaxes(rigid, 1, 2)
        compliance[:, at] = moved[:, :, 3:]
        carried = np.swapaxes(on_base, 1, 2) @ states[:, :, :3]
        held[:, at, :2] = -omega2 * carried
        held[:, at, :2, :2] -= omega2 * members.mass[:, k:, k:]
        held[:, at, 2] = np.einsum("nk,nkj->nj", ports.charge, states[:, :, :3])
        held[:, at, 2, 2] -= ports.capacitance
        left: Any = members.residual @ states
        left -= omega2 * (members.residual_of_mass[:, :, :k] @ states)
        left[:, :, :2] -= omega2 * members.residual_of_mass[:, :, k:]
        left[:, :, 2] += ports.residual_of_volt
        left[:, :, 3:] -= ports.residual_of_tip
        missing[:, at] = np.sqrt(members.reduced.margin * (np.abs(left) ** 2).mean(axis=1))
    return FamilyHarmonic(
        held=held,
        through=-np.swapaxes(follows, 2, 3),
        follows=follows,
        compliance=compliance,
        missing=missing * np.sqrt(magnified)[:, :, None],
        magnified=magnified,
    )


def _magnified(members: Members, frequencies: Floats) -> Floats:
    """Return 1 / min_j |κ_j − Ω² / λ_j| (n, f) over the lowest modes of the held base."""
    k = members.stiffness.shape[1]
    real, mass = members.stiffness.real, members.mass[:, :k, :k]
    values, vectors = softest(real, mass, min(_MODES, k))
    vectors = vectors[:, :, :_MODES]
    share = np.einsum("nki,nkl,nli->ni", vectors, members.stiffness, vectors)
    ratios = (2.0 * np.pi * frequencies[None, :, None]) ** 2 * values[:, None, : share.shape[1]]
    nearest = np.abs(share[:, None] - ratios).min(axis=2)
    nearest = np.minimum(nearest, np.abs(share).max(axis=1)[:, None])
    served = ratios[:, :, min(members.reduced.modes, ratios.shape[2] - 1)] < 1.0
    return np.asarray(np.where(served, 1.0 / nearest, np.inf))
