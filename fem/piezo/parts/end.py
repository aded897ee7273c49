"""One end of a bimorph, its foot or its tip, reduced to its ports and the shapes at a section.

To each amplitude at a port belongs a field.  Where the port moves section or base, it is the
static one that nothing inside resists (Craig and Bampton's constraint modes).  Where it raises a
potential, nothing moves inside, so it has no inertia.  What it would move, and what inertia, losses
and forces at the tip face add, one step of each, are fields x with amplitudes of their own.  All
are K⁻¹ r of known loads r, so no product with K is needed and nothing cancels:

    K x = r,   xᵀ K x' = xᵀ r',   and with the static fields nothing: they balance inside.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from tactgen.fem.piezo.bricks import (
    elimination_order,
    loss_matrix,
    quarter_matrices,
    quarter_unknowns,
    tip_functionals,
)
from tactgen.fem.piezo.parts.section_functions import SectionFunctions
from tactgen.fem.piezo.symmetry import PORTS, Bordered, Motion, Unknowns
from tactgen.fem.piezo.system import Material, loss_tensors, volts_per_unit
from tactgen.fem.solvers.linear_solver import factorise
from tactgen.geometry.arrays import Bools, Floats, Ints, Sparse
from tactgen.geometry.bimorph.bricks import Bricks
from tactgen.geometry.store.values import storable

#: A field of which less than this of its energy is new is rounding.
_NOISE = 1e-9


@storable
@dataclass(frozen=True)
class ReducedEnd:
    """Matrices over [own fields, section, w_base, ψ_base, U], symmetric.

    Attributes
    ----------
    stiffness, mass : (k, k) array
        Lossless; the last row of the stiffness is minus the charge.
    losses : (k, k) array
        Imaginary part of the stiffness with losses; zero where no port takes part.
    face : (k, 2) array
        Displacement and rotation of the tip face; zero of a foot.
    own : int
        How many fields of the end's own come first, …
    charged : int
        … and how many of them are raised by charges: their stiffness is negative.
    """

    stiffness: Floats
    mass: Floats
    losses: Floats
    face: Floats
    own: int
    charged: int


@dataclass(frozen=True)
class End:
    """An end before it is held anywhere: what all classes of motion have in common.

    `lossless` and `lossy` are the materials of its regions without and with losses; the section is
    the top of a foot, the bottom of a tip.
    """

    bricks: Bricks
    is_foot: bool
    lossless: dict[str, Material]
    lossy: dict[str, Material]

    @cached_property
    def matrices(self) -> tuple[Sparse, Sparse]:
        """Lossless stiffness and mass."""
        return quarter_matrices(self.bricks, self.lossless, volts_per_unit(self.lossless))

    @cached_property
    def losses(self) -> Sparse:
        """Imaginary part of the stiffness with losses."""
        lost = loss_tensors(self.lossy)
        return loss_matrix(self.bricks, lost, volts_per_unit(self.lossless))

    def reduced(self, motion: Motion, functions: SectionFunctions) -> ReducedEnd:
        """Reduce the end in one class of motion: one factorisation."""
        bricks, unit = self.bricks, volts_per_unit(self.lossless)
        unknowns = _unknowns(bricks, motion, unit, functions.values, is_foot=self.is_foot)
        stiffness, mass = (unknowns.bordered(matrix) for matrix in self.matrices)
        driven = motion == "bending_x"
        losses = unknowns.bordered(self.losses) if driven else None
        at = unknowns.index
        face = np.zeros((at.size + stiffness.border.shape[1], 2))
        if driven and not self.is_foot:
            face = unknowns.seen(tip_functionals(bricks))
        order = np.argsort(4 * elimination_order(bricks)[at // 4] + at % 4)
        moving = np.ones(stiffness.border.shape[1], dtype=bool)
        moving[functions.moving : -PORTS], moving[-1] = False, False
        loads = _Loads(stiffness, mass, losses, face, moving, at % 4 == 3)
        return loads.reduced(order)


def _unknowns(
    bricks: Bricks, motion: Motion, unit: float, section: Floats, *, is_foot: bool
) -> Unknowns:
    """Return the unknowns of an end whose section is what shapes there make it.

    Its ports are the shapes' amplitudes, then w_base, ψ_base and U.
    """
    plain = quarter_unknowns(bricks, motion, unit, has_base=is_foot)
    free = plain.free.reshape(*bricks.shape, 4).copy()
    shapes = np.zeros((*bricks.shape, 4, section.shape[1]))
    at = -1 if is_foot else 0
    # the foot's grid may be wider than the section's
    nx, ny = _section_shape(bricks)
    shapes[:nx, :ny, at] = section.reshape(nx, ny, 4, -1)
    free[:, :, at] = False
    ports = np.hstack([shapes.reshape(-1, section.shape[1]), plain.ports])
    return Unknowns(free.reshape(-1, 4), ports)


def _section_shape(bricks: Bricks) -> tuple[int, int]:
    """Return the nodes along x and y of the bimorph's section."""
    slabs = bricks.tip_slabs()
    deep = max((s.y or (0, bricks.y.intervals))[1] for s in slabs)
    return max(s.x[1] for s in slabs) * bricks.x.degree + 1, deep * bricks.y.degree + 1


