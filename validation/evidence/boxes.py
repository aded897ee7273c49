"""Any box made of boxes, held, loaded and charged anywhere, on the bricks that `solid` uses.

What is solved is :func:`fem.piezo.bricks.brick_matrices`, the assembly that the
model `solid` delivers; only what holds and loads the body is general here, so that problems
with published answers can be stated in a few lines: a case is a value, not a script.

Unknowns are (u_x, u_y, u_z, φ) at the nodes.  What is prescribed is y = T q + g: every value is
free, given, or one of a group that moves together (an electrode that floats).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Literal, TypeAlias

import numpy as np
from scipy import sparse

from tactgen.fem.elements.line_basis import line_matrices
from tactgen.fem.piezo.bricks import brick_matrices
from tactgen.fem.piezo.system import Material
from tactgen.fem.solvers.linear_solver import factorise
from tactgen.geometry.arrays import Bools, Floats, Numbers, Sparse
from tactgen.geometry.bimorph.bricks import Axis, Bricks, Slab
from tactgen.validation.evidence import mesh_levels as fineness
from tactgen.validation.evidence.peers.job import lowest_frequencies as lanczos

#: A value, or a function of the coordinates (x, y, z) in metres.
Profile: TypeAlias = float | Callable[[Floats, Floats, Floats], Floats]
#: A coordinate (m), or a part of an axis; by the axes that are stated a plane, a line or a point.
Span: TypeAlias = float | tuple[float, float]
Place: TypeAlias = dict[str, Span]
_COMPONENTS = "xyzV"
#: brick_matrices speaks of the whole body by a quarter.
_QUARTERS = 4.0
#: Unknowns up to which frequencies are sought without Lanczos.
_DENSE = 300


def graded(breaks: Sequence[float] | Floats, degree: int) -> Axis:
    """Axis with these break points; its degree is that of the level that is solved."""
    return Axis(np.asarray(breaks, dtype=float), fineness.degree(degree))


def even(length: float, intervals: int, degree: int) -> Axis:
    """Axis of equal intervals from 0."""
    return graded(np.linspace(0.0, length, intervals + 1), degree)


@dataclass(frozen=True)
class Condition:
    """Support, tie or load on a plane, line or point: the coordinates (m) that are stated."""

    kind: Literal["held", "together", "load"]
    components: str  # of "xyzV", V the potential
    value: Profile
    where: Place


def held(components: str, value: Profile = 0.0, **where: Span) -> Condition:
    """Components that have a value (m or V): ``held("xy", z=0.0)`` on a plane.

    ``held("z", x=0.0, z=(0.0, 1e-3))`` on a strip of one.
    """
    return Condition("held", components, value, where)


def together(component: str, **where: Span) -> Condition:
    """A component whose value there is unknown, and everywhere the same."""
    return Condition("together", component, 0.0, where)


def load(component: str, value: Profile, **where: Span) -> Condition:
    """Force per area (Pa), or charge per area (C/m²) for V, on a plane; on a line per length."""
    return Condition("load", component, value, where)


@dataclass(frozen=True)
class Box:
    """A body of bricks with all that acts on it (SI)."""

    x: Axis
    y: Axis
    z: Axis
    parts: tuple[tuple[Slab, Material], ...]  # `Slab.region` must be one name per material
    conditions: tuple[Condition, ...] = ()

    def under(self, *conditions: Condition) -> Box:
        """The body with more that acts on it."""
        return replace(self, conditions=(*self.conditions, *conditions))

    def _all(self, kind: str) -> list[Condition]:
        return [condition for condition in self.conditions if condition.kind == kind]

    @cached_property
    def bricks(self) -> Bricks:
        """The grid."""
        slabs = tuple(slab for slab, _ in self.parts)
        return Bricks(self.x, self.y, self.z, slabs, electrode=(0, 1))

    @cached_property
    def unit(self) -> float:
        """Size of the potential's unit (V): both kinds of energy alike."""
        for _, material in self.parts:
            if material.piezo is not None:
                return float(np.sqrt(np.abs(material.c[0, 0] / material.piezo.eps[0, 0])))
        return 1.0

    @cached_property
    def matrices(self) -> tuple[Sparse, Sparse]:
        """Stiffness and mass over all values."""
        known = {slab.region: material for slab, material in self.parts}
        stiffness, mass = brick_matrices(self.bricks, known, self.unit)
        return stiffness / _QUARTERS, mass / _QUARTERS

    @cached_property
    def grid(self) -> tuple[Floats, Floats, Floats]:
        """Coordinates (nx, ny, nz) of the nodes."""
        nodes = (self.x.nodes, self.y.nodes, self.z.nodes)
        x, y, z = np.meshgrid(*nodes, indexing="ij")
        return x, y, z

    def nodes(self, **where: Span) -> Bools:
        """Mask (nx, ny, nz) of the used nodes there."""
        mask = self.bricks.used().copy()
        for name, axis, coordinate in zip("xyz", self.bricks.axes, self.grid, strict=True):
            if name in where:
                wanted = where[name]
                low, high = wanted if isinstance(wanted, tuple) else (wanted, wanted)
                slack = 1e-9 * (axis.breaks[-1] - axis.breaks[0])
                mask &= (coordinate >= low - slack) & (coordinate <= high + slack)
        if not mask.any():
            raise ValueError(f"no node at {where}")
        return mask

    def weights(self, **where: Span) -> Floats:
        """∫ N (nx, ny, nz) over the coordinates that are not stated, or over their part.

        Exact where a part begins and ends at break points.
        """
        lines = []
        for name, axis in zip("xyz", self.bricks.axes, strict=True):
            wanted = where.get(name)
            if wanted is None or isinstance(wanted, tuple):
                lines.append(_line_integral(axis, wanted))
            else:
                lines.append((np.abs(axis.nodes - wanted) < 1e-9 * np.ptp(axis.breaks)) * 1.0)
        return np.asarray(np.einsum("i,j,k->ijk", *lines))

    @cached_property
    def _constraints(self) -> tuple[Sparse, Floats]:
        """T (4 n, m) and g (4 n,) with values in the units of the unknowns."""
        free = np.zeros((*self.bricks.shape, 4), dtype=bool)
        free[self.bricks.used(), :3] = True
        electric = [s.region for s, m in self.parts if m.piezo is not None]
        if electric:
            free[self.bricks.nodes_of(*electric), 3] = True
        given, group, ties = np.zeros(free.shape), np.full(free.shape, -1), self._all("together")
        for number, tie in enumerate(ties):
            group[self.nodes(**tie.where), _COMPONENTS.index(tie.components)] = number
        for hold in self._all("held"):
            mask = self.nodes(**hold.where)
            for at in map(_COMPONENTS.index, hold.components):
                values = _profile(hold.value, *(c[mask] for c in self.grid))
                free[mask, at] = False
                given[mask, at] = values / (self.unit if at == 3 else 1.0)
        loose, member = free.ravel(), group.ravel()
        single = np.flatnonzero(loose & (member < 0))
        tied = np.flatnonzero(loose & (member >= 0))
        rows = np.concatenate([single, tied])
        columns = np.concatenate([np.arange(single.size), single.size + member[tied]])
        shape = (loose.size, single.size + len(ties))
        return sparse.csr_matrix((np.ones(rows.size), (rows, columns)), shape=shape), given.ravel()

    @cached_property
    def _loads(self) -> Floats:
        """All loads as work per value (4 n,); charge counts negatively, as in the matrices."""
        out = np.zeros((*self.bricks.shape, 4))
        for one in self._all("load"):
            at = _COMPONENTS.index(one.components)
            work = self.weights(**one.where) * _profile(one.value, *self.grid)
            out[..., at] += -self.unit * work if at == 3 else work
        return out.ravel()

    def reduced(self, *, shift: float = 0.0) -> tuple[Sparse, Sparse]:
        """Stiffness + shift · mass, and mass, over the unknowns."""
        t, _ = self._constraints
        stiffness, mass = ((t.T @ m @ t).tocsr() for m in self.matrices)
        return (stiffness + shift * mass).tocsr(), mass


