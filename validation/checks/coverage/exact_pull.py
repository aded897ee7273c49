"""The pull of the reluctance network itself: no map between, its ladder finer."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from tactgen.geometry.arrays import Floats
from tactgen.geometry.device.parameters import Device
from tactgen.tmm.reluctance.coenergy.map import Samples
from tactgen.tmm.reluctance.map_range import map_grid
from tactgen.tmm.reluctance.network import network_samples

#: Step of differences, relative; with those of order four they keep some eight digits.
_STEP = 2e-3


@dataclass(frozen=True)
class ExactPull:
    """What a co-energy map says, solved at each point; currents (A) above 0, gaps in m.

    Attributes
    ----------
    cells : int
        Of the network's ladder.
    """

    device: Device
    cells: int

    @property
    def gap_limits(self) -> tuple[float, float]:
        """Those of the map."""
        gaps = map_grid(self.device)[1]
        return float(gaps.min()), float(gaps.max())

    def samples(self, currents: Floats, gaps: Floats) -> Samples:
        """Return the samples of currents (c,) at gaps (m,)."""
        return network_samples(self.device, currents, gaps, cells=self.cells)

    def force(self, current: Floats | float, gap: Floats | float) -> Floats:
        """Return the pull (N)."""
        return self._at(current, gap, "force")

    def incremental_inductance(self, current: Floats | float, gap: Floats | float) -> Floats:
        """Return ∂λ/∂i (H)."""
        return self._at(current, gap, "incremental_inductance")

    def force_gradient(self, current: Floats | float, gap: Floats | float) -> Floats:
        """Return ∂F/∂g (N/m)."""
        return _slope(lambda g: self.force(current, g), gap)

    def motional_coefficient(self, current: Floats | float, gap: Floats | float) -> Floats:
        """Return ∂λ/∂g = −∂F/∂i (N/A)."""
        return _slope(lambda g: self._at(current, g, "flux_linkage"), gap)

    def _at(self, current: Floats | float, gap: Floats | float, name: str) -> Floats:
        currents, gaps = np.broadcast_arrays(*np.atleast_1d(current, gap))
        some, which = np.unique(currents, return_inverse=True)
        places, where = np.unique(gaps, return_inverse=True)
        found = getattr(self.samples(some, places), name)[which.ravel(), where.ravel()]
        return np.asarray(found.reshape(np.broadcast(current, gap).shape))


def _slope(of: Callable[[Floats], Floats], at: Floats | float) -> Floats:
    """Return the central difference of order four."""
    x = np.asarray(at, dtype=float)
    h = _STEP * x
    near, far = of(x + h) - of(x - h), of(x + 2.0 * h) - of(x - 2.0 * h)
    return np.asarray((8.0 * near - far) / (12.0 * h))
