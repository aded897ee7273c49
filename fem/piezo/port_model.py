"""A small system that answers at the ports of a solid: D(Ω) from its inner poles.

Unknowns [q, w_base, ψ_base, U], all with mass but U.  Base and electrode held and the tip free,
the inner response is G(Ω) = (K − Ω² M)⁻¹.  In the undamped modes (K' the real part of K)

    Wᵀ K' W = 1,   Wᵀ M W = S²,   Wᵀ K W = P⁻¹,

    G = P + Ω² P S (1 − Ω² C)⁻¹ S P   with   C = S P S = Y diag(μ) Y⁻¹,

so after one small eigenvalue problem D(Ω) is a sum over the poles Ω² = 1/μ.  What base motion
does statically and by its inertia is split off first, so that nothing cancels at 0 Hz.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from tactgen.fem.piezo.ports import ports_from_blocks
from tactgen.geometry.arrays import Complex, Floats, Ints
from tactgen.geometry.bimorph.boundary_conditions import Ends, Springs
from tactgen.geometry.store.values import storable
from tactgen.tmm.ports.multiport import MEASURED, Multiport, respond
from tactgen.tmm.ports.supports_and_loads import attach


@storable
@dataclass(frozen=True)
class PortModel:
    """Matrices over [q, w_base, ψ_base, U], symmetric; the last row is minus the charge."""

    stiffness: Complex  #: (k + 3, k + 3) complex Its real part is positive definite over q
    #: (k + 3, k + 3) Positive definite but for the row and column of U, which are zero
    mass: Floats
    #: (k + 3, t) From the unknowns the tip's displacement and rotation, and the displacement at the
    #: place of measurement, if there is one
    tip: Floats

    def multiport(self, frequencies: Floats) -> Multiport:
        """D(Ω) (n, p, p), a few microseconds each."""
        f = np.atleast_1d(np.asarray(frequencies, dtype=float))
        p = self._poles
        o2 = (2.0 * np.pi * f)[:, None] ** 2
        g = ((o2 / (1.0 - o2 * p.mu)) @ p.products).reshape(-1, *p.still.shape) + p.still
        o2 = o2[:, :, None]
        held = p.static - o2 * p.inertia - o2**2 * g[:, :3, :3]
        through = p.carried - o2 * g[:, :3, 3:]
        follows = -through.transpose(0, 2, 1)
        return ports_from_blocks(f, held, through, follows, g[:, 3:, 3:])

    def states(self, frequencies: Floats) -> Complex:
        """Unknowns (n, k + 3, p) per unit w_base, ψ_base, U, and forces on what is seen.

        Base and electrode are held and the tip is free where it is not said otherwise.
        """
        f = np.atleast_1d(np.asarray(frequencies, dtype=float))
        p = self._poles
        o2 = (2.0 * np.pi * f)[:, None, None] ** 2
        found = np.zeros((f.size, self.stiffness.shape[0], len(p.still)), dtype=complex)
        inner, driven = found[:, :-3], p.shapes * (o2 / (1.0 - o2 * p.mu))
        inner[:] = p.at_rest + driven @ p.loads
        inner[:, :, :3] *= o2
        inner[:, :, :3] -= p.follows
        found[:, -3:, :3] = np.eye(3)
        return found

    @cached_property
    def _poles(self) -> _Poles:
        k = self.stiffness.shape[0] - 3
        modes, s2 = undamped_modes(self.stiffness[:k, :k].real, self.mass[:k, :k])
        s = np.sqrt(s2)
        p = np.linalg.inv(np.eye(k) + 1j * (modes.T @ self.stiffness[:k, :k].imag @ modes))
        mu, y = np.linalg.eig(s[:, None] * p * s)
        pull, drag = modes.T @ self.stiffness[:k, k:], modes.T @ self.mass[:k, k:]
        follows = p @ pull
        moved = drag - s2[:, None] * follows
        loads = np.hstack([moved, modes.T @ self.tip[:k]])
        left, right = (loads.T @ p * s) @ y, np.linalg.solve(y, s[:, None] * (p @ loads))
        return _Poles(
            mu=mu,
            products=(left.T[:, :, None] * right[:, None, :]).reshape(k, -1),
            still=np.asarray(loads.T @ p @ loads, dtype=complex),
            static=self.stiffness[k:, k:] - pull.T @ follows,
            inertia=self.mass[k:, k:] - drag.T @ follows - follows.T @ moved,
            carried=follows.T @ loads[:, 3:] - self.tip[k:],
            shapes=modes @ (p * s) @ y,
            loads=right,
            at_rest=np.asarray(modes @ p @ loads, dtype=complex),
            follows=modes @ follows,
        )


@dataclass(frozen=True)
class _Poles:
    """D(Ω) as sums: `products` (k, p²) belong to the poles `mu`; the rest is constant.

    The inner unknowns alike: `shapes` (k, k) belong to the poles under `loads` (k, p), `at_rest`
    (k, p) is constant, and they follow base and voltage by `follows` (k, 3).
    """

    mu: Complex
    products: Complex
    still: Complex
    static: Complex
    inertia: Complex
    carried: Complex
    shapes: Complex
    loads: Complex
    at_rest: Complex
    follows: Complex


def undamped_modes(stiffness: Floats, mass: Floats) -> tuple[Floats, Floats]:
    """Modes W (k, k) with Wᵀ K W = 1, and s² (k,) = 1/ω², lowest frequency first."""
    lower = np.linalg.cholesky(stiffness)
    inverse = np.linalg.inv(lower)
    values, vectors = np.linalg.eigh(inverse @ mass @ inverse.T)
    return inverse.T @ vectors[:, ::-1], np.maximum(values[::-1], 0.0)


#: Frequencies of the search grid; a peak is as wide as 1/Q, and Q is below some hundreds.
_GRID = 2000
#: Where the grid begins: at this share of the highest frequency, and at so many Hz, at least.
_BOTTOM, _LOWEST = 1e-3, 1e-3
#: Relative distance below which two of its frequencies are one.
_SAME = 1e-6
#: Steps of the golden section, each shrinking a bracket to 0.618: of 1.4e-2 of its frequency, the
#: widest of the grid, 4e-7 are left, a thousandth of the width of a peak.
_STEPS = 22


def standard_ends(model: PortModel) -> tuple[Ends, Ends]:
    """Two ends to judge by: clamped, and on springs as stiff as the solid; tip free.

    Without any support the rigid motion at low frequencies is a matter of rounding.
    """
    port = model.multiport(np.zeros(1))
    lateral, rotational = (float(port[at, at][0].real) for at in ("w_base", "psi_base"))
    return Ends(), Ends(Springs(lateral, rotational))


_SEEN = ("w_tip", "psi_tip", MEASURED.name)


def motions(port: Multiport, ends: Ends) -> Complex:
    """Tip displacement, tip rotation, what is measured besides, and charge per volt, (m, n)."""
    answer = respond(attach(port, ends), {"voltage": 1.0})
    seen = [answer.motion[name] for name in _SEEN if name in answer.motion]
    return np.array([*seen, answer.effort["voltage"]])


def extremes(model: PortModel, low: float, high: float, ends: tuple[Ends, ...]) -> Floats:
    """Frequencies (Hz) of all local maxima and minima of |motions|, ascending.

    Bracketed on a grid, linear and logarithmic, then refined by golden section.
    """
    bottom = max(low, _BOTTOM * high, _LOWEST)
    if high <= bottom:
        return np.zeros(0)
    both = np.geomspace(bottom, high, _GRID // 2), np.linspace(bottom, high, _GRID // 2)
    grid = np.union1d(*both)
    # of points that all but coincide, only rounding tells the higher one
    grid = grid[np.append(np.diff(grid) > _SAME * grid[:-1], True)]
    port = model.multiport(grid)
    found: list[Floats] = [np.zeros(0)]
    for end in ends:
        values = np.abs(motions(port, end))
        rise: Floats = np.sign(np.diff(values, axis=1))
        rise[~values.all(axis=1)] = 0.0  # a passive ceramic moves nothing
        row, turn = np.nonzero(rise[:, 1:] != rise[:, :-1])
        if row.size:
            sign = np.asarray(rise[row, turn])
            found.append(_refined(model, end, row, grid[turn], grid[turn + 2], sign))
    return np.unique(np.concatenate(found))


def _refined(
    model: PortModel, end: Ends, row: Ints, low: Floats, high: Floats, sign: Floats
) -> Floats:
    """Where sign · log|motion| is largest in each bracket (m,), `row` telling the motion."""

    def values(at: Floats) -> Floats:
        """Them at (2, m) frequencies."""
        moved = motions(model.multiport(at.ravel()), end).reshape(-1, *at.shape)
        return np.asarray(sign * np.log(np.abs(moved[row, :, np.arange(row.size)].T)))

    golden = 0.5 * (np.sqrt(5.0) - 1.0)
    for _ in range(_STEPS):
        step = golden * (high - low)
        inner = np.stack([high - step, low + step])
        left = np.greater(*values(inner))
        low, high = np.where(left, low, inner[0]), np.where(left, inner[1], high)
    return np.asarray(0.5 * (low + high))
