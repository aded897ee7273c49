"""Statics and natural modes of members of a family, each with the bound of what the basis misses.

r being the residual of a state and K the stiffness, potentials eliminated, the error of what a
load f does at a load g is r_gᵀ K⁻¹ r_f, and that of an eigenvalue λ of a mode of unit mass at most
rᵀ K⁻¹ r / (1 − λ/λ'), λ' the next one (Temple's bound in the norm of K⁻¹).  K⁻¹ is replaced by
the compliance of the family's undivided member, times a margin that was observed.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tactgen.fem.bimorph.reduction.parametric.body import rigid_motions
from tactgen.fem.bimorph.reduction.parametric.reduced import Members
from tactgen.fem.piezo.modes import SHIFT
from tactgen.geometry.arrays import Complex, Floats
from tactgen.geometry.bimorph.ends import Ends

#: Neighbours closer than this (relative) count as this far apart.
_CLOSEST = 0.02
#: Vectors beyond twice the wanted ones, and steps, of subspace iteration: modes whose frequencies
#: go as 1, 2, 3 … are then right to 1e-13.
_SPARE, _ITERATIONS = 6, 6
#: Most modes that are bounded together.
_TOGETHER = 3


@dataclass(frozen=True)
class FamilyModes:
    """Modes of n members in one class of motion, ascending.

    `frequencies` (n, modes) in Hz, `bars` (n, modes) their errors by the basis, `shapes`
    (n, k or k + 2, modes) of unit mass, over the basis and the base's motions.
    """

    frequencies: Floats
    bars: Floats
    shapes: Floats

    def shares(self, members: Members) -> Floats:
        """Return the share (n, modes) of the energy that the class of motion has in each mode."""
        reduced, k = members.reduced, members.stiffness.shape[1]
        states = np.zeros((self.shapes.shape[0], reduced.rigid + k, self.shapes.shape[2]))
        states[:, reduced.rigid :] = self.shapes[:, :k]
        if self.shapes.shape[1] > k:
            states[:, : reduced.rigid] = rigid_motions(members.coefficients) @ self.shapes[:, k:]
        flat = reduced.means.reshape(-1, states.shape[1]) @ states
        means = flat.reshape(-1, *reduced.means.shape[:-1], states.shape[2])
        return reduced.sections.share(members.terms, members.coefficients, means)


@dataclass(frozen=True)
class FamilyStatics:
    """Mixed form of D(0) of n members, and the bounds of what the basis misses.

    Attributes
    ----------
    held, through, follows, compliance : arrays
        See :func:`fem.piezo.ports.ports_from_blocks`.
    missing : (n, 3) array
        Norms of the residuals of a volt, a tip force and a tip moment, the margin's root
        included: the error of entry (i, j) is at most the product of two.
    """

    held: Complex
    through: Complex
    follows: Complex
    compliance: Complex
    missing: Floats


def family_modes(members: Members, ends: Ends, count: int, *, open_circuit: bool) -> FamilyModes:
    """Return the lowest modes without damping and rigid motions, as many as the basis serves."""
    attached = _attached(members, ends, open_circuit=open_circuit)
    omega2, shapes = _lowest(members, ends, count, attached)
    missing = _residual(members, ends, omega2, shapes, attached[2], open_circuit=open_circuit)
    share = 0.5 * members.reduced.margin * _temple(missing / omega2, omega2)
    frequencies = np.sqrt(np.maximum(omega2[:, :-1], 0.0)) / (2.0 * np.pi)
    return FamilyModes(frequencies, share * frequencies, shapes[:, :, :-1])


def mode_states(members: Members, ends: Ends, count: int, *, open_circuit: bool) -> Floats:
    """Return the displacements (n, k, modes + 1) of the same modes, and of the next one."""
    attached = _attached(members, ends, open_circuit=open_circuit)
    return _lowest(members, ends, count, attached)[1][:, : members.stiffness.shape[1]]


def static_states(members: Members) -> Floats:
    """Return the displacements (n, k, 3) of members with ports at a volt and the tip's loads."""
    ports = members.ports
    assert ports is not None
    k = members.stiffness.shape[1]
    loads = np.concatenate([-ports.charge[:, :, None], ports.tip[:, :k]], axis=2)
    return np.asarray(np.linalg.solve(members.stiffness, loads))


def _lowest(
    members: Members, ends: Ends, count: int, attached: tuple[Floats, Floats, Floats | None]
) -> tuple[Floats, Floats]:
    """Return Ω² (n, modes + 1) and shapes of unit mass; the next tells how far the last is off."""
    stiffness, mass, _ = attached
    loose = ends.rigid_motions if members.ports is not None else 0
    shift = SHIFT if loose else 0.0
    count = min(count, members.reduced.modes)
    values, vectors = softest(stiffness + shift * mass, mass, loose + count + 1)
    chosen = slice(loose, loose + count + 1)
    found, shapes = values[:, chosen], vectors[:, :, chosen]
    return 1.0 / found - shift, shapes / np.sqrt(found)[:, None, :]


