"""A solid projected on responses of it: displacement and potential get a basis each, real.

So the small system is symmetric and passive like the large one.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tactgen.fem.piezo.port_model import PortModel, undamped_modes
from tactgen.fem.piezo.symmetry import PORTS
from tactgen.fem.piezo.system import SolidSystem
from tactgen.fem.solvers.sparse_rows import wide_product
from tactgen.geometry.arrays import Bools, Complex, Floats, Ints, Numbers, Sparse

Wide = NDArray[Any]

#: A unit vector of which less than this is new is rounding of the factorisation; what is lost
#: counts by its square at the ports.
_NOISE = 1e-8
#: Deformations softer than this part of the stiffest one are projected in long double.
_SOFT = 1e-3


@dataclass(frozen=True)
class Projection:
    """A solid on a basis of responses."""

    #: On the whole basis; without the last block of every chain
    fine: PortModel
    coarse: PortModel
    #: (n, k + 3) What the solid's unknowns y are, per unknown of `fine`; complex if the solid has
    #: losses
    states: Numbers


def project(system: SolidSystem, chains: list[list[Complex]]) -> Projection:
    """Project on the real and imaginary parts of all blocks; also without each chain's last."""
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
    tip = np.zeros((s, 2))
    tip[:k] = u.T @ system.tip[:-PORTS]

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
    return Projection(fine, coarse, _spread(u, p) @ parts_of_fine)


def _spread(u: Floats, p: Floats) -> Floats:
    """Y (n + 3, ·) per displacement of the basis, port, and potential of the basis."""
    n, k = u.shape
    spread = np.zeros((n + PORTS, k + PORTS + p.shape[1]))
    spread[:n, :k], spread[:n, k + PORTS :] = u, p
    spread[n:, k : k + PORTS] = np.eye(PORTS)
    return spread


def _narrow(left: Floats, parts: list[Sparse], right: Floats) -> Wide:
    """Leftᵀ matrix right of a matrix given by its real and, if any, imaginary part."""
    products = [left.T @ (part @ right) for part in parts]
    return np.asarray(products[0] + 1j * products[1] if len(products) == 2 else products[0])


def _wide(left: Floats, parts: list[Sparse], right: Floats) -> Wide:
    """Same of a symmetric matrix, the real part in long double.

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
