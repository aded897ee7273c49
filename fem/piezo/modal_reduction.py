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

import numpy as np

from tactgen.fem.piezo.brick_error import MotionEstimator
from tactgen.fem.piezo.modal_model import ModalModel, section_motions
from tactgen.fem.piezo.system import SolidSystem
from tactgen.fem.solvers.linear_solver import factorise
from tactgen.geometry.arrays import Floats, Numbers, Sparse

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


def modal_model(
    system: SolidSystem, count: int, surplus: MotionEstimator | None = None
) -> ModalModel:
    """Reduce a lossless solid to its lowest `count` modes on any support.

    Costs one search for modes with the factor of the statics; and what functions that the solid
    lacks make of the modes, if these are given.
    """
    n, factor, mass = system.inner, system.held_factor, system.mass.inner
    follows = -factor.solve(system.stiffness.border[:, :2])
    carried = mass @ follows + system.mass.border[:, :2]
    tip, charge = system.tip[:, 0], system.charge.real
    field, forces = _alone(system, charge[:n])
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
        tip=shapes.T @ system.tip[: n + 2],
        charge=shapes.T @ charge[:-1],
        capacitance=float(charge[:n] @ field + charge[-1]),
        motions=section_motions(system.nodes, system.node_mass, nodal),
        energy=flat.T @ (np.repeat(system.node_mass, 3)[:, None] * flat),
        motion=system.motion,
        surplus=None if surplus is None else _lacking(surplus, shapes, field),
    )


def _alone(system: SolidSystem, charge: Numbers) -> tuple[Floats, Floats]:
    """Potentials (n,) of 1 V where nothing moves, and the forces (n,) that they make.

    `charge` (n,) is what 1 V acts with on displacements and on potentials.
    """
    free = system.mass.inner.diagonal() == 0.0
    field = np.zeros(system.inner)
    if free.any():
        order = system.elimination
        if order is not None:
            order = (np.cumsum(free) - 1)[order[free[order]]]
        field[free] = factorise(-system.stiffness.inner[free][:, free], order=order).solve(
            -charge[free]
        )
    forces = charge - system.stiffness.inner @ field
    forces[free] = 0.0
    return field, forces


def _lacking(surplus: MotionEstimator, shapes: Floats, field: Floats) -> Floats:
    """Estimator-space part of :class:`ModalModel`."""
    size = shapes.shape[1]
    states = np.zeros((shapes.shape[0] + 1, size + 1))
    states[:-1, :-1], states[-1, -1] = shapes, 1.0
    states[: field.size, -1] = field
    stiffness, mass = surplus.residuals(states)
    # at 1 V the lacking functions see minus the charge, as all others do
    each = [stiffness[:, :-1], mass[:, :-1], -stiffness[:, -1:], surplus.seen[:, :2]]
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
        """Ω² of modes and their parts (k, count); right to rounding as inverses are."""
        inverse = np.linalg.inv(self.shapes.T @ self.loads)
        found, parts = np.linalg.eigh(0.5 * (inverse + inverse.T))
        chosen = slice(None, max(found.size - count, 0) - found.size - 1, -1)
        return 1.0 / found[chosen], parts[:, chosen]

    def _grow(self) -> Floats:
        """Add K⁻¹ of the next loads; return their mass products (j, j)."""
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
        """Orthogonalise and add a vector of norm `size`."""
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
