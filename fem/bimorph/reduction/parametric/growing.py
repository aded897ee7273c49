"""A basis that grows by what members of a family have to say, and its products with all terms."""

from __future__ import annotations

from dataclasses import dataclass, fields, replace

import numpy as np

from tactgen.fem.bimorph.reduction.parametric.body import (
    rigid_shapes,
    section_means,
    sections,
    tip_shapes,
)
from tactgen.fem.bimorph.reduction.parametric.products import Shapes, TermProducts
from tactgen.fem.bimorph.reduction.parametric.reduced import BasisTerms, RandomTerms, ReducedMotion
from tactgen.fem.bimorph.reduction.parametric.sketch import random_loads
from tactgen.fem.bimorph.reduction.parametric.snapshot import Grid, answers
from tactgen.fem.bimorph.system import Material, SolidSystem
from tactgen.fem.solvers.linear_solver import Factor, factorise
from tactgen.geometry.arrays import Bools, Floats, Ints, Sparse


class GrowingBasis:
    """The basis of one class of motion on one division.

    Parameters
    ----------
    products : TermProducts
        Of the family's terms.
    system : SolidSystem
        The undivided member in this class of motion; its energy is the inner product.
    known : dict of str to Material
        The undivided member's materials.
    modes : int
        Modes of each member that the basis is to contain.

    Attributes
    ----------
    has_ports : bool
        Whether base, tip and electrodes take part in the motion.
    """

    def __init__(
        self, products: TermProducts, system: SolidSystem, known: dict[str, Material], modes: int
    ) -> None:
        bricks = products.bricks
        self._products, self._motion = products, system.motion
        self.has_ports = system.has_ports
        # a load and an open circuit each lift a mode past one other
        self._modes = modes + 2 * self.has_ports
        self._grid = Grid.of(bricks, system)
        self._energy = _Energy.of(self._grid, system)
        self._random = self._energy.compliance(
            self._grid, random_loads(bricks, known, system.volts_per_unit)
        )
        none = Shapes.none(bricks.shape)
        rigid = rigid_shapes(bricks) if self.has_ports else none
        self._rigid = int(rigid.moved.shape[-1])
        self._tip = tip_shapes(bricks) if self.has_ports else none
        self._shapes = none
        self._factor: Factor | None = None
        # displacements and potentials of the basis as states of the unknowns
        self._moving = self._field = np.zeros((self._grid.index.size, 0))
        self._own = _own(products, none, none, self._tip)
        self._seen = _seen(products, self._random, none, self._tip)
        lift = self._grid.lift[..., None] if self.has_ports else none.charged
        self._add(Shapes(rigid.moved, lift))

    @property
    def size(self) -> int:
        """Number of displacements in the basis."""
        return int(self._moving.shape[1])

    @property
    def unknowns(self) -> int:
        """Number of unknowns of a member."""
        return int(self._grid.index.size)

    def learn(
        self, system: SolidSystem, scale: Floats, least: float, lossy: SolidSystem | None = None
    ) -> None:
        """Take in what a member has to say.

        Parameters
        ----------
        system : SolidSystem
            The member in this class of motion.
        scale : (3,) array
            Its stretches g.
        least : float
            Root of the share of energy below which what is new is left out.
        lossy : SolidSystem, optional
            The member with losses, if these are to be served.
        """
        # the next mode tells how far the last one may be off
        if self._factor is None:
            self._factor = system.held_factor
        else:
            system.take_factor(self._factor)
        states = answers(system, self._modes + 1, lossy)
        found = self._grid.spread(states)
        moved = found.moved * scale[:, None, None, None, None]
        charged = found.charged * system.volts_per_unit / self._products.terms.unit
        flat = self._grid.gathered(Shapes(moved, charged))
        flat = flat / self._energy.size(flat)
        moving = self._energy.fresh(self._moving, flat, least, moving=True)
        field = self._energy.fresh(self._field, flat, least, moving=False)
        self._moving = np.hstack([self._moving, moving])
        self._field = np.hstack([self._field, field])
        self._add(Shapes(self._grid.spread(moving).moved, self._grid.spread(field).charged))

    def norms(self, force: Floats) -> tuple[float, float]:
        """Return the squared norm of a force (n, 1) on the unknowns: exactly, and by the sketch."""
        exact = float((force * self._energy.solve(force)).sum())
        seen = self._grid.gathered(self._random).T @ force
        return exact, float((seen**2).mean())

    def frozen(self, margin: float) -> ReducedMotion:
        """Return the family on the basis as it is."""
        bricks = self._products.bricks
        return ReducedMotion(
            motion=self._motion,
            has_ports=self.has_ports,
            modes=self._modes,
            rigid=self._rigid,
            basis=self._own,
            random=self._seen,
            means=section_means(bricks, self._motion, self._shapes.moved),
            section_weights=sections(bricks, self._motion).weights,
            margin=margin,
        )

    def _add(self, new: Shapes) -> None:
        old, self._shapes = self._shapes, self._shapes.joined(new)
        columns = _own(self._products, self._shapes, new, self._tip)
        below = self._products.coupling(new, old)
        known = self._own
        self._own = BasisTerms(
            elastic=_bordered(known.elastic, columns.elastic),
            coupling=np.concatenate(
                [np.concatenate([known.coupling, below], axis=1), columns.coupling], axis=2
            ),
            dielectric=_bordered(known.dielectric, columns.dielectric),
            inertial=_bordered(known.inertial, columns.inertial),
            tip=np.concatenate([known.tip, columns.tip], axis=1),
        )
        seen = _seen(self._products, self._random, new, self._tip)
        joined = {
            f.name: np.concatenate([getattr(self._seen, f.name), getattr(seen, f.name)], axis=-1)
            for f in fields(RandomTerms)
            if f.name != "tip"
        }
        self._seen = replace(self._seen, **joined)