def block(axes: tuple[Axis, Axis, Axis], material: Material, *conditions: Condition) -> Box:
    """Box of one material."""
    x, y, z = axes
    slab = Slab("body", (0, x.intervals), (0, y.intervals), (0, z.intervals))
    return Box(x, y, z, ((slab, material),), conditions)


def layered(
    thicknesses: Sequence[float], materials: Sequence[Material], y: Axis, z: Axis, degree: int,
    *conditions: Condition,
) -> Box:  # fmt: skip
    """Box of layers along x, each as thick as stated, one interval for each."""
    parts = tuple(
        (Slab(f"layer{i}", (i, i + 1), (0, y.intervals), (0, z.intervals)), material)
        for i, material in enumerate(materials)
    )
    x = graded(np.concatenate([[0.0], np.cumsum(thicknesses)]), degree)
    return Box(x, y, z, parts, conditions)


@dataclass(frozen=True)
class State:
    """All values of a box, (nx, ny, nz, 4), in m and V, and the loads they need."""

    box: Box
    values: Numbers
    forces: Numbers

    def mean(self, component: str, **where: Span) -> complex:
        """Mean value over a plane, line or point."""
        weights = self.box.weights(**where) * self.box.nodes(**where)
        values = self.values[..., _COMPONENTS.index(component)]
        return complex((weights * values).sum() / weights.sum())

    def force(self, component: str, **where: Span) -> complex:
        """Sum of the forces (N), or the charge (C), that hold the values there."""
        total = self.forces[self.box.nodes(**where), _COMPONENTS.index(component)].sum()
        return complex(-total / self.box.unit if component == "V" else total)


