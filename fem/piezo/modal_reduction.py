"""A solid reduced to its :class:`~fem.piezo.modal_reduction.ModalModel`.

The basis is what base motion, tip and charge load, and K⁻¹ M of it again and again, with a random
load for modes that these do not reach.  So it holds the lowest held modes and the series in
Ω² K⁻¹ M of (K − Ω² M)⁻¹ f, which converges fast below the modes left out.

Potentials have no mass, and their part of K is negative.  Where they follow the displacements, K
is that of a definite problem, whose frequencies a basis gives from above.  So the charge acts
through the forces that its potentials make, and what it does to potentials by themselves is a
capacitance; its whole answer in the basis let frequencies appear that no body has.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from tactgen.fem.piezo.modes import SHIFT, ModeClass, section_motions, strongest
from tactgen.fem.piezo.symmetry import Motion
from tactgen.fem.piezo.system import SolidSystem, Surplus
from tactgen.fem.solvers.linear_solver import factorise
from tactgen.geometry.arrays import Floats, Numbers, Sparse
from tactgen.geometry.bimorph.ends import Ends, TipLoad
from tactgen.geometry.store.values import storable

#: A tip this many times stiffer than the solid is held.
_HELD = 1e6


@storable
@dataclass(frozen=True)
class BareMode:
    """A natural mode without its shape: frequency (Hz), its class, and the class of the system."""

    frequency: float
    kind: ModeClass
    motion: Motion


@storable
@dataclass(frozen=True)
class ModalModel:
    """Symmetric matrices over [q, w_base, ψ_base] at U = 0, nothing attached.

    Attributes
    ----------
    stiffness, mass : (k + 2, k + 2) array
        K, where base motion needs no force, and M.
    tip, charge : (k + 2,) array
        Mean tip displacement (m) and charge (C) from the unknowns.
    capacitance : float
        Charge per voltage where nothing moves (F).
    motions : (6, slices, k + 2) array
        Motions of sections, see :func:`fem.piezo.symmetry.section_motions`.
    energy : (k + 2, k + 2) array
        Nodal mass, for the share of a class in the energy.
    motion : str
        The motions that the solid can make.
    surplus : (2, 2 k + 6, 2 k + 6) array, optional
        Products r_iᵀ K⁻¹ r_j of the residuals that functions the mesh lacks
        (:class:`fem.piezo.system.Surplus`) have with K x and with M x of the unknowns, with
        the charge and with the tip: of displacements, and of potentials.
    missing : (2 k + 6, 2 k + 6) array, optional
        Those of them that the modes are moved by.
    """

    stiffness: Floats
    mass: Floats
    tip: Floats
    charge: Floats
    capacitance: float
    motions: Floats
    energy: Floats
    motion: Motion
    surplus: Floats | None = None
    missing: Floats | None = None

    def modes(self, ends: Ends, count: int, *, open_circuit: bool = False) -> list[BareMode]:
        """Return the lowest `count` modes, ascending, without damping and rigid motions."""
        squares, shapes = self._solved(ends, open_circuit=open_circuit)
        found = []
        for omega2, y in zip(squares[:count], shapes.T[:count], strict=True):
            if self.missing is not None:
                r = self._residual(y, omega2, ends, open_circuit=open_circuit)
                # of a mode that the mesh does not resolve half is left
                omega2 -= min(float(r @ self.missing @ r), 0.5 * omega2)
            found.append(
                BareMode(float(np.sqrt(omega2) / (2.0 * np.pi)), self._kind(y), self.motion)
            )
        return found

    def opened(self, ends: Ends) -> tuple[float, float]:
        """Return what functions that the mesh lacks make of Ω² of open to short circuit, relative.

        Of the first mode that bends in x: the change, and the most that it can be with as much
        missing of either factor of its products (Cauchy, Schwarz).  Needs :attr:`surplus`.
        """
        assert self.surplus is not None
        (before, short), (after, opened) = (
            self._first_bending(ends, open_circuit=circuit) for circuit in (False, True)
        )
        if before @ self.mass @ after < 0.0:
            opened = -opened
        both = np.array([opened - short, opened + short])
        moved, charged = (both @ products @ both.T for products in self.surplus)
        bounds = (np.sqrt(max(of[0, 0] * of[1, 1], 0.0)) for of in (moved, charged))
        return float(charged[0, 1] - moved[0, 1]), float(sum(bounds))

    def _first_bending(self, ends: Ends, *, open_circuit: bool) -> tuple[Floats, Floats]:
        """Return the first mode that bends in x (k + 2,), and its residual per root of energy."""
        squares, shapes = self._solved(ends, open_circuit=open_circuit)
        i = int(np.argmax([self._kind(y) == "bending_x" for y in shapes.T]))
        residual = self._residual(shapes[:, i], squares[i], ends, open_circuit=open_circuit)
        return shapes[:, i], residual / np.sqrt(squares[i])

    def _solved(self, ends: Ends, *, open_circuit: bool) -> tuple[Floats, Floats]:
        """Return Ω² (n,) of all modes but rigid motions, ascending, and the modes (k + 2, n)."""
        k, m = self.stiffness.copy(), self.mass.copy()
        base, load = ends.base, ends.conservative_tip
        if base is not None:
            k[-2:, -2:] += np.diag([base.lateral_stiffness, base.rotational_stiffness])
            m[-1, -1] += base.rotational_inertia
        moved = np.outer(self.tip, self.tip)
        k, m = k + load.stiffness * moved, m + load.mass * moved
        if open_circuit:
            k += np.outer(self.charge, self.charge) / self.capacitance
        free = slice(None) if base is not None else slice(-2)
        k, m = k[free, free], m[free, free]
        shift = SHIFT if ends.rigid_motions else 0.0
        # the lowest modes are the largest values of the inverse, and right to rounding there
        lower = np.linalg.cholesky(m)
        inverse = lower.T @ np.linalg.solve(k + shift * m, lower)
        values, vectors = np.linalg.eigh(0.5 * (inverse + inverse.T))
        chosen = [i for i in reversed(range(values.size)) if values[i] > 0.0][ends.rigid_motions :]
        shapes = np.zeros((self.tip.size, len(chosen)))
        shapes[free] = np.linalg.solve(lower.T, vectors[:, chosen])
        return 1.0 / values[chosen] - shift, shapes

    def _kind(self, y: Floats) -> ModeClass:
        return strongest(self.motions @ y, float(y @ self.energy @ y))[0]

    def _residual(self, y: Floats, omega2: float, ends: Ends, *, open_circuit: bool) -> Floats:
        """Return the residual (2 k + 6,) of a mode in terms of :attr:`surplus`."""
        load = ends.conservative_tip
        charge = float(self.charge @ y) / self.capacitance if open_circuit else 0.0
        moved = (load.stiffness - omega2 * load.mass) * float(self.tip @ y)
        return np.concatenate([y, -omega2 * y, [charge, moved]])

    def highest(self, count: int) -> list[BareMode]:
        """Return modes that are, one by one, as high as any support, load and circuit has them."""
        k = self.stiffness[:-2, :-2]
        stiffness = 1.0 / float(self.tip[:-2] @ np.linalg.solve(k, self.tip[:-2]))
        return self.modes(Ends(None, TipLoad(_HELD * stiffness)), count, open_circuit=True)


#: Held modes that come to rest beside those wanted: a load and an open circuit each lift a mode
#: past one other at most, springs of the base none.
_MORE = 2
#: Their residual before the last block, that of K⁻¹ M x = x / ω² relative to 1 / ω²: frequencies,
#: which err by its square, are then those of the mesh to 1e-9.
_RESIDUAL = 1e-3
#: Least blocks of the series.
_BLOCKS = 4
#: A vector of which less than this is new is rounding.
_NOISE = 1e-8
#: One that lost more than this share is made orthogonal once more.
_LOST = 0.1
#: Most blocks; each gains a digit or more.
_MOST_BLOCKS = 100


def modal_model(system: SolidSystem, count: int, surplus: Surplus | None = None) -> ModalModel:
    """Reduce a lossless solid to what its lowest `count` modes on any support need.

    Costs one search for modes with the factor of the statics; and what functions that the solid
    lacks make of the modes, if these are given.
    """
    n, factor, mass = system.inner, system.held_factor, system.mass.inner
    follows = -factor.solve(system.stiffness.border[:, :2])
    carried = mass @ follows + system.mass.border[:, :2]
    tip, charge = system.tip[:, 0], -system.stiffness.border[:, 2]
    field, forces = _alone(system, charge)
    rest = mass @ np.random.default_rng(0).standard_normal(n)
    loads = np.column_stack([carried, tip[:n], forces, rest])
    basis = _Basis(factor.solve, mass, loads)
    basis.grow_to_rest(count + _MORE)
    size = basis.size
    shapes = np.vstack([np.column_stack([basis.shapes, follows]), np.zeros((2, size + 2))])
    shapes[n:, size:] = np.eye(2)
    stiffness, whole = np.zeros((2, size + 2, size + 2))
    stiffness[:-2, :-2] = basis.shapes.T @ basis.loads
    whole[:-2, :-2] = basis.shapes.T @ basis.weighed
    whole[:-2, -2:] = basis.shapes.T @ carried
    whole[-2:, :-2] = whole[:-2, -2:].T
    whole[-2:, -2:] = (
        follows.T @ carried + system.mass.border[:, :2].T @ follows + system.mass.corner[:2, :2]
    )
    nodal = system.nodal_displacement(shapes)
    flat = nodal.reshape(-1, shapes.shape[1])
    return ModalModel(
        stiffness=0.5 * (stiffness + stiffness.T),
        mass=0.5 * (whole + whole.T),
        tip=shapes.T @ tip[: n + 2],
        charge=shapes.T @ np.concatenate([charge, -system.stiffness.corner[:2, 2]]),
        capacitance=float(charge @ field - system.stiffness.corner[2, 2]),
        motions=section_motions(system.nodes, system.node_mass, nodal),
        energy=flat.T @ (np.repeat(system.node_mass, 3)[:, None] * flat),
        motion=system.motion,
        surplus=None if surplus is None else _lacking(surplus, shapes, field),
    )


def _alone(system: SolidSystem, charge: Numbers) -> tuple[Floats, Floats]:
    """Return the potentials (n,) of 1 V where nothing moves, and the forces (n,) that they make.

    `charge` (n,) is what 1 V acts with on displacements and on potentials.
    """
    free = system.mass.inner.diagonal() == 0.0
    field = np.zeros(system.inner)
    if free.any():
        order = system.elimination
        if order is not None:
            order = (np.cumsum(free) - 1)[order[free[order]]]
        field[free] = factorise(-system.held[free][:, free], order=order).solve(-charge[free])
    forces = charge - system.held @ field
    forces[free] = 0.0
    return field, forces


def _lacking(surplus: Surplus, shapes: Floats, field: Floats) -> Floats:
    """Return what :class:`ModalModel` keeps of functions that the solid lacks."""
    size = shapes.shape[1]
    states = np.zeros((shapes.shape[0] + 1, size + 1))
    states[:-1, :-1], states[-1, -1] = shapes, 1.0
    states[: field.size, -1] = field
    stiffness, mass = surplus.residuals(states)
    # at 1 V the lacking functions see minus the charge, as all others do
    each = [stiffness[:, :-1], mass[:, :-1], -stiffness[:, -1:], surplus.tip[:, :1]]
    return np.stack(surplus.products(np.hstack(each)))


class _Basis:
    """Vectors x of unit mass, orthogonal in it, each with its load K x and with M x.

    Block Lanczos around 0 Hz without restarts (G. H. Golub and C. F. Van Loan, Matrix Computations,
    4th ed., 10.3.6).  Every x is K⁻¹ r of a known load r, so xᵢᵀ K xⱼ = xᵢᵀ rⱼ: bending, ten
    million times softer than what it is assembled from, is never a difference of large terms.
    """

    def __init__(self, solve: Callable[[Floats], Floats], mass: Sparse, start: Floats) -> None:
        self._solve, self._mass, self._next = solve, mass, start
        self.shapes, self.loads, self.weighed = np.zeros((3, start.shape[0], 0))

    @property
    def size(self) -> int:
        """Number of vectors."""
        return int(self.shapes.shape[1])

    def grow_to_rest(self, count: int) -> None:
        """Add blocks until the lowest `count` modes have come to rest."""
        self._grow()
        for blocks in range(2, _MOST_BLOCKS + 1):
            values, parts = self._lowest(count)
            last = parts[self.size - self._next.shape[1] :]
            outside = self._grow()
            residuals = values * np.sqrt(np.abs((last * (outside @ last)).sum(axis=0)))
            at_rest = values.size == count and bool((residuals <= _RESIDUAL).all())
            if (at_rest and blocks >= _BLOCKS) or self._next.shape[1] == 0:
                return

    def _lowest(self, count: int) -> tuple[Floats, Floats]:
        """Return ω² of modes and their parts (k, count); right to rounding as inverses are."""
        inverse = np.linalg.inv(self.shapes.T @ self.loads)
        found, parts = np.linalg.eigh(0.5 * (inverse + inverse.T))
        chosen = slice(None, max(found.size - count, 0) - found.size - 1, -1)
        return 1.0 / found[chosen], parts[:, chosen]

    def _grow(self) -> Floats:
        """Add K⁻¹ of the next loads; return the products (j, j) in the mass of what was new."""
        found, force = self._solve(self._next), self._next
        known = self.weighed.T @ found
        found, force = found - self.shapes @ known, force - self.loads @ known
        outside = found.T @ (self._mass @ found)
        sizes = np.sqrt((known**2).sum(axis=0) + np.maximum(outside.diagonal(), 0.0))
        before = self.size
        for x, load, size in zip(found.T, force.T, sizes, strict=True):
            self._take(x, load, size)
        self._next = self.weighed[:, before:]
        return np.asarray(outside)

    def _take(self, x: Floats, load: Floats, size: float) -> None:
        """Add what is new in a vector of which there was `size`."""
        least, left = _NOISE * size, 0.0
        while left <= _LOST * size:
            size = left or size
            known = self.weighed.T @ x
            x, load = x - self.shapes @ known, load - self.loads @ known
            weighed = self._mass @ x
            left = float(np.sqrt(max(float(x @ weighed), 0.0)))
            if left <= least:
                return
        self.shapes = np.column_stack([self.shapes, x / left])
        self.loads = np.column_stack([self.loads, load / left])
        self.weighed = np.column_stack([self.weighed, weighed / left])
