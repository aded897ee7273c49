"""The foot of a bimorph reduced to its base, its voltage and the shapes at a section.

Unknowns are amplitudes of fields, displacement and potential apart, so that the small system
has a definite mass and is as passive as the large one.  To each amplitude at a port belongs the
static field that it makes (Craig and Bampton's constraint modes); what inertia and what losses
add to these fields, one step of each, are fields with amplitudes of their own.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from tactgen.fem.bimorph.bordered import PORTS, Bordered
from tactgen.fem.bimorph.bricks.assembly import quarter_matrices, quarter_unknowns
from tactgen.fem.bimorph.bricks.order import elimination_order
from tactgen.fem.bimorph.motions import Motion
from tactgen.fem.bimorph.parts.section_functions import (
    SectionFunctions,
    section_functions,
)
from tactgen.fem.bimorph.symmetry import Unknowns
from tactgen.fem.bimorph.system import Material, volts_per_unit
from tactgen.fem.solvers.linear_solver import factorise
from tactgen.geometry.arrays import Bools, Floats, Ints, Numbers, Sparse
from tactgen.geometry.bimorph.brick_parts import BrickParts
from tactgen.geometry.bimorph.bricks import Bricks
from tactgen.geometry.store.values import storable

#: A unit vector of which less than this is new is rounding.
_NOISE = 1e-9


@storable
@dataclass(frozen=True)
class ReducedFoot:
    """Matrices over [q_u, q_φ, section, w_base, ψ_base, U], symmetric.

    Attributes
    ----------
    stiffness, mass : (k, k) array
        Lossless; the last row of the stiffness is minus the charge.
    lossy : (k, k) complex array
        The stiffness with losses; empty (0, 0) where no port takes part.
    moving, still : int
        How many fields of displacement and of potential come first.
    section : (4 m, s) array
        Shapes at the section, see :class:`SectionFunctions`.
    section_moving : int
        How many of them are of displacement.
    """

    stiffness: Floats
    mass: Floats
    lossy: Numbers
    moving: int
    still: int
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
        damped = None
        if motion == "bending_x":
            damped = unknowns.bordered(self._matrices(self.lossy)[0])
        at = unknowns.index
        order = np.argsort(4 * elimination_order(parts.foot)[at // 4] + at % 4)
        fields, moving, still = _fields(stiffness, mass, damped, functions, order, at % 4 == 3)
        return ReducedFoot(
            stiffness=_projected(stiffness, fields),
            mass=_projected(mass, fields),
            lossy=np.zeros((0, 0), complex) if damped is None else _projected(damped, fields),
            moving=moving,
            still=still,
            section=functions.values,
            section_moving=functions.moving,
        )


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


def _fields(
    stiffness: Bordered,
    mass: Bordered,
    damped: Bordered | None,
    functions: SectionFunctions,
    order: Ints,
    potential: Bools,
) -> tuple[Floats, int, int]:
    """Return the fields (n + s + 3, k) of all amplitudes, and how many move and are still.

    Over the inner unknowns, then the ports.
    """
    n, ports = stiffness.border.shape
    factor = factorise(stiffness.inner, order=order)
    static = -factor.solve(stiffness.border)
    more = [static, factor.solve(mass.inner @ static + mass.border)]
    if damped is not None:
        more.append(factor.solve((damped.inner @ static + damped.border).imag))
    # amplitudes of displacement carry displacement along, those of potential potential
    moves = np.arange(ports) < functions.moving
    moves[-PORTS:-1] = True
    attached = np.where(potential[:, None] != moves, static, 0.0)
    left = np.hstack([static - attached, *more[1:]])
    u = _orthonormal(np.where(potential[:, None], 0.0, left))
    phi = _orthonormal(np.where(potential[:, None], left, 0.0))
    k = u.shape[1] + phi.shape[1]
    fields = np.zeros((n + ports, k + ports))
    fields[:n] = np.hstack([u, phi, attached])
    fields[n:, k:] = np.eye(ports)
    return fields, u.shape[1], phi.shape[1]


def _orthonormal(columns: Floats) -> Floats:
    """Return an orthonormal basis of what columns span, each counted alike."""
    from scipy.linalg import qr

    sizes = np.linalg.norm(columns, axis=0)
    columns = columns[:, sizes > 0.0] / sizes[sizes > 0.0]
    if columns.shape[1] == 0:
        return columns
    q, r, _ = qr(columns, mode="economic", pivoting=True)
    return np.asarray(q[:, np.abs(np.diag(r)) > _NOISE])


def _projected(matrix: Bordered, fields: Floats) -> Numbers:
    """Return fieldsᵀ matrix fields."""
    n = matrix.inner.shape[0]
    inside, ports = fields[:n], fields[n:]
    product = inside.T @ (matrix.inner @ inside)
    across = inside.T @ (matrix.border @ ports)
    product = product + across + across.T + ports.T @ matrix.corner @ ports
    return np.asarray(0.5 * (product + product.T))
