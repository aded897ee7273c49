"""The actuator along a range of its dimensions, gap or current: one grid that moves, warm starts.

On one grid that only stretches, force and flux linkage are smooth functions of a dimension: what
the grid is off by changes as slowly.  Each point starts from the polynomial through the fields
that were solved nearby.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence

import numpy as np

from tactgen.fem.magnetics.axisymmetric import ORDER, FieldPoint, field_point
from tactgen.fem.magnetics.two_orders import Start, TwoOrders, fitted, solve_pair, two_orders
from tactgen.geometry.arrays import Floats
from tactgen.geometry.device.parameters import Device
from tactgen.geometry.errors import InputError
from tactgen.geometry.reluctance.section_grid import OUTER_RADIUS

#: Solved fields that a start is made of, and the largest degree of the polynomial through them.
_NEAR, _DEGREE = 6, 4
#: Fields that are held for it, of half a megabyte each; a table's are all.
_HELD = 150
#: A polynomial whose weights add up to more in size is no start: its fields lie to one side.
_LARGEST_WEIGHTS = 4.0


class FieldPath:
    """Points that differ in a few numbers, on the grid of one device.

    Parameters
    ----------
    device, gap
        Whose grid it is (m).
    order, refinement, outer_radius
        As of :func:`fem.magnetics.axisymmetric.solve_point`.

    Raises InputError as there.
    """

    def __init__(
        self,
        device: Device,
        gap: float,
        *,
        order: int = ORDER,
        refinement: float = 1.0,
        outer_radius: float = OUTER_RADIUS,
    ) -> None:
        self._home = two_orders(device, gap, order, refinement, outer_radius)
        self._places: list[Floats] = []
        self._solved: list[Start] = []  # potentials alone: the tables of a field are large

    def reaches(self, device: Device, gap: float) -> bool:
        """Whether the grid fits another device or gap."""
        return self.fitted(device, gap) is not None

    def fitted(self, device: Device, gap: float) -> TwoOrders | None:
        """Device at a gap (m) on the grid; None if that does not reach."""
        return fitted(self._home, device, gap)

    def at(self, device: Device, current: float, gap: float, place: Floats) -> FieldPoint:
        """Point of a device at a current (A) and gap (m).

        Parameters
        ----------
        place : (k,) float
            What varies, each about from −1 to 1: fields nearby in it make the start.

        Raises
        ------
        InputError
            If the grid does not reach so far, or is too coarse there.
        SolverError
            If the field does not converge.
        """
        model = self.fitted(device, gap)
        if model is None:
            raise InputError(
                f"the grid made for gap = {self._home.gap * 1e3:g} mm does not fit "
                f"gap = {gap * 1e3:g} mm and the sizes there; make the range smaller"
            )
        return self.solved(model, current, place)

    def solved(self, model: TwoOrders, current: float, place: Floats) -> FieldPoint:
        """Point of what :meth:`fitted` gave; as :meth:`at`."""
        pair = solve_pair(model, current, self._start(place))
        del self._places[:-_HELD], self._solved[:-_HELD]
        self._places.append(np.asarray(place, dtype=float))
        self._solved.append(Start(pair.coarse.potential, pair.fine.potential))
        return field_point(model, pair)

    def _start(self, place: Floats) -> Start | None:
        if not self._solved:
            return None
        places = np.array(self._places)
        near = np.argsort(np.linalg.norm(places - place, axis=1))[:_NEAR]
        weights = _weights(places[near], place)
        solved = [self._solved[n] for n in near]
        return Start(
            weights @ np.array([each.coarse for each in solved]),
            weights @ np.array([each.fine for each in solved]),
        )


def _weights(places: Floats, place: Floats) -> Floats:
    """Weights (n,) of values at places (n, k) that give polynomials at `place` exactly.

    Of the highest degree that n places, nearest first, determine.
    """
    varies = (places != place).any(axis=0)
    places, place = places[:, varies], place[varies]
    count, axes = places.shape
    for degree in range(_DEGREE, 0, -1):
        if math.comb(axes + degree, degree) > count:
            continue
        powers = [p for p in itertools.product(range(degree + 1), repeat=axes) if sum(p) <= degree]
        away = np.array([np.prod((places - place) ** p, axis=1) for p in powers])
        there = np.array([float(not any(p)) for p in powers])
        weights = np.linalg.lstsq(away, there, rcond=None)[0]
        exact = np.abs(away @ weights - there).max() < 1e-6
        if exact and np.abs(weights).sum() < _LARGEST_WEIGHTS:
            return np.asarray(weights)
    return np.asarray(np.eye(count)[0])


#: Grids of one fineness that are held, with their factors of some 100 MB; the oldest goes.
_MOST = 3


class FieldWalk:
    """Points of devices, currents and gaps that differ little from one to the next.

    Parameters
    ----------
    refinements : sequence of float
        Of the grids that may be taken, coarsest first.
    accuracy : float
        Force bar over the force above which the next finer grid is taken, if there is one.
    """

    def __init__(self, refinements: Sequence[float], accuracy: float) -> None:
        self._refinements, self._accuracy = tuple(refinements), accuracy
        self._paths: list[list[FieldPath]] = [[] for _ in self._refinements]
        self._places: list[Floats] = []
        self._enough: list[int] = []

    def at(self, device: Device, current: float, gap: float, place: Floats) -> FieldPoint:
        """Point of a device at a current (A) and gap (m).

        The first grid tried is the one that was fine enough at the nearest place.

        Parameters
        ----------
        place : (k,) float
            What varies, each of the order of 1 over the walk: it says which fields are near.

        Raises
        ------
        InputError
            If the parts do not fit at this gap.
        SolverError
            If the field does not converge.
        """
        place = np.asarray(place, dtype=float)
        for level in range(self._first(place), len(self._refinements)):
            found = self._solved(level, device, current, gap, place)
            if found.errors.force <= self._accuracy * abs(found.force):
                break
        self._places.append(place)
        self._enough.append(level)
        return found

    def _first(self, place: Floats) -> int:
        if not self._places:
            return 0
        away = np.linalg.norm(np.array(self._places) - place, axis=1)
        return self._enough[int(np.argmin(away))]

    def _solved(
        self, level: int, device: Device, current: float, gap: float, place: Floats
    ) -> FieldPoint:
        """Solve on the latest grid of a fineness that reaches there, a new one if none does."""
        paths = self._paths[level]
        for path in reversed(paths):
            model = path.fitted(device, gap)
            if model is not None:
                return path.solved(model, current, place)
        del paths[: -_MOST + 1]
        paths.append(FieldPath(device, gap, refinement=self._refinements[level]))
        return paths[-1].at(device, current, gap, place)
