"""Reduction of a solid to its ports by a rational Krylov basis, with its error estimated.

The basis spans the solutions for unit loads at the ports and their first moments at one or
more complex shifts, losses included; displacement and potential get a basis each, real, so
that the small system is symmetric and passive like the large one.  For symmetric systems the
error at the ports is the square of that of the field (r being the residual, it is rᵀ A⁻¹ r).
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fem.linear_solver import factorise
from fem.port_extremes import extremes, motions, standard_ends
from fem.port_model import PortModel, undamped_modes
from fem.solid_system import SolidSystem
from geometry.arrays import Complex, Floats, Ints, Sparse
from tmm.multiport import Multiport

Wide = NDArray[Any]

#: Blocks per shift of the Krylov basis.
_BLOCKS = 5
#: Most shifts, each a complex factorisation.
_MOST_SHIFTS = 6
#: A unit vector of which less than this is new is rounding of the factorisation; what is lost
#: counts by its square at the ports.
_NOISE = 1e-8

#: Deformations softer than this part of the stiffest one are projected in long double.
_SOFT = 1e-3


@dataclass(frozen=True)
class ReducedSolid:
    """A solid projected on a Krylov basis, ports kept: a few dozen unknowns.

    Attributes
    ----------
    fine : PortModel
        The reduced model.
    coarse : PortModel
        The same without the last block of every shift, to judge it by: the estimate is
        the distance between the two, in effect the error of the poorer one.
    range : tuple of float
        Lowest and highest frequency (Hz) it was made for.
    error : float
        Largest estimate over the frequencies it was checked at, peaks and dips included.
    unknowns : int
        Number of unknowns of the solid.
    """

    fine: PortModel
    coarse: PortModel
    range: tuple[float, float]
    error: float
    unknowns: int

    def multiport(self, frequencies: Floats) -> Multiport:
        """Return D(Ω) (n, 5, 5)."""
        return self.fine.multiport(frequencies)

    def coarser_multiport(self, frequencies: Floats) -> Multiport:
        """Return D(Ω) of the coarser basis, for the error estimate."""
        return self.coarse.multiport(frequencies)

    def error_estimate(self, frequencies: Floats) -> Floats:
        """Return the estimated relative error (n,), the larger of two.

        That of D(Ω), entries against the geometric mean of their diagonal neighbours; and,
        where there are losses, that of tip displacement, tip rotation and charge per volt
        of the clamped and the sprung actuator, each against itself, so that dips count.
        """
        fine, coarse = self.multiport(frequencies), self.coarser_multiport(frequencies)
        error = port_error(fine, coarse)
        if np.any(self.fine.stiffness.imag):
            for end in standard_ends(self.fine):
                exact, poorer = motions(fine, end), motions(coarse, end)
                size = np.where(
                    exact == 0.0, 1.0, np.abs(exact)
                )  # moved by nothing, off by nothing
                error = np.maximum(error, (np.abs(exact - poorer) / size).max(axis=0))
        return error


def port_error(port: Multiport, other: Multiport) -> Floats:
    """Return the distance of two D(Ω) (n,), against the geometric mean of the diagonal."""
    size = np.sqrt(np.abs(np.einsum("nii->ni", port.stiffness)))
    difference = np.abs(port.stiffness - other.stiffness)
    return np.asarray((difference / (size[:, :, None] * size[:, None, :])).max(axis=(1, 2)))


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
        Estimated relative error (:meth:`ReducedSolid.error_estimate`) at every one of these
        frequencies and, with losses, at every peak and dip between the lowest and highest.
        Shifts are added at the worst frequency until it holds or six are used; what was
        reached stays available as the estimate.

    Notes
    -----
    One complex factorisation per shift.  The shifts Ω² (1 + j) keep clear of all poles.
    """
    frequencies = np.atleast_1d(np.asarray(frequencies, dtype=float))
    bounds = float(frequencies.min()), float(frequencies.max())
    split = _split(system)
    chains = [_krylov_chain(split, max(0.7 * bounds[1], 500.0))]
    while True:
        fine, coarse = _project(split, chains)
        reduced = ReducedSolid(fine, coarse, bounds, np.inf, system.size)
        checked = frequencies
        if np.any(fine.stiffness.imag):
            ends = standard_ends(fine)
            checked = np.concatenate([frequencies, extremes(fine, *bounds, ends)])
        estimate = reduced.error_estimate(checked)
        worst = int(np.argmax(estimate))
        if estimate[worst] <= tolerance or len(chains) == _MOST_SHIFTS:
            return replace(reduced, error=float(estimate[worst]))
        chains.append(_krylov_chain(split, max(float(checked[worst]), 20.0)))


