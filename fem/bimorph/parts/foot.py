"""The foot of a bimorph reduced to its base, its voltage and the shapes at a section.

To each amplitude at a port belongs the static field that it makes (Craig and Bampton's constraint
modes).  What inertia and losses add to it, one step of each, are fields x with amplitudes of
their own.  All are K⁻¹ r of known loads r, so no product with K is needed and nothing cancels:

    K x = r,   xᵀ K x' = xᵀ r',   and with the static fields nothing: they balance inside.

A voltage comes with the potential that it makes at the section far from all ends, and what both
move inside the foot has inertia.  What other potentials at the section move has none: it comes at
once, so shapes of potential stay without mass.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from tactgen.fem.bimorph.bordered import PORTS, Bordered
from tactgen.fem.bimorph.bricks.assembly import quarter_matrices, quarter_unknowns
from tactgen.fem.bimorph.bricks.order import elimination_order
from tactgen.fem.bimorph.motions import Motion
from tactgen.fem.bimorph.parts.section_functions import section_functions
from tactgen.fem.bimorph.symmetry import Unknowns
from tactgen.fem.bimorph.system import Material, volts_per_unit
from tactgen.fem.solvers.linear_solver import Factor, factorise
from tactgen.geometry.arrays import Bools, Complex, Floats, Ints, Numbers, Sparse
from tactgen.geometry.bimorph.brick_parts import BrickParts
from tactgen.geometry.bimorph.bricks import Bricks
from tactgen.geometry.device.materials import PiezoTensors
from tactgen.geometry.store.values import storable

#: A field of which less than this of its energy is new is rounding.
_NOISE = 1e-9


@storable
@dataclass(frozen=True)
class ReducedFoot:
    """Matrices over [own fields, section, w_base, ψ_base, U], symmetric.

    Attributes
    ----------
    stiffness, mass : (k, k) array
        Lossless; the last row of the stiffness is minus the charge.
    losses : (k, k) complex array
        What losses add to the stiffness; zero where no port takes part.
    own : int
        How many fields of the foot's own come first, …
    charged : int
        … and how many of them are raised by charges: their stiffness is negative.
    section : (4 m, s) array
        Shapes at the section, see :class:`fem.bimorph.parts.section_functions.SectionFunctions`.
    section_moving : int
        How many of them are of displacement.
    """

    stiffness: Floats
    mass: Floats
    losses: Complex
    own: int
    charged: int
    section: Floats
    section_moving: int


@dataclass(frozen=True)
class Foot:
    """The foot before it is held anywhere: what all classes of motion have in common.

    `lossless` and `lossy` are the materials of all regions without and with losses.
    """

    parts: BrickParts
    lossless: dict[str, Material]
    lossy: dict[str, Material]

    @cached_property
    def matrices(self) -> tuple[Sparse, Sparse]:
        """Lossless stiffness and mass."""
        return self._matrices(self.lossless)

    def _matrices(self, known: dict[str, Material]) -> tuple[Sparse, Sparse]:
        bricks = self.parts.foot
        own = {region: known[region] for region in bricks.regions}
        return quarter_matrices(bricks, own, volts_per_unit(self.lossless))

    def reduced(self, motion: Motion) -> ReducedFoot:
        """Reduce the foot in one class of motion: one factorisation of the foot."""
        parts, unit = self.parts, volts_per_unit(self.lossless)
        functions = section_functions(parts.middle, self.lossless, unit, motion, parts.share)
        unknowns = joined_unknowns(parts.foot, motion, unit, functions.values, top=True)
        stiffness, mass = (unknowns.bordered(matrix) for matrix in self.matrices)
        losses = None
        if motion == "bending_x":
            added = {r: _difference(self.lossy[r], of) for r, of in self.lossless.items()}
            lost, _ = self._matrices(added)
            lost.eliminate_zeros()  # most of the foot is steel without losses
            losses = unknowns.bordered(lost)
        at = unknowns.index
        order = np.argsort(4 * elimination_order(parts.foot)[at // 4] + at % 4)
        ports = stiffness.border.shape[1]
        # what has inertia of the static fields: displacements and, with its potential, the voltage
        moves = np.diag((np.arange(ports) < functions.moving).astype(float))
        moves[-PORTS:, -PORTS:] = np.eye(PORTS)
        moves[: functions.by_voltage.size, -1] = functions.by_voltage
        static, fields = _fields(stiffness, mass, losses, moves, order, at % 4 == 3)
        own = np.hstack([group.fields for group in fields])
        # charges raise fields that have no inertia, like the potential that they are mostly of
        heavy = np.concatenate(
            [np.full(g.fields.shape[1], g.sign > 0.0, dtype=float) for g in fields]
        )
        k = own.shape[1]
        stiff = np.zeros((k + ports, k + ports))
        stiff[:k, :k] = own.T @ np.hstack([group.loads for group in fields])
        stiff[k:, k:] = stiffness.corner + stiffness.border.T @ static
        return ReducedFoot(
            stiffness=0.5 * (stiff + stiff.T),
            mass=_projected(mass, own * heavy, static @ moves, moves).real,
            losses=np.zeros((k + ports, k + ports), dtype=complex)
            if losses is None
            else _projected(losses, own, static, np.eye(ports)).astype(complex),
            own=k,
            charged=int(k - heavy.sum()),
            section=functions.values,
            section_moving=functions.moving,
        )


def _difference(lossy: Material, lossless: Material) -> Material:
    """Return what losses add to a material's tensors, as a material."""
    piezo = None
    if lossy.piezo is not None and lossless.piezo is not None:
        of, less = lossy.piezo, lossless.piezo
        piezo = PiezoTensors(of.c - less.c, of.e - less.e, of.eps - less.eps)
    return Material(lossy.c - lossless.c, lossy.density, piezo)


