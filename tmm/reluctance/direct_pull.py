"""The pull of the reluctance network and its slopes, solved at each point: no map between.

A map misses slopes by up to a tenth where the steel saturates: it is smooth between its samples,
dB/dH is not.  This costs some milliseconds a point.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from tactgen.geometry.arrays import Floats
from tactgen.geometry.device.parameters import Device
from tactgen.tmm.reluctance.circuit import FULL, circuit
from tactgen.tmm.reluctance.flux_ladder import solve

#: Step of differences, relative; with those of order four they keep some eight digits.
STEP = 2e-3
#: Where they are taken, in steps.
_PLACES = np.array([-2.0, -1.0, 1.0, 2.0])


@dataclass(frozen=True)
class DirectPull:
    """What a co-energy map says, solved at each point; currents (A) above 0, gaps in m.

    Attributes
    ----------
    cells : int
        Of the network's ladder.
    gap_limits : (float, float)
        Gaps (m) that are asked for, such as a map's.
    step : float
        Of the differences that the slopes are, relative to the gap.
    """

    device: Device
    cells: int
    gap_limits: tuple[float, float]
    step: float = STEP

    def force(self, current: Floats | float, gap: Floats | float) -> Floats:
        """Return the pull (N)."""
        return self._at(current, gap, "force")

    def incremental_inductance(self, current: Floats | float, gap: Floats | float) -> Floats:
        """Return ∂λ/∂i (H)."""
        return self._at(current, gap, "incremental_inductance")

    def force_gradient(self, current: Floats | float, gap: Floats | float) -> Floats:
        """Return ∂F/∂g (N/m)."""
        place = np.broadcast_arrays(current, gap)[1]
        return _slope(lambda g: self.force(current, g), place, self.step)

    def motional_coefficient(self, current: Floats | float, gap: Floats | float) -> Floats:
        """Return ∂λ/∂g = −∂F/∂i (N/A)."""
        place = np.broadcast_arrays(current, gap)[1]
        return _slope(lambda g: self._at(current, g, "flux_linkage"), place, self.step)

    def _at(self, current: Floats | float, gap: Floats | float, name: str) -> Floats:
        currents, gaps = np.broadcast_arrays(*np.atleast_1d(current, gap))
        some, which = np.unique(currents, return_inverse=True)
        places, where = np.unique(gaps, return_inverse=True)
        solved = solve(circuit(self.device, places, FULL, self.cells), some)
        found = getattr(solved, name)[which.ravel(), where.ravel()]
        return np.asarray(found.reshape(np.broadcast(current, gap).shape))


def _slope(of: Callable[[Floats], Floats], at: Floats | float, step: float) -> Floats:
    """Return the central difference of order four, all its points at once."""
    x = np.asarray(at, dtype=float)
    h = step * x
    further, before, after, furthest = of(x + np.multiply.outer(_PLACES, h))
    return np.asarray((8.0 * (after - before) - (furthest - further)) / (12.0 * h))
