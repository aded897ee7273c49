"""The actuator's field on one grid at two polynomial orders, of which the lower judges the other.

The grid goes along with gap and dimensions as far as its cells can; the ordering of the factors
stays.  What the fields are worth is in :mod:`fem.magnetics.axisymmetric`.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from tactgen.fem.magnetics.axisymmetric_field import MagneticField, solve_field
from tactgen.fem.magnetics.axisymmetric_force import Eggshell
from tactgen.fem.magnetics.axisymmetric_space import Discretisation, discretise, lowered
from tactgen.fem.solvers.newton import Factors
from tactgen.geometry.arrays import Floats, Ints
from tactgen.geometry.device.parameters import Device
from tactgen.geometry.errors import InputError
from tactgen.geometry.reluctance.section_grid import actuator_regions, graded_grid

#: What Newton's method may leave of the field, see :func:`fem.solvers.newton.minimise`: error bars
#: are above 1e-4 of a value; the two orders, of which the lower serves these alone, 1e-2 apart.
_FINE, _COARSE = 1e-8, 1e-6


@dataclass(frozen=True)
class TwoOrders:
    """Discretisation shared by all currents at one gap.

    `nested` are the unknowns of `fine` that are those of `coarse`.
    """

    gap: float
    fine: Discretisation
    coarse: Discretisation
    nested: Ints
    eggshell: Eggshell
    weight: Floats  #: As :meth:`Eggshell.weight` gives it
    fine_factors: Factors
    coarse_factors: Factors


@dataclass(frozen=True)
class Pair:
    """The same field by the lower and by the wanted order."""

    coarse: MagneticField
    fine: MagneticField


class Start(NamedTuple):
    """Potentials (n_dofs,) from which Newton's method starts at both orders."""

    coarse: Floats
    fine: Floats


def two_orders(
    device: Device, gap: float, order: int, refinement: float, outer_radius: float | None = None
) -> TwoOrders:
    """Actuator at a gap (m) on a grid of its own.

    Raises InputError if the order has none below it, or the parts do not fit.
    """
    if order < 2:
        raise InputError(f"order = {order} leaves none below it to estimate errors; use 2 or more")
    regions = actuator_regions(device, gap)
    fine = discretise(graded_grid(regions, outer_radius, refinement=refinement), order)
    coarse, nested = lowered(fine)
    shell = Eggshell(fine)
    return TwoOrders(gap, fine, coarse, nested, shell, shell.weight(fine), Factors(), Factors())


def fitted(model: TwoOrders, device: Device, gap: float) -> TwoOrders | None:
    """Another device, or gap (m), on the same grid; None if it does not reach."""
    grid = model.fine.grid.fitted(actuator_regions(device, gap))
    if grid is None:
        return None
    fine, coarse = (d.on(grid) for d in (model.fine, model.coarse))
    return replace(model, gap=gap, fine=fine, coarse=coarse, weight=model.eggshell.weight(fine))


def from_neighbour(pair: Pair, current: float) -> Start:
    """First-order start of the field at another current (A)."""
    currents = np.array([current])
    return Start(pair.coarse.predicted(currents), pair.fine.predicted(currents))


def solve_pair(model: TwoOrders, current: float, start: Start | None = None) -> Pair:
    """Solve at both orders.

    From nothing, the cheap lower order goes first and starts the wanted one.  From a
    start, the wanted order does; the lower one starts from its own and from what the start
    of the wanted one was off by.
    """
    currents = np.array([current])

    def wanted(start: Floats) -> MagneticField:
        return solve_field(model.fine, currents, start, model.fine_factors, _FINE)

    def lower(start: Floats | None) -> MagneticField:
        return solve_field(model.coarse, currents, start, model.coarse_factors, _COARSE)

    if start is None:
        coarse = lower(None)
        lifted = np.zeros(model.fine.size)
        lifted[model.nested] = coarse.potential
        return Pair(coarse, wanted(lifted))
    fine = wanted(start.fine)
    return Pair(lower(start.coarse + (fine.potential - start.fine)[model.nested]), fine)