@dataclass(frozen=True)
class _Split:
    """A system over [displacements u, potentials p] and its ports [w_base, ψ_base, U].

    `port_mass` is that between displacements and ports, `own` and `own_mass` are the ports'.
    """

    stiffness: Sparse
    uu: Sparse
    up: Sparse
    pp: Sparse
    u_port: Floats
    p_port: Floats
    own: Complex
    mass: Sparse
    port_mass: Floats
    own_mass: Floats
    tip: Floats
    elimination: Ints | None


def _split(system: SolidSystem) -> _Split:
    n = system.size - 3
    stiffness, mass = system.stiffness.tocsr(), system.mass.tocsr()
    massive = mass.diagonal()[:n] > 0.0
    u, p = np.flatnonzero(massive), np.flatnonzero(~massive)
    order = np.concatenate([u, p])
    inner, ports = stiffness[:n, :n][order][:, order].tocsr(), stiffness[:n, n:].toarray()
    return _Split(
        stiffness=inner,
        uu=inner[: u.size, : u.size],
        up=inner[: u.size, u.size :],
        pp=inner[u.size :, u.size :],
        u_port=ports[u],
        p_port=ports[p],
        own=stiffness[n:, n:].toarray(),
        mass=mass[:n, :n][u][:, u].tocsr(),
        port_mass=mass[:n, n:].toarray()[u],
        own_mass=mass[n:, n:].toarray(),
        tip=system.tip[:n][u],
        elimination=None if system.elimination is None else np.argsort(order)[system.elimination],
    )


def _krylov_chain(system: _Split, centre: float) -> list[Complex]:
    """Return the blocks (n, 5) of one shift: responses to the ports, then their moments."""
    from scipy import sparse

    shift = (2.0 * np.pi * centre) ** 2 * (1.0 + 1.0j)
    n_u, n = system.uu.shape[0], system.stiffness.shape[0]
    mass = sparse.block_diag([system.mass, sparse.csr_matrix((n - n_u, n - n_u))], format="csr")
    factor = factorise((system.stiffness - shift * mass).tocsr(), order=system.elimination)
    loads = np.zeros((n, 5), dtype=complex)
    loads[:n_u, :3] = shift * system.port_mass - system.u_port
    loads[n_u:, :3] = -system.p_port
    loads[:n_u, 3:] = system.tip
    chain = [factor.solve(loads)]
    right = np.zeros((n, 5), dtype=complex)
    right[:n_u] = system.mass @ chain[0][:n_u]
    right[:n_u, :3] += system.port_mass
    for _ in range(1, _BLOCKS):
        # a voltage that moves nothing (a passive ceramic) has no moments
        block = factor.solve(right[:, right.any(axis=0)])
        # powers alone turn parallel and lose what is new; the first block has its own load
        chain.append(_orthogonal(block, chain[1:]))
        right = np.zeros_like(block)
        right[:n_u] = system.mass @ chain[-1][:n_u]
    return chain


def _orthogonal(block: Complex, earlier: list[Complex]) -> Complex:
    """Return an orthonormal basis of a block, each column scaled alike, less the earlier ones."""
    block = block / np.linalg.norm(block, axis=0)
    for _ in range(2):  # twice is enough (Kahan, Parlett)
        for other in earlier:
            block = block - other @ (other.conj().T @ block)
    return np.asarray(np.linalg.qr(block)[0])


