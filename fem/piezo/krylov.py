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

from tactgen.fem.piezo.brick_error import MotionEstimator
from tactgen.fem.piezo.port_model import PortModel, extremes, motions, standard_ends, undamped_modes
from tactgen.fem.piezo.ports import SEEN, SOURCE
from tactgen.fem.piezo.symmetry import PORTS
from tactgen.fem.piezo.system import SolidSystem
from tactgen.fem.solvers.linear_solver import Factor, wide_product
from tactgen.geometry.arrays import Bools, Complex, Floats, Numbers, Sparse
from tactgen.geometry.store.values import storable
from tactgen.tmm.ports.multiport import BIMORPH, Multiport, reduce

Wide = NDArray[Any]

#: A unit vector of which less than this is new is rounding of the factorisation; what is lost
#: counts by its square at the ports.
_NOISE = 1e-8
#: Deformations softer than this part of the stiffest one are projected in long double.
_SOFT = 1e-3


def project(
    system: SolidSystem, chains: list[list[Complex]]
) -> tuple[PortModel, PortModel, Numbers]:
    """Project on the real and imaginary parts of all blocks; also without each chain's last.

    Third come the solid's unknowns y per unknown of the first model (n, k + 3), complex if the
    solid has losses.
    """
    moves = system.mass.inner.diagonal() > 0.0
    blocks = [block for chain in chains for block in chain[:-1]]
    last = [chain[-1] for chain in chains]
    u, few_u = _basis(blocks, last, moves)
    p, few_p = _basis(blocks, last, ~moves)
    k, s = u.shape[1], u.shape[1] + PORTS
    stiffness, border = system.stiffness.inner, system.stiffness.border
    # apart, since a complex matrix would make the real vectors complex
    parts = [stiffness.real, stiffness.imag] if np.iscomplexobj(stiffness.data) else [stiffness]
    both = np.hstack([u, p])
    inner = _narrow(both, parts, both)
    softness, turn = np.linalg.eigh(_condensed(inner, p.shape[1])[0].real.astype(float))
    u = u @ turn
    whole = np.zeros((s + p.shape[1], s + p.shape[1]), dtype=np.clongdouble)
    whole[:k, :k], whole[:k, s:] = turn.T @ inner[:k, :k] @ turn, turn.T @ inner[:k, k:]
    whole[s:, s:] = inner[k:, k:]
    soft = int((softness < _SOFT * softness[-1]).sum())
    exact = _wide(u[:, :soft], parts, np.hstack([u, p]))
    whole[:soft, :k], whole[:soft, s:] = exact[:, :k], exact[:, k:]
    whole[:k, k:s] = u.T @ border.astype(np.clongdouble)
    whole[k:s, s:], whole[k:s, k:s] = border.T @ p, system.stiffness.corner
    whole = np.triu(whole) + np.triu(whole, 1).T
    mass = np.zeros((s, s))
    mass[:k, :k], mass[:k, k:] = u.T @ (system.mass.inner @ u), u.T @ system.mass.border
    mass[k:, k:] = system.mass.corner
    mass = np.triu(mass) + np.triu(mass, 1).T
    seen = system.seen
    tip = np.zeros((s, seen.shape[1]))
    tip[:k] = u.T @ seen[:-PORTS]

    def kept(of_u: int, of_p: int) -> tuple[PortModel, Numbers]:
        # what the first vectors span, in terms of the turned ones
        basis = np.eye(s)[:, k - of_u :]
        basis[:k, :of_u] = turn[:of_u].T
        change = np.zeros((whole.shape[0], s - k + of_u + of_p))
        change[:s, : basis.shape[1]] = basis
        change[s : s + of_p, basis.shape[1] :] = np.eye(of_p)
        stiffness, potentials = _condensed(change.T @ whole @ change, of_p)
        model, graded = _graded(stiffness, basis.T @ mass @ basis, basis.T @ tip)
        # potentials that lose follow displacements with a lag
        held = potentials.astype(complex) if system.lossy else potentials.real.astype(float)
        return model, change @ np.vstack([graded, held @ graded])

    (fine, parts_of_fine), (coarse, _) = kept(k, p.shape[1]), kept(few_u, few_p)
    # y per displacement of the basis, port, and potential of the basis
    spread = np.zeros((system.size, whole.shape[0]))
    spread[:-PORTS, :k], spread[:-PORTS, s:] = u, p
    spread[-PORTS:, k:s] = np.eye(PORTS)
    return fine, coarse, spread @ parts_of_fine


def _narrow(left: Floats, parts: list[Sparse], right: Floats) -> Wide:
    """Leftᵀ matrix right of a matrix given by its real and, if any, imaginary part."""
    products = [left.T @ (part @ right) for part in parts]
    return np.asarray(products[0] + 1j * products[1] if len(products) == 2 else products[0])


def _wide(left: Floats, parts: list[Sparse], right: Floats) -> Wide:
    """Product with a symmetric matrix, real part in long double.

    A bimorph bends ten million times more easily than its elements stretch, so the energy of
    bending is what is left of large terms; a peak magnifies what is lost by Q once more.
    """
    real = wide_product(parts[0], left).T @ right.astype(np.longdouble)
    if len(parts) == 1:
        return np.asarray(real)
    return np.asarray(real + 1j * ((parts[1] @ left).T @ right))


