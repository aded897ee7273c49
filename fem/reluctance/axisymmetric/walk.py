"""Fields one after another, each on a grid that is there and from the fields solved nearby.

As many grids as it takes: where none reaches, or all are too coarse, the next begins.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from tactgen.fem.reluctance.axisymmetric.actuator import FieldPoint
from tactgen.fem.reluctance.axisymmetric.path import FieldPath
from tactgen.geometry.arrays import Floats
from tactgen.geometry.device.parameters import Device

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
        """Return the point of a device at a current (A) and gap (m).

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