def softest(stiffness: Floats, mass: Floats, count: int) -> tuple[Floats, Floats]:
    """Return the largest μ of M y = μ K y (n, ≥ count), descending, and y (n, k, ≥ count).

    K being definite (n, k, k), yᵀ K y = 1.  Of a body the values fall fast, so that
    subspace iteration beats the full problem several times; what it might leave out shows in
    the modes' residuals.
    """
    size, block = stiffness.shape[1], 2 * count + _SPARE
    if size <= 2 * block:
        return _all_pairs(stiffness, mass)
    softness = np.linalg.solve(stiffness, mass)
    basis = softness @ np.random.default_rng(4).standard_normal((size, block))
    for _ in range(_ITERATIONS):
        basis = softness @ np.linalg.qr(basis)[0]
    basis = np.linalg.qr(basis)[0]
    across = np.swapaxes(basis, 1, 2)
    values, vectors = _all_pairs(across @ (stiffness @ basis), across @ (mass @ basis))
    return values, basis @ vectors


def _all_pairs(stiffness: Floats, mass: Floats) -> tuple[Floats, Floats]:
    lower = np.linalg.inv(np.linalg.cholesky(stiffness))
    softness = lower @ mass @ np.swapaxes(lower, 1, 2)
    values, vectors = np.linalg.eigh(0.5 * (softness + np.swapaxes(softness, 1, 2)))
    return values[:, ::-1], np.swapaxes(lower, 1, 2) @ vectors[:, :, ::-1]


def _temple(missing: Floats, omega2: Floats) -> Floats:
    """Return bounds (n, modes − 1) of the eigenvalues' relative errors from residuals (n, modes).

    Modes that are close are bounded together, by all their residuals and the distance of the
    last of them to the next one; of one, two or three modes what bounds best.
    """
    gap = np.maximum(1.0 - omega2[:, :-1] / omega2[:, 1:], _CLOSEST)
    best = np.full(gap.shape, np.inf)
    together = np.zeros(gap.shape)
    for more in range(min(_TOGETHER, gap.shape[1])):
        last = gap.shape[1] - more
        together[:, :last] += missing[:, more : more + last]
        best[:, :last] = np.minimum(best[:, :last], together[:, :last] / gap[:, more:])
    return best


def _attached(
    members: Members, ends: Ends, *, open_circuit: bool
) -> tuple[Floats, Floats, Floats | None]:
    """Return stiffness, mass and the tip's displacement with everything attached."""
    ports = members.ports
    if ports is None:
        return members.stiffness, members.mass, None
    k = members.stiffness.shape[1]
    base, load = ends.base, ends.conservative_tip
    stiffness = np.zeros_like(members.mass)
    stiffness[:, :k, :k] = members.stiffness
    if open_circuit:
        charge = ports.charge
        stiffness[:, :k, :k] += (
            charge[:, :, None] * charge[:, None, :] / ports.capacitance[:, None, None]
        )
    mass, tip = members.mass.copy(), ports.tip[:, :, 0]
    if base is None:
        stiffness, mass, tip = stiffness[:, :k, :k], mass[:, :k, :k], tip[:, :k]
    else:
        stiffness[:, k, k] += base.lateral_stiffness
        stiffness[:, k + 1, k + 1] += base.rotational_stiffness
        mass[:, k + 1, k + 1] += base.rotational_inertia
    moved = tip[:, :, None] * tip[:, None, :]
    return stiffness + load.stiffness * moved, mass + load.mass * moved, tip


def _residual(
    members: Members,
    ends: Ends,
    omega2: Floats,
    shapes: Floats,
    tip: Floats | None,
    *,
    open_circuit: bool,
) -> Floats:
    """Return the squared norms (n, modes) of the modes' residuals."""
    k = members.stiffness.shape[1]
    left = members.residual @ shapes[:, :k]
    left -= omega2[:, None] * (members.residual_of_mass[:, :, : shapes.shape[1]] @ shapes)
    ports, load = members.ports, ends.conservative_tip
    if ports is not None and tip is not None:
        force = (load.stiffness - load.mass * omega2) * np.einsum("nk,nkm->nm", tip, shapes)
        left += ports.residual_of_tip[:, :, :1] * force[:, None]
        if open_circuit:
            volts = np.einsum("nk,nkm->nm", ports.charge, shapes[:, :k])
            volts = volts / ports.capacitance[:, None]
            left += ports.residual_of_volt[:, :, None] * volts[:, None]
    return np.asarray((left**2).mean(axis=1))


def family_statics(members: Members) -> FamilyStatics:
    """Return D(0) of members that have ports."""
    ports = members.ports
    assert ports is not None
    n, k = members.stiffness.shape[:2]
    states = static_states(members)
    rigid = ports.tip[:, k:]
    held = np.zeros((n, 3, 3), dtype=complex)
    held[:, 2, 2] = -ports.capacitance + np.einsum("nk,nk->n", ports.charge, states[:, :, 0])
    moved = np.swapaxes(ports.tip[:, :k], 1, 2) @ states
    follows = np.concatenate([np.swapaxes(rigid, 1, 2), moved[:, :, :1]], axis=2)
    left = members.residual @ states
    left[:, :, 0] += ports.residual_of_volt
    left[:, :, 1:] -= ports.residual_of_tip
    missing = np.sqrt(members.reduced.margin * (left**2).mean(axis=1))
    return FamilyStatics(
        held=held,
        through=-np.swapaxes(follows, 1, 2).astype(complex),
        follows=follows.astype(complex),
        compliance=moved[:, :, 1:].astype(complex),
        missing=np.asarray(missing),
    )
