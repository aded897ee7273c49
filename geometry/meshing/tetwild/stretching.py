"""A map of z under which a slender body becomes stout, so that its elements can be slender.

The mesher only makes elements that are about as long as wide.  Given the squeezed body it
does so there; put back, they are longer along z.  Planes along z, planes across it and
cylinders about it stay what they are.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tactgen.geometry.arrays import Floats

#: Points of the table that stands for the map between two stops: it is then its own exact
#: inverse, whatever the map.
_POINTS = 401


@dataclass(frozen=True)
class Stretching:
    """Squeezes z between two stops, less and less towards each of them.

    Attributes
    ----------
    low, high : float
        The stops (mm): below and above, and right at them, nothing is squeezed.
    most : float
        Largest length of an element over its width; 1 squeezes nothing.
    growth : float
        How much longer an element may be per distance from a stop (1/mm).
    """

    low: float
    high: float
    most: float
    growth: float

    def squeezed(self, points: Floats) -> Floats:
        """Return points (n, 3) in mm as the mesher gets to see them."""
        z, image = self._table()
        return _with_z(points, _mapped(points[:, 2], z, image))

    def restored(self, points: Floats) -> Floats:
        """Return squeezed points (n, 3) in mm put back."""
        z, image = self._table()
        return _with_z(points, _mapped(points[:, 2], image, z))

    def _table(self) -> tuple[Floats, Floats]:
        z = np.linspace(self.low, self.high, _POINTS)
        middle = 0.5 * (z[1:] + z[:-1])
        away = np.minimum(middle - self.low, self.high - middle)
        length = np.minimum(self.most, 1.0 + self.growth * away)
        steps = np.diff(z) / length
        return z, self.low + np.concatenate([[0.0], np.cumsum(steps)])


#: Leaves everything as it is.
UNSTRETCHED = Stretching(low=0.0, high=1.0, most=1.0, growth=0.0)


def _mapped(values: Floats, source: Floats, image: Floats) -> Floats:
    """Interpolate between the tables; beyond them, move along with their ends."""
    inside = np.interp(values, source, image)
    beyond = np.where(values > source[-1], values - source[-1], np.minimum(values - source[0], 0.0))
    return np.asarray(inside + beyond)


def _with_z(points: Floats, z: Floats) -> Floats:
    return np.column_stack([points[:, :2], z])