def statics(box: Box) -> State:
    """Solve the box at rest."""
    return harmonic(box, 0.0)


def harmonic(box: Box, frequency: float) -> State:
    """Solve the box at one frequency (Hz); complex where a material is lossy."""
    stiffness, mass = box.matrices
    dynamic = (stiffness - (2.0 * np.pi * frequency) ** 2 * mass).tocsr()
    t, given = box._constraints
    inner = (t.T @ dynamic @ t).tocsr()
    fineness.counted(inner.shape[0])
    right = t.T @ (box._loads - dynamic @ given)
    solved = t @ factorise(inner).solve(np.asarray(right)) + given
    forces = dynamic @ solved - box._loads
    scale = np.array([1.0, 1.0, 1.0, box.unit])
    shape = (*box.bricks.shape, 4)
    return State(box, solved.reshape(shape) * scale, forces.reshape(shape))


def natural_frequencies(box: Box, count: int, *, loose: int = 0, near: float = 0.0) -> Floats:
    """Lowest `count` natural frequencies (Hz) above the `loose` rigid motions.

    Inverse Lanczos with a factor of K + (2π near)² M: `near` (Hz) must be above 0 where the body
    can move rigidly.
    """
    if fineness.counted(box.reduced()[0].shape[0]) <= _DENSE:
        return _dense_frequencies(box, count, loose)
    shift = (2.0 * np.pi * near) ** 2
    stiffness, mass = box.reduced(shift=shift)
    return lowest_frequencies(stiffness, mass, count + loose, shift)[loose:]


def lowest_frequencies(stiffness: Sparse, mass: Sparse, count: int, shift: float = 0.0) -> Floats:
    """Lowest frequencies (Hz), of a `stiffness` with `shift` times the mass in it."""
    n = stiffness.shape[0]
    return np.array(lanczos(
        factorise(stiffness).solve, lambda v: np.asarray(mass @ v), n, count, shift=shift,
        basis=min(n, max(2 * count + 1, 20)), tolerance=1e-10,
    ))  # fmt: skip


def _dense_frequencies(box: Box, count: int, loose: int) -> Floats:
    """Frequencies of a small box by dense matrices; the potential is eliminated."""
    from scipy.linalg import eigh

    stiffness, mass = (m.toarray() for m in box.reduced())
    light = np.diag(mass) == 0.0
    heavy = ~light
    across = stiffness[np.ix_(light, heavy)]
    inner = np.linalg.solve(stiffness[np.ix_(light, light)], across)
    values = eigh(
        stiffness[np.ix_(heavy, heavy)] - across.T @ inner,
        mass[np.ix_(heavy, heavy)],
        eigvals_only=True,
    )
    # a rigid motion's ω² may be rounded below zero
    return np.asarray(np.sqrt(np.maximum(values, 0.0))[loose : loose + count] / (2.0 * np.pi))


def _profile(value: Profile, x: Floats, y: Floats, z: Floats) -> Floats:
    return np.broadcast_to(value(x, y, z) if callable(value) else value, x.shape)


def _line_integral(axis: Axis, part: tuple[float, float] | None) -> Floats:
    """∫ N_i along an axis, or along a part of it between break points."""
    first, last = 0, axis.intervals
    if part is not None:
        first, last = (int(np.abs(axis.breaks - end).argmin()) for end in part)
    line = line_matrices(axis, first, last)
    sums = np.bincount(line.rows, line.integrals[0, 0], minlength=axis.nodes.size)
    return np.asarray(sums, dtype=float)