@dataclass(frozen=True)
class _Group:
    """Fields (n, k) of unit energy, positive or negative, and the loads (n, k) that make them."""

    fields: Floats
    loads: Floats
    sign: float

    @classmethod
    def of(cls, solve: Callable[[Floats], Floats], loads: Floats, sign: float) -> _Group:
        """Return what loads make: forces (sign 1), or charges (sign −1, as a capacitance has)."""
        fields = solve(loads)
        work = sign * np.einsum("ij,ij->j", fields, loads)
        there = work > 0.0
        fields, loads = (v[:, there] / np.sqrt(work[there]) for v in (fields, loads))
        energy, turn = np.linalg.eigh(0.5 * sign * (fields.T @ loads + loads.T @ fields))
        kept = energy > _NOISE
        turn = turn[:, kept] / np.sqrt(energy[kept])
        return cls(fields @ turn, loads @ turn, sign)


@dataclass(frozen=True)
class _Loads:
    """What acts on an end: ports, of which some are `moving`, inertia, losses, the tip face."""

    stiffness: Bordered
    mass: Bordered
    losses: Bordered | None
    face: Floats
    moving: Bools
    potential: Bools

    def reduced(self, order: Ints) -> ReducedEnd:
        """Return the small matrices; `order` is a good one to eliminate the unknowns in."""
        static, by_forces, by_charges, turn = self._fields(order)
        n, count = static.shape
        few, charged = by_forces.fields.shape[1], by_charges.fields.shape[1]
        k, own = few + charged, np.hstack([by_forces.fields, by_charges.fields])
        stiff = np.zeros((k + count, k + count))
        # charges make nothing of what forces make, nor forces of what they raise in a body at rest
        stiff[:few, :few] = by_forces.fields.T @ by_forces.loads
        stiff[few:k, few:k] = by_charges.fields.T @ by_charges.loads
        stiff[k:, k:] = self.stiffness.corner + self.stiffness.border.T @ static
        lost = np.zeros_like(stiff)
        if self.losses is not None:
            lost = _projected(self.losses, own, static, np.eye(count))
        # what is raised in a body at rest has no inertia and moves no face, to the last bit
        inert = np.zeros_like(stiff)
        moves, at = np.diag(self.moving.astype(float)), np.r_[:few, k : k + count]
        inert[np.ix_(at, at)] = _projected(self.mass, by_forces.fields, static @ moves, moves)
        face = np.vstack([own.T @ self.face[:n], static.T @ self.face[:n] + self.face[n:]])
        face[np.r_[few:k, k + np.flatnonzero(~self.moving)]] = 0.0
        # one size for all: what is left of bending after rounding is looked for among them
        size = np.ones(k + count)
        size[:k] = np.sqrt(np.abs(np.diag(stiff)[k:]).max())
        turn = turn * size
        return ReducedEnd(
            stiffness=turn.T @ (0.5 * (stiff + stiff.T)) @ turn,
            mass=size[:, None] * inert * size,
            losses=turn.T @ lost @ turn,
            face=size[:, None] * face,
            own=k,
            charged=charged,
        )

    def _fields(self, order: Ints) -> tuple[Floats, _Group, _Group, Floats]:
        """Return the static fields (n, ports), those by forces and charges, a change of fields.

        The change takes from the static fields of potentials what they move.
        """
        stiffness, mass, losses = self.stiffness, self.mass, self.losses
        solve = factorise(stiffness.inner, order=order).solve
        at_rest = self._at_rest(order)
        static = -solve(stiffness.border)
        by_ports = stiffness.border[:, ~self.moving].real
        raised = self._forces(-at_rest(by_ports)) - np.where(self.potential[:, None], 0.0, by_ports)
        inertia = (mass.inner @ static + mass.border)[:, self.moving]
        lost = np.zeros_like(static[:, :0])
        if losses is not None:
            lost = losses.inner @ static + losses.border
        charged = self.potential[:, None]
        by_charges = _Group.of(at_rest, np.where(charged, lost, 0.0), -1.0)
        pushed = [np.where(charged, 0.0, lost), self._forces(by_charges.fields)]
        forces = np.hstack([raised, inertia, self.face[: static.shape[0]], *pushed])
        by_forces = _Group.of(solve, forces, 1.0)
        few = by_forces.fields.shape[1]
        k = few + by_charges.fields.shape[1]
        turn = np.eye(k + static.shape[1])
        turn[:few, k + np.flatnonzero(~self.moving)] = -by_forces.fields.T @ raised
        return static, by_forces, by_charges, turn

    def _at_rest(self, order: Ints) -> Callable[[Floats], Floats]:
        """Return charges (n, k) ↦ the potentials (n, k) that they raise if nothing moves."""
        at = np.flatnonzero(self.potential)
        # in the order in which they stand among all unknowns
        place = np.argsort(np.argsort(order)[at])
        factor = factorise(self.stiffness.inner[at][:, at], order=place)

        def solve(charges: Floats) -> Floats:
            fields = np.zeros_like(charges)
            if charges.size:
                fields[at] = factor.solve(charges[at])
            return fields

        return solve

    def _forces(self, potentials: Floats) -> Floats:
        """Return the forces (n, k) of potentials raised in a body at rest, as they push it."""
        return np.where(self.potential[:, None], 0.0, -(self.stiffness.inner @ potentials))


def _projected(matrix: Bordered, own: Floats, static: Floats, ports: Floats) -> Floats:
    """Return the matrix over the end's own fields, and static ones with their ports' values."""
    inside = np.hstack([own, static])
    there = np.hstack([np.zeros((ports.shape[0], own.shape[1])), ports])
    across = inside.T @ (matrix.border @ there)
    product = inside.T @ (matrix.inner @ inside) + there.T @ matrix.corner @ there
    product = product + across + across.T
    return np.asarray(0.5 * (product + product.T))