@dataclass(frozen=True)
class _Energy:
    """Strain energy at held potential beside field energy: the inner product of the basis."""

    moving: Bools
    stiffness: Sparse
    permittivity: Sparse
    elimination: Ints

    @classmethod
    def of(cls, grid: Grid, system: SolidSystem) -> _Energy:
        moving = grid.index % 4 != 3
        inner = system.stiffness.inner
        assert system.elimination is not None
        field = -inner[~moving][:, ~moving]
        return cls(moving, inner[moving][:, moving], field, system.elimination)

    def compliance(self, grid: Grid, loads: Shapes) -> Shapes:
        """Return the shapes that loads cause."""
        return grid.spread(self.solve(grid.gathered(loads)))

    def solve(self, loads: Floats) -> Floats:
        """Return the states (n, k) that loads cause, displacements and potentials apart."""
        flat = loads.copy()
        for part, matrix in ((self.moving, self.stiffness), (~self.moving, self.permittivity)):
            if part.any():
                order = (np.cumsum(part) - 1)[self.elimination[part[self.elimination]]]
                factor = factorise(matrix.tocsr(), definite=True, order=order)
                flat[part] = factor.solve(flat[part])
        return flat

    def size(self, states: Floats) -> Floats:
        """Return the root of the energy of states (n, k)."""
        u, p = states[self.moving], states[~self.moving]
        energy = (u * (self.stiffness @ u)).sum(axis=0) + (p * (self.permittivity @ p)).sum(axis=0)
        return np.asarray(np.sqrt(energy))

    def fresh(self, basis: Floats, states: Floats, least: float, *, moving: bool) -> Floats:
        """Return an orthonormal basis of what is new in one part of states (n, m)."""
        at = self.moving if moving else ~self.moving
        matrix = self.stiffness if moving else self.permittivity
        known, new = basis[at], states[at]
        out = np.zeros((states.shape[0], 0))
        if not at.any():
            return out
        for _ in range(2):  # twice is enough (Kahan, Parlett)
            new = new - known @ (known.T @ (matrix @ new))
        values, vectors = np.linalg.eigh(new.T @ (matrix @ new))
        kept = values > least**2
        new = new @ (vectors[:, kept] / np.sqrt(values[kept]))
        new = new - known @ (known.T @ (matrix @ new))
        lower = np.linalg.cholesky(new.T @ (matrix @ new))
        out = np.zeros((states.shape[0], new.shape[1]))
        out[at] = np.linalg.solve(lower, new.T).T
        return out


def _own(of: TermProducts, left: Shapes, right: Shapes, tip: Shapes) -> BasisTerms:
    """Return the products of all terms with shapes on both sides."""
    return BasisTerms(
        elastic=of.elastic(left, right),
        coupling=of.coupling(left, right),
        dielectric=of.dielectric(left, right),
        inertial=of.inertial(left, right),
        tip=_work(tip, right),
    )


def _seen(of: TermProducts, random: Shapes, right: Shapes, tip: Shapes) -> RandomTerms:
    """Return the products of all terms with random shapes on the left."""
    return RandomTerms(
        elastic=of.elastic(random, right),
        coupling=of.coupling(random, right),
        displacing=np.swapaxes(of.coupling(right, random), 1, 2),
        dielectric=of.dielectric(random, right),
        inertial=of.inertial(random, right),
        tip=_work(tip, random),
    )


def _work(loads: Shapes, shapes: Shapes) -> Floats:
    """Return the work (loads, k) of loads on displacements."""
    every = [0, 1, 2, 3]
    return np.asarray(np.tensordot(loads.moved, shapes.moved, (every, every)))


def _bordered(known: Floats, columns: Floats) -> Floats:
    """Return symmetric matrices (terms, l, l) with new columns (terms, l + m, m), rows alike."""
    size = known.shape[1]
    top = np.concatenate([known, columns[:, :size]], axis=2)
    below = np.concatenate([np.swapaxes(columns[:, :size], 1, 2), columns[:, size:]], axis=2)
    return np.concatenate([top, below], axis=1)