def joined_unknowns(
    bricks: Bricks, motion: Motion, unit: float, section: Floats, *, top: bool
) -> Unknowns:
    """Return the unknowns of a part whose top or bottom section is what shapes there make it.

    Its ports are the shapes' amplitudes, then w_base, ψ_base and U.
    """
    plain = quarter_unknowns(bricks, motion, unit, has_base=top)
    free = plain.free.reshape(*bricks.shape, 4).copy()
    shapes = np.zeros((*bricks.shape, 4, section.shape[1]))
    at = -1 if top else 0
    # the foot's grid may be wider than the section's
    nx, ny = section_shape(bricks)
    shapes[:nx, :ny, at] = section.reshape(nx, ny, 4, -1)
    free[:, :, at] = False
    ports = np.hstack([shapes.reshape(-1, section.shape[1]), plain.ports])
    return Unknowns(free.reshape(-1, 4), ports)


def section_shape(bricks: Bricks) -> tuple[int, int]:
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
    def of(cls, factor: Factor, loads: Floats, sign: float) -> _Group:
        """Return what loads make: forces (sign 1), or charges (sign −1, as a capacitance has)."""
        fields = factor.solve(loads)
        work = sign * np.einsum("ij,ij->j", fields, loads)
        there = work > 0.0
        fields, loads = (v[:, there] / np.sqrt(work[there]) for v in (fields, loads))
        energy, turn = np.linalg.eigh(0.5 * sign * (fields.T @ loads + loads.T @ fields))
        kept = energy > _NOISE
        turn = turn[:, kept] / np.sqrt(energy[kept])
        return cls(fields @ turn, loads @ turn, sign)


def _fields(
    stiffness: Bordered,
    mass: Bordered,
    losses: Bordered | None,
    moves: Floats,
    order: Ints,
    potential: Bools,
) -> tuple[Floats, list[_Group]]:
    """Return the static fields (n, ports), and the foot's own ones."""
    factor = factorise(stiffness.inner, order=order)
    static = -factor.solve(stiffness.border)
    forces = ((mass.inner @ static + mass.border) @ moves)[:, np.any(moves, axis=0)]
    if losses is None:
        return static, [_Group.of(factor, forces, 1.0)]
    lost = (losses.inner @ static + losses.border).imag
    forces = np.hstack([forces, np.where(potential[:, None], 0.0, lost)])
    charges = np.where(potential[:, None], lost, 0.0)
    return static, [_Group.of(factor, forces, 1.0), _Group.of(factor, charges, -1.0)]


def _projected(matrix: Bordered, own: Floats, static: Floats, ports: Floats) -> Numbers:
    """Return the matrix over the foot's own fields, and static ones with their ports' values."""
    inside = np.hstack([own, static])
    there = np.hstack([np.zeros((ports.shape[0], own.shape[1])), ports])
    across = inside.T @ (matrix.border @ there)
    product = inside.T @ (matrix.inner @ inside) + there.T @ matrix.corner @ there
    product = product + across + across.T
    return np.asarray(0.5 * (product + product.T))