def _condensed(matrix: Wide, last: int) -> tuple[Wide, Wide]:
    """Eliminate the `last` unknowns (potentials, which have no mass); also how they follow."""
    if not last:
        return matrix, np.zeros((0, matrix.shape[0]))
    a, b, c = matrix[:-last, :-last], matrix[:-last, -last:], matrix[-last:, -last:]
    inverse = np.linalg.inv(c.astype(complex))
    x = inverse @ b.T
    x = x + inverse @ (b.T - c @ x)
    return np.asarray(a - b @ x), np.asarray(-x)


def _graded(stiffness: Wide, mass: Floats, tip: Floats) -> tuple[PortModel, Floats]:
    """Change to unknowns in which nothing cancels, and round to double; also return the change.

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
    return PortModel(0.5 * (small + small.T), change.T @ mass @ change, change.T @ tip), change


def _basis(blocks: list[Complex], last: list[Complex], chosen: Bools) -> tuple[Floats, int]:
    """Real orthonormal basis of the chosen rows of all blocks, zero in the others.

    Also how many of its vectors precede those of `last`.
    """
    basis: Floats = np.zeros((np.count_nonzero(chosen), 0))
    for block in blocks:
        basis = _extended(basis, block[chosen])
    before = basis.shape[1]
    for block in last:
        basis = _extended(basis, block[chosen])
    spread = np.zeros((chosen.size, basis.shape[1]))
    spread[chosen] = basis
    return spread, before


def _extended(basis: Floats, block: Complex) -> Floats:
    """Extend a real orthonormal basis by the real and imaginary parts of a block."""
    from scipy.linalg import qr

    new = np.hstack([block.real, block.imag])
    new = new / np.maximum(np.linalg.norm(new, axis=0), 1e-300)
    for _ in range(2):  # twice is enough (Kahan, Parlett)
        new = new - basis @ (basis.T @ new)
    q, r, _ = qr(new, mode="economic", pivoting=True)
    kept = np.abs(np.diag(r)) > _NOISE
    return np.hstack([basis, q[:, kept]])


#: Sign of each row of D in the symmetric system, one being minus the charge; the stiffness of
#: potentials has the other.
_SIGNS = np.array([1.0, 1.0, 1.0, 1.0, -1.0, 1.0])


#: Blocks of the Krylov basis that the first shift begins with, and that any shift has at most.
_FIRST_BLOCKS, _BLOCKS = 3, 5
#: Most shifts, each a complex factorisation.
_MOST_SHIFTS = 6
#: The first shift lies at this share of the highest frequency, but the first and any no lower than
#: so many Hz: a lower one would tell no more.
_FIRST_AT, _LOWEST_FIRST, _LOWEST = 0.7, 500.0, 20.0


@storable
@dataclass(frozen=True)
class ReducedSolid:
    """A solid projected on a Krylov basis, ports kept: a few dozen unknowns."""

    fine: PortModel  #: The reduced model
    #: The same without the last block of every shift, to judge it by: the estimate is the distance
    #: between the two, in effect the error of the poorer one
    coarse: PortModel
    range: tuple[float, float]  #: Lowest and highest frequency (Hz) it was made for
    #: Largest estimate over the frequencies it was checked at, peaks and dips included
    error: float
    unknowns: int  #: Number of unknowns of the solid
    #: (2, m, m) Products r_iᵀ K_w⁻¹ r_j of displacements, of potentials, that functions which the
    #: solid lacks have, if these were given, m = 2 k + 6 + t: of K x and of M x of every unknown,
    #: then of the t functionals that see the solid
    missing: Numbers | None = None

    def multiport(self, frequencies: Floats) -> Multiport:
        """D(Ω) (n, 5, 5)."""
        return self.fine.multiport(frequencies)

    def richer_multiports(self, frequencies: Floats) -> tuple[Multiport, Multiport]:
        """D(Ω) (n, p, p) with displacements that the solid lacks; with potentials that it lacks."""
        assert self.missing is not None
        own = self.multiport(frequencies)
        held, size = np.zeros_like(own.stiffness), len(own.ports)
        held[:, :3] = np.eye(size)[SOURCE]
        held[:, 3:] = own.stiffness[:, SEEN[: size - 3]]
        x = self.fine.states(frequencies) @ held
        omega2 = (2.0 * np.pi * own.frequencies)[:, None, None] ** 2
        r = np.concatenate([-x, omega2 * x, held[:, 3:]], axis=1)
        changes = (r.swapaxes(1, 2) @ products @ r for products in self.missing)
        moved, charged = (
            replace(own, stiffness=own.stiffness - sign[:size, None] * change)
            for sign, change in zip((_SIGNS, -_SIGNS), changes, strict=True)
        )
        return moved, charged

    def error_estimate(self, frequencies: Floats) -> Floats:
        """Estimated relative error (n,), the larger of two.

        That of D(Ω), entries against the geometric mean of their diagonal neighbours; and,
        where there are losses, that of tip displacement, tip rotation and charge per volt
        of the clamped and the sprung actuator, each against itself, so that dips count.
        """
        fine, coarse = self.multiport(frequencies), self.coarse.multiport(frequencies)
        # a place close to the tip is tied to it stiffly, and what that stiffness is off by moves
        # nothing
        error = port_error(*(reduce(of, [p.name for p in BIMORPH]) for of in (fine, coarse)))
        if np.any(self.fine.stiffness.imag):
            for end in standard_ends(self.fine):
                exact, poorer = motions(fine, end), motions(coarse, end)
                # moved by nothing, off by nothing
                size = np.where(exact == 0.0, 1.0, np.abs(exact))
                error = np.maximum(error, (np.abs(exact - poorer) / size).max(axis=0))
        return error


def port_error(port: Multiport, other: Multiport) -> Floats:
    """Distance of two D(Ω) (n,), against the geometric mean of the diagonal."""
    size = np.sqrt(np.abs(np.einsum("nii->ni", port.stiffness)))
    difference = np.abs(port.stiffness - other.stiffness)
    return np.asarray((difference / (size[:, :, None] * size[:, None, :])).max(axis=(1, 2)))


def reduce_to_ports(
    system: SolidSystem,
    frequencies: Floats,
    *,
    tolerance: float = 1e-6,
    surplus: MotionEstimator | None = None,
) -> ReducedSolid:
    """Project a solid on a rational Krylov basis that serves a range of frequencies.

    `frequencies` (n,) in Hz are where D(Ω) is wanted, `tolerance` is the estimated relative error
    (:meth:`ReducedSolid.error_estimate`) at every one of them and, with losses, at every peak and
    dip between the lowest and highest.  Shifts are added at the worst frequency until it holds or
    six are used; what was reached stays available as the estimate.  By functions of a `surplus`
    that the solid lacks it is judged, too.

    One complex factorisation per shift.  The shifts Ω² (1 + j) keep clear of all poles.  Three
    blocks serve a range well below the second resonance to rounding; two more cost less than
    another shift, so they are tried first.
    """
    frequencies = np.atleast_1d(np.asarray(frequencies, dtype=float))
    bounds = float(frequencies.min()), float(frequencies.max())
    chains = [_Chain(system, max(_FIRST_AT * bounds[1], _LOWEST_FIRST), _FIRST_BLOCKS)]
    while True:
        fine, coarse, states = project(system, [chain.blocks for chain in chains])
        reduced = ReducedSolid(fine, coarse, bounds, np.inf, system.size)
        checked = frequencies
        if np.any(fine.stiffness.imag):
            ends = standard_ends(fine)
            checked = np.concatenate([frequencies, extremes(fine, *bounds, ends)])
        estimate = reduced.error_estimate(checked)
        worst = int(np.argmax(estimate))
        full = len(chains[-1].blocks) == _BLOCKS
        if estimate[worst] <= tolerance or (full and len(chains) == _MOST_SHIFTS):
            missing = None
            if surplus is not None:
                residuals = np.hstack([*surplus.residuals(states), surplus.seen])
                missing = np.stack(surplus.products(residuals))
            return replace(reduced, error=float(estimate[worst]), missing=missing)
        if full:
            chains.append(_Chain(system, max(float(checked[worst]), _LOWEST), _BLOCKS))
        else:
            chains[-1].lengthen(_BLOCKS)


class _Chain:
    """The blocks (n, p) of one shift: responses to the ports, then their moments."""

    def __init__(self, system: SolidSystem, centre: float, length: int) -> None:
        self._mass = system.mass
        shift = (2.0 * np.pi * centre) ** 2 * (1.0 + 1.0j)
        self._factor: Factor | None = system.dynamic_factor(shift)
        border = shift * system.mass.border - system.stiffness.border
        loads = np.hstack([border, system.seen[:-PORTS]])
        self.blocks: list[Complex] = [self._factor.solve(loads)]
        self.lengthen(length)

    def lengthen(self, length: int) -> None:
        """Append blocks up to this length; a chain of full length lets its factor go."""
        assert self._factor is not None
        while len(self.blocks) < length:
            right = self._mass.inner @ self.blocks[-1]
            if len(self.blocks) == 1:
                right[:, :PORTS] += self._mass.border
            # a voltage that moves nothing (a passive ceramic) has no moments
            block = self._factor.solve(right[:, right.any(axis=0)])
            # powers alone turn parallel and lose what is new; the first block has its own load
            self.blocks.append(_orthogonal(block, self.blocks[1:]))
        if length == _BLOCKS:
            self._factor = None


def _orthogonal(block: Complex, earlier: list[Complex]) -> Complex:
    """Orthonormal basis of a block, each column scaled alike, less the earlier ones."""
    block = block / np.linalg.norm(block, axis=0)
    for _ in range(2):  # twice is enough (Kahan, Parlett)
        for other in earlier:
            block = block - other @ (other.conj().T @ block)
    return np.asarray(np.linalg.qr(block)[0])
