"""A basis that grows by what members of a family have to say, and its products with all terms."""

from __future__ import annotations

from dataclasses import fields, replace

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
from tactgen.fem.piezo.system import Material, SolidSystem
from tactgen.fem.solvers.linear_solver import Factor
from tactgen.geometry.arrays import Bools, Floats, Sparse


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
        moving, stiffness = self._grid.index % 4 != 3, system.stiffness.inner
        self._moving = _Space(moving, stiffness[moving][:, moving])
        self._field = _Space(~moving, -stiffness[~moving][:, ~moving])
        loads = self._grid.gathered(random_loads(bricks, known, system.volts_per_unit))
        self._random = self._grid.spread(system.held_factor.solve(loads))
        none = Shapes.none(bricks.shape)
        rigid = rigid_shapes(bricks) if self.has_ports else none
        self._rigid = int(rigid.moved.shape[-1])
        self._tip = tip_shapes(bricks) if self.has_ports else none
        self._shapes = none
        self._factor: Factor | None = None
        self._means = section_means(bricks, self._motion, none.moved)
        self._own = _own(products, none, none, self._tip)
        self._seen = _seen(products, self._random, none, self._tip)
        lift = self._grid.lift[..., None] if self.has_ports else none.charged
        self._add(Shapes(rigid.moved, lift))

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
        scales = np.append(scale, system.volts_per_unit / self._products.terms.unit)
        states *= scales[self._grid.index % 4, None]
        moved, raised = states[self._moving.at], states[self._field.at]
        forces, charges = self._moving.held(moved), self._field.held(raised)
        size = np.sqrt((moved * forces).sum(axis=0) + (raised * charges).sum(axis=0))
        moving = self._grid.spread(self._moving.take(moved / size, forces / size, least))
        field = self._grid.spread(self._field.take(raised / size, charges / size, least))
        self._add(Shapes(moving.moved, field.charged))

    def measured(self, force: Floats) -> float:
        """Return the squared norm of a force (n, 1) on the unknowns, by the random shapes."""
        seen = self._grid.gathered(self._random).T @ force
        return float((seen**2).mean())

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
            means=self._means,
            section_weights=sections(bricks, self._motion).weights,
            margin=margin,
        )

    def _add(self, new: Shapes) -> None:
        old, self._shapes = self._shapes, self._shapes.joined(new)
        means = section_means(self._products.bricks, self._motion, new.moved)
        self._means = np.concatenate([self._means, means], axis=-1)
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


class _Space:
    """Shapes of displacement, or of potential, orthonormal in an energy.

    Parameters
    ----------
    at : (n,) bool array
        Which unknowns they have.
    matrix : sparse
        The energy's: strain at held potential, or field.

    Attributes
    ----------
    shapes, loads : (m, k) array
        The shapes at their m unknowns, and the loads that hold them.
    """

    def __init__(self, at: Bools, matrix: Sparse) -> None:
        self.at, self._matrix = at, matrix
        self.shapes = self.loads = np.zeros((matrix.shape[0], 0))

    def held(self, states: Floats) -> Floats:
        """Return the loads (m, k) that hold states (m, k)."""
        return np.asarray(self._matrix @ states)

    def take(self, states: Floats, loads: Floats, least: float) -> Floats:
        """Add what is new in states (m, j) of these loads; return it over all unknowns (n, k)."""
        new, held = states, loads
        for _ in range(2):  # twice is enough (Kahan, Parlett)
            known = self.loads.T @ new
            new, held = new - self.shapes @ known, held - self.loads @ known
        energies, vectors = np.linalg.eigh(new.T @ held)
        kept = energies > least**2
        new = new @ (vectors[:, kept] / np.sqrt(energies[kept]))
        new = new - self.shapes @ (self.loads.T @ new)
        held = self.held(new)
        lower = np.linalg.cholesky(new.T @ held)
        new, held = (np.linalg.solve(lower, columns.T).T for columns in (new, held))
        self.shapes, self.loads = np.hstack([self.shapes, new]), np.hstack([self.loads, held])
        full = np.zeros((self.at.size, new.shape[1]))
        full[self.at] = new
        return full


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