def _project(system: _Split, chains: list[list[Complex]]) -> tuple[PortModel, PortModel]:
    """Project on the real and imaginary parts of all blocks; then without each chain's last."""
    n_u = system.uu.shape[0]
    blocks = [block for chain in chains for block in chain[:-1]]
    last = [chain[-1] for chain in chains]
    u, few_u = _orthonormal([b[:n_u] for b in blocks], [b[:n_u] for b in last])
    p, few_p = _orthonormal([b[n_u:] for b in blocks], [b[n_u:] for b in last])
    k, s = u.shape[1], u.shape[1] + 3
    inner = np.zeros((k + p.shape[1], k + p.shape[1]), dtype=complex)
    inner[:k, :k], inner[:k, k:] = u.T @ (system.uu @ u), u.T @ (system.up @ p)
    inner[k:, k:] = p.T @ (system.pp @ p)
    inner = np.triu(inner) + np.triu(inner, 1).T
    softness, turn = np.linalg.eigh(_condensed(inner, p.shape[1]).real.astype(float))
    u = u @ turn
    whole = np.zeros((s + p.shape[1], s + p.shape[1]), dtype=np.clongdouble)
    whole[:k, :k], whole[:k, s:] = turn.T @ inner[:k, :k] @ turn, turn.T @ inner[:k, k:]
    whole[s:, s:] = inner[k:, k:]
    soft = int((softness < _SOFT * softness[-1]).sum())
    whole[:soft, :k] = _wide(u[:, :soft], system.uu, u)
    whole[:soft, s:] = _wide(u[:, :soft], system.up, p)
    whole[:k, k:s] = u.T @ system.u_port.astype(np.clongdouble)
    whole[k:s, s:], whole[k:s, k:s] = system.p_port.T @ p, system.own
    whole = np.triu(whole) + np.triu(whole, 1).T
    mass = np.zeros((s, s))
    mass[:k, :k], mass[:k, k:] = u.T @ (system.mass @ u), u.T @ system.port_mass
    mass[k:, k:] = system.own_mass
    mass = np.triu(mass) + np.triu(mass, 1).T
    tip = np.zeros((s, 2))
    tip[:k] = u.T @ system.tip

    def kept(of_u: int, of_p: int) -> PortModel:
        # what the first vectors span, in terms of the turned ones
        basis = np.eye(s)[:, k - of_u :]
        basis[:k, :of_u] = turn[:of_u].T
        change = np.zeros((whole.shape[0], s - k + of_u + of_p))
        change[:s, : basis.shape[1]] = basis
        change[s : s + of_p, basis.shape[1] :] = np.eye(of_p)
        stiffness = _condensed(change.T @ whole @ change, of_p)
        return _graded(stiffness, basis.T @ mass @ basis, basis.T @ tip)

    return kept(k, p.shape[1]), kept(few_u, few_p)


def _wide(left: Floats, matrix: Sparse, right: Floats) -> Wide:
    """Return leftᵀ matrix right, the real part in long double.

    A bimorph bends ten million times more easily than its elements stretch, so the energy of
    bending is what is left of large terms; a peak magnifies what is lost by Q once more.
    """
    product = matrix.real.T.astype(np.longdouble) @ left.astype(np.longdouble)
    real = product.T @ right.astype(np.longdouble)
    if not np.iscomplexobj(matrix.data):
        return np.asarray(real)
    return np.asarray(real + 1j * ((matrix.imag.T @ left).T @ right))


def _condensed(matrix: Wide, last: int) -> Wide:
    """Eliminate the `last` unknowns (potentials, which have no mass)."""
    if not last:
        return matrix
    a, b, c = matrix[:-last, :-last], matrix[:-last, -last:], matrix[-last:, -last:]
    inverse = np.linalg.inv(c.astype(complex))
    x = inverse @ b.T
    x = x + inverse @ (b.T - c @ x)
    return np.asarray(a - b @ x)


def _graded(stiffness: Wide, mass: Floats, tip: Floats) -> PortModel:
    """Change to unknowns in which nothing cancels, and round to double.

    The inner ones become undamped modes; those of the base take the static deformation along
    (Craig, Bampton), else their stiffness would be what is left of one layer of elements.
    """
    k = stiffness.shape[0] - 3
    change = np.eye(k + 3)
    modes, _ = undamped_modes(stiffness[:k, :k].real.astype(float), mass[:k, :k])
    change[:k, :k] = modes
    base = slice(k, k + 2)
    change[:k, base] = -modes @ (modes.T @ stiffness[:k, base].real.astype(float))
    small = (change.T @ stiffness @ change).astype(complex)
    return PortModel(0.5 * (small + small.T), change.T @ mass @ change, change.T @ tip)


def _orthonormal(blocks: list[Complex], last: list[Complex]) -> tuple[Floats, int]:
    """Return a real orthonormal basis of all blocks, and how many vectors precede `last`."""
    basis: Floats = np.zeros((blocks[0].shape[0], 0))
    for block in blocks:
        basis = _extended(basis, block)
    before = basis.shape[1]
    for block in last:
        basis = _extended(basis, block)
    return basis, before


def _extended(basis: Floats, block: Complex) -> Floats:
    """Extend a real orthonormal basis by the real and imaginary parts of a block."""
    new = np.hstack([block.real, block.imag])
    new = new / np.maximum(np.linalg.norm(new, axis=0), 1e-300)
    for _ in range(2):  # twice is enough (Kahan, Parlett)
        new = new - basis @ (basis.T @ new)
    q, r, _ = _pivoted_qr(new)
    kept = np.abs(np.diag(r)) > _NOISE
    return np.hstack([basis, q[:, kept]])


def _pivoted_qr(matrix: Floats) -> tuple[Floats, Floats, Ints]:
    from scipy.linalg import qr

    return qr(matrix, mode="economic", pivoting=True)  # type: ignore[no-any-return]
