"""Products of Chebyshev polynomials over a box: smooth functions of several ratios, fitted once."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from tactgen.geometry.arrays import Floats, Ints

#: Angle from an end of the range within which a slope is that at the end.
_NEAR = 1e-6


@dataclass(frozen=True)
class Products:
    """Products of polynomials over a range of g variables."""

    low: Floats  #: (g,) Range of the variables
    high: Floats
    powers: Ints  #: (t, g) Degree of each term in each variable

    def unit(self, values: Floats) -> Floats:
        """Variables (..., g) as −1 to 1 over the range, those beyond at its end."""
        return np.asarray(np.clip(self._scaled(values), -1.0, 1.0))

    def __call__(self, values: Floats) -> Floats:
        """Terms (..., t)."""
        angle = np.arccos(self.unit(values))  # T_n(cos θ) = cos n θ
        return np.asarray(np.cos(angle[..., None, :] * self.powers).prod(axis=-1))

    def slope(self, values: Floats, variable: int) -> Floats:
        """Derivatives (..., t) of the terms by one variable, 0 beyond the range."""
        scaled, angle = self._scaled(values), np.arccos(self.unit(values))
        degrees = self.powers
        # T_n' = n sin(n θ)/sin θ; so near the ends it is its limit there, ± n², within 1e-10
        of = np.clip(angle[..., variable, None], _NEAR, np.pi - _NEAR)
        own = degrees[:, variable] * np.sin(degrees[:, variable] * of) / np.sin(of)
        parts = np.cos(angle[..., None, :] * degrees)
        parts[..., variable] = own
        inside = np.abs(scaled[..., variable]) <= 1.0
        scale = 2.0 / (self.high - self.low)[variable]
        return np.asarray(parts.prod(axis=-1) * np.where(inside, scale, 0.0)[..., None])

    def quadratic(self, values: Floats) -> Floats:
        """1, variables and their squares (..., 1 + 2 g) over the range: terms of an error."""
        unit = self.unit(values)
        return np.concatenate([np.ones_like(unit[..., :1]), unit, unit**2], axis=-1)

    def outside(self, values: Floats, by: float = 0.0) -> tuple[int, ...]:
        """Places of the variables (g,) that lie beyond the range, by more than a share of it."""
        most = 1.0 + 2.0 * by + 1e-9
        return tuple(int(i) for i in np.flatnonzero(np.abs(self._scaled(values)) > most))

    def _scaled(self, values: Floats) -> Floats:
        return np.asarray(2.0 * (values - self.low) / (self.high - self.low) - 1.0)


def weighted_powers(weights: Sequence[float], degree: float) -> Ints:
    """Degrees (t, g) of all products whose weighted sum of degrees is not above `degree`.

    An infinite weight leaves its variable out.
    """
    if not weights:
        return np.zeros((1, 0), dtype=int)
    first, rest = weights[0], weights[1:]
    parts = []
    for n in range(int(degree / first + 1e-9) + 1):
        others = weighted_powers(rest, degree - n * first if n else degree)
        parts.append(np.column_stack([np.full(len(others), n), others]))
    return np.concatenate(parts)
