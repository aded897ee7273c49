"""What is asked of an assembled solid: its static ports, its modes, its reduction to ports.

Every solve here is a symmetric factorisation; how the matrices came about is
:mod:`fem.piezo_solid`'s business.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal

import numpy as np
from scipy import sparse

from fem.linear_solver import Factor, factorise, refined_solution
from fem.piezo_solid import BASE_PSI, BASE_W, ELECTRODE, SolidSystem
from geometry.arrays import Complex, Floats, Ints, Sparse
from tmm.multiport import Multiport

ModeClass = Literal["bending_x", "bending_y", "torsion", "axial", "mixed"]

#: Blocks per shift of the Krylov basis that reduces a solid to its ports.
_BLOCKS = 4
#: Most shifts, each a complex factorisation.
_MOST_SHIFTS = 6


@dataclass(frozen=True)
class Attachment:
    """Lossless constants at the ports: `base` None is a clamp.

    Attributes
    ----------
    base : tuple of float or None
        Lateral stiffness (N/m), rotational stiffness (N m/rad), rotational inertia (kg m²).
    tip_stiffness, tip_mass : float
        Load on the mean tip displacement (N/m, kg).
    """

    base: tuple[float, float, float] | None
    tip_stiffness: float = 0.0
    tip_mass: float = 0.0


@dataclass(frozen=True)
class SolidMode:
    """A natural mode.

    Attributes
    ----------
    frequency : float
        Natural frequency (Hz).
    kind : str
        Class, by the motion that holds most of the kinetic energy.
    share : float
        Share of the class in the kinetic energy.
    displacement : (n_nodes, 3) array
        Nodal displacements, largest component 1.
    """

    frequency: float
    kind: ModeClass
    share: float
    displacement: Floats


@dataclass(frozen=True)
class ReducedSolid:
    """A solid projected on a Krylov basis, ports kept: a few dozen unknowns.

    D(Ω) follows from `stiffness` − Ω² `mass` (k + 3 unknowns: basis, w_base, ψ_base, U)
    and `tip` (k + 3, 2).  `check` is the same with one Krylov block less; the distance
    between the two is the error estimate of the reduction.
    """

    stiffness: Complex
    mass: Complex
    tip: Complex
    fewer: int

    def multiport(self, frequencies: Floats) -> Multiport:
        """Return D(Ω) (n, 5, 5)."""
        f = np.atleast_1d(np.asarray(frequencies, dtype=float))
        return Multiport(f, self._ports(f, self.stiffness.shape[0] - 3))

    def coarser_multiport(self, frequencies: Floats) -> Multiport:
        """Return D(Ω) of the basis without its last block, for the error estimate."""
        f = np.atleast_1d(np.asarray(frequencies, dtype=float))
        return Multiport(f, self._ports(f, self.fewer))

    def error_estimate(self, frequencies: Floats) -> Floats:
        """Return the estimated relative error of D(Ω) (n,), largest entry.

        Entries are judged against the geometric mean of their diagonal neighbours.
        """
        d = self.multiport(frequencies).stiffness
        difference = np.abs(d - self.coarser_multiport(frequencies).stiffness)
        size = np.sqrt(np.abs(np.einsum("nii->ni", d)))
        return np.asarray((difference / (size[:, :, None] * size[:, None, :])).max(axis=(1, 2)))

    def _ports(self, frequencies: Floats, vectors: int) -> Complex:
        keep = np.r_[0:vectors, self.stiffness.shape[0] - 3 : self.stiffness.shape[0]]
        k, m = self.stiffness[np.ix_(keep, keep)], self.mass[np.ix_(keep, keep)]
        o2 = (2.0 * np.pi * frequencies)[:, None, None] ** 2
        return mixed_to_stiffness(k - o2 * m, self.tip[keep])


def mixed_to_stiffness(dynamic: Complex, tip: Complex) -> Complex:
    """Return D (n, 5, 5) from systems over [interior, w_base, ψ_base, U].

    The tip is not an unknown but a mean over a face, so the interior is first solved for
    unit base motion, unit voltage and unit tip forces; the tip's 2 x 2 compliance is then
    inverted to make its displacements the inputs.
    """
    n, size, _ = dynamic.shape
    inner = size - 3
    loads = np.zeros((n, inner, 5), dtype=complex)
    loads[:, :, :3] = -dynamic[:, :inner, inner:]
    loads[:, :, 3:] = tip[:inner]
    x = np.linalg.solve(dynamic[:, :inner, :inner], loads)
    held = dynamic[:, inner:, inner:] + dynamic[:, inner:, :inner] @ x[:, :, :3]
    through = dynamic[:, inner:, :inner] @ x[:, :, 3:]
    seen = tip[:inner].T @ x
    return ports_from_blocks(held, through, seen[:, :, :3], seen[:, :, 3:])


def ports_from_blocks(
    held: Complex, through: Complex, follows: Complex, compliance: Complex
) -> Complex:
    """Assemble D from its mixed form.

    Parameters
    ----------
    held : (n, 3, 3) array
        Base force, base moment and −charge per unit (w_base, ψ_base, U), tip free.
    through : (n, 3, 2) array
        The same per unit tip force and moment.
    follows : (n, 2, 3) array
        Tip motion per unit (w_base, ψ_base, U), tip free.
    compliance : (n, 2, 2) array
        Tip motion per unit tip force and moment.
    """
    stiff = np.linalg.inv(compliance)
    s = np.zeros((held.shape[0], 5, 5), dtype=complex)
    source, tip = np.array([0, 1, 4]), np.array([2, 3])
    everything = np.arange(held.shape[0])
    s[np.ix_(everything, tip, tip)] = stiff
    s[np.ix_(everything, tip, source)] = -stiff @ follows
    s[np.ix_(everything, source, tip)] = through @ stiff
    s[np.ix_(everything, source, source)] = held - through @ stiff @ follows
    s[:, 4] *= -1.0  # the symmetric system's last row is minus the charge
    return s


def static_multiport(system: SolidSystem) -> Multiport:
    """Return D(0) of a lossless system by one real factorisation."""
    n = system.size - 3
    k = system.stiffness.tocsr()
    factor = factorise(k[:n, :n])
    coupling = k[:n, n:].toarray()
    loads = np.hstack([-coupling, system.tip[:n]])
    x = refined_solution(k[:n, :n], factor, loads)
    held = k[n:, n:].toarray() + coupling.T @ x[:, :3]
    through = coupling.T @ x[:, 3:]
    seen = system.tip[:n].T @ x
    blocks = (held, through, seen[:, :3], seen[:, 3:])
    return Multiport(np.zeros(1), ports_from_blocks(*(b[None].astype(complex) for b in blocks)))


def reduce_to_ports(
    system: SolidSystem, frequencies: Floats, *, tolerance: float = 1e-6
) -> ReducedSolid:
    """Project a solid on a rational Krylov basis that serves a range of frequencies.

    Parameters
    ----------
    system : SolidSystem
        Lossy or lossless.
    frequencies : (n,) array
        Where D(Ω) is wanted (Hz).
    tolerance : float
        Estimated relative error of D(Ω), entries against the geometric mean of their
        diagonal neighbours, at every one of these frequencies.  Shifts are added at the
        worst frequency until it holds or :data:`_MOST_SHIFTS` are used; the estimate
        stays available through :meth:`ReducedSolid.coarser_multiport`.

    Notes
    -----
    One complex factorisation per shift.  The shifts Ω² (1 + j) keep clear of all poles.
    """
    frequencies = np.atleast_1d(np.asarray(frequencies, dtype=float))
    centre = max(0.7 * float(frequencies.max()), 500.0)
    chains = [_krylov_chain(system, centre)]
    while True:
        reduced = _project(system, chains)
        estimate = reduced.error_estimate(frequencies)
        worst = int(np.argmax(estimate))
        if estimate[worst] <= tolerance or len(chains) == _MOST_SHIFTS:
            return reduced
        chains.append(_krylov_chain(system, max(float(frequencies[worst]), 20.0)))


def _krylov_chain(system: SolidSystem, centre: float) -> list[Complex]:
    """Return the blocks (n, 5) of one shift: responses to the ports, then their moments."""
    n = system.size - 3
    shift = (2.0 * np.pi * centre) ** 2 * (1.0 + 1.0j)
    dynamic = (system.stiffness - shift * system.mass).tocsr()
    factor: Factor = factorise(dynamic[:n, :n])
    mass = system.mass.tocsr()
    loads = np.hstack([-dynamic[:n, n:].toarray(), system.tip[:n].astype(complex)])
    chain = [factor.solve(loads)]
    identity = np.zeros((3, 5))
    identity[:, :3] = np.eye(3)
    right = mass[:n, :n] @ chain[0] + mass[:n, n:] @ identity
    for _ in range(1, _BLOCKS):
        chain.append(factor.solve(right))
        right = mass[:n, :n] @ (chain[-1] / np.linalg.norm(chain[-1], axis=0))
    return chain


def _project(system: SolidSystem, chains: list[list[Complex]]) -> ReducedSolid:
    """Project on the real and imaginary parts of all blocks, the last of each chain last."""
    n = system.size - 3
    basis: Floats = np.zeros((n, 0))
    for block in (block for chain in chains for block in chain[:-1]):
        basis = _orthonormal(basis, block)
    fewer = basis.shape[1]
    for chain in chains:
        basis = _orthonormal(basis, chain[-1])
    full = np.zeros((n + 3, basis.shape[1] + 3))
    full[:n, : basis.shape[1]], full[n:, basis.shape[1] :] = basis, np.eye(3)
    return ReducedSolid(
        stiffness=np.asarray(full.T @ (system.stiffness @ full), dtype=complex),
        mass=np.asarray(full.T @ (system.mass @ full), dtype=complex),
        tip=np.asarray(full.T @ system.tip, dtype=complex),
        fewer=fewer,
    )


def _orthonormal(basis: Floats, block: Complex) -> Floats:
    """Extend a real orthonormal basis by the real and imaginary parts of a block."""
    new = np.hstack([block.real, block.imag])
    new = new / np.maximum(np.linalg.norm(new, axis=0), 1e-300)
    for _ in range(2):  # twice is enough (Kahan, Parlett)
        new = new - basis @ (basis.T @ new)
    q, r, _ = _pivoted_qr(new)
    kept = np.abs(np.diag(r)) > 1e-10 * max(np.abs(r[0, 0]), 1e-300)
    return np.hstack([basis, q[:, kept]])


def _pivoted_qr(matrix: Floats) -> tuple[Floats, Floats, Ints]:
    from scipy.linalg import qr

    return qr(matrix, mode="economic", pivoting=True)  # type: ignore[no-any-return]


def natural_modes(
    system: SolidSystem, attachment: Attachment, count: int, *, open_circuit: bool = False
) -> list[SolidMode]:
    """Return the lowest `count` elastic modes of a lossless system, ascending.

    Shift-and-invert Lanczos just below 0 Hz; the potential is part of the indefinite
    operator and has no mass.  At open circuit the electrode's charge is held at zero by
    a rank-one update of the short-circuit factor.
    """
    from scipy.sparse.linalg import LinearOperator, eigsh

    stiffness, mass, tip = _with_attachment(system, attachment)
    n = stiffness.shape[0]
    shift = -((2.0 * np.pi * 50.0) ** 2)
    factor = factorise(stiffness - shift * mass)
    updates = []
    if attachment.tip_stiffness - shift * attachment.tip_mass > 0.0:
        updates.append((tip, attachment.tip_stiffness - shift * attachment.tip_mass))
    if open_circuit:
        charge, capacitance = _electrode(system, n)
        updates.append((charge, 1.0 / capacitance))
    solve = _updated(factor, updates)
    mass_operator = mass
    if attachment.tip_mass > 0.0:
        mass_operator = LinearOperator(
            (n, n), matvec=lambda v: mass @ v + attachment.tip_mass * tip * (tip @ v), dtype=float
        )
    rng = np.random.default_rng(0)
    wanted = min(count + 4, n - 2)
    values, vectors = eigsh(
        stiffness,
        k=wanted,
        M=mass_operator,
        sigma=shift,
        which="LM",
        OPinv=LinearOperator((n, n), matvec=solve, dtype=float),
        v0=solve(mass @ rng.standard_normal(n)),
        tol=1e-12,
    )
    order = np.argsort(values)
    found = []
    for i in order:
        if values[i] <= (2.0 * np.pi * 1.0) ** 2:  # rigid-body motion
            continue
        found.append(_mode(system, float(values[i]), vectors[:, i], n))
    return found[:count]


def _with_attachment(system: SolidSystem, attachment: Attachment) -> tuple[Sparse, Sparse, Floats]:
    """Return stiffness, mass and tip functional at U = 0 with the support attached."""
    size = system.size
    n = size - 3 if attachment.base is None else size - 1
    k, m = system.stiffness.tocsr()[:n, :n], system.mass.tocsr()[:n, :n]
    if attachment.base is not None:
        lateral, rotational, inertia = attachment.base
        springs, added = np.zeros(n), np.zeros(n)
        springs[size + BASE_W], springs[size + BASE_PSI] = lateral, rotational
        added[size + BASE_PSI] = inertia
        k, m = (k + sparse.diags(springs)).tocsr(), (m + sparse.diags(added)).tocsr()
    return k, m, system.tip[:n, 0]


def _electrode(system: SolidSystem, n: int) -> tuple[Floats, float]:
    """Return charge per unknown (n,) and the capacitance at U alone."""
    column = system.stiffness.tocsc()[:, [system.size + ELECTRODE]].toarray().ravel()
    return -column[:n], float(-column[-1])


def _updated(factor: Factor, updates: list[tuple[Floats, float]]) -> Callable[[Floats], Floats]:
    """Return v ↦ (A + Σ weight c cᵀ)⁻¹ v by the Woodbury identity."""
    if not updates:
        return factor.solve
    c = np.column_stack([u for u, _ in updates])
    z = factor.solve(c)
    small = np.linalg.inv(np.diag([1.0 / w for _, w in updates]) + c.T @ z)

    def solve(v: Floats) -> Floats:
        x = factor.solve(np.asarray(v).ravel())
        return np.asarray(x - z @ (small @ (c.T @ x)))

    return solve


def _mode(system: SolidSystem, value: float, vector: Floats, n: int) -> SolidMode:
    y = np.zeros(system.size)
    y[:n] = vector
    nodal = (system.expand @ y).reshape(4, -1)[:3].T
    nodal = nodal / np.abs(nodal).max()
    kind, share = classify(system.nodes, system.node_mass, nodal)
    return SolidMode(float(np.sqrt(value) / (2.0 * np.pi)), kind, share, nodal)


def classify(nodes: Floats, mass: Floats, displacement: Floats) -> tuple[ModeClass, float]:
    """Name a mode by the rigid section motion that holds most of its kinetic energy.

    Nodes are gathered in slices along z; in each the displacement is fitted by section
    translations, rotations and twist.  Returns the class and its share of the energy
    (``mixed`` below one half).
    """
    z = nodes[:, 2]
    slices = np.minimum((40 * (z - z.min()) / np.ptp(z)).astype(int), 39)
    energy = dict.fromkeys(("bending_x", "bending_y", "torsion", "axial"), 0.0)
    for number in np.unique(slices):
        at = slices == number
        m, u = mass[at], displacement[at]
        x, y = (nodes[at, i] - np.average(nodes[at, i], weights=m) for i in (0, 1))
        for axis, name, lever in ((0, "bending_x", x), (1, "bending_y", y)):
            mean = np.average(u[:, axis], weights=m)
            tilt = (m * lever * u[:, 2]).sum() ** 2 / (m * lever**2).sum()
            energy[name] += m.sum() * mean**2 + tilt
        energy["axial"] += m.sum() * np.average(u[:, 2], weights=m) ** 2
        twist = (m * (x * u[:, 1] - y * u[:, 0])).sum() ** 2
        energy["torsion"] += twist / (m * (x**2 + y**2)).sum()
    total = float((mass[:, None] * displacement**2).sum())
    best = max(energy, key=lambda name: energy[name])
    share = energy[best] / total
    kind: ModeClass = best if share >= 0.5 else "mixed"  # type: ignore[assignment]
    return kind, share
