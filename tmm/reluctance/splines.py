"""B-spline bases as plain polynomials per span: values, derivatives, exact integrals.

C. de Boor, A Practical Guide to Splines (Springer 1978), ch. IX-X.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from tactgen.geometry.arrays import Floats
from tactgen.geometry.store.values import storable


@storable
@dataclass(frozen=True)
class SplineBasis:
    """n functions, each a polynomial on every one of s spans.

    Attributes
    ----------
    breaks : (s + 1,) float
        Ends of the spans, increasing.
    coefficients : (s, n, p + 1) float
        Of the powers of x − breaks[span].
    """

    breaks: Floats
    coefficients: Floats

    def __call__(self, x: Floats, derivative: int = 0) -> Floats:
        """Return the functions or a derivative of them at `x` (...,), shape (..., n)."""
        x = np.asarray(x, dtype=float)
        span = np.searchsorted(self.breaks[1:-1], x, side="right")
        c, s = self.coefficients[span], (x - self.breaks[span])[..., None]
        degree = c.shape[-1] - 1
        value = np.zeros(c.shape[:-1])
        for k in range(degree, derivative - 1, -1):
            value = value * s + math.perm(k, derivative) * c[..., k]
        return value

    def integral(self) -> SplineBasis:
        """Return the integrals of the functions from the first break."""
        powers = np.arange(1, self.coefficients.shape[-1] + 1)
        grown = np.concatenate(
            [np.zeros_like(self.coefficients[..., :1]), self.coefficients / powers], axis=-1
        )
        width = np.diff(self.breaks)[:, None, None] ** np.arange(grown.shape[-1])
        whole = (grown * width).sum(axis=-1)
        grown[1:, :, 0] = np.cumsum(whole, axis=0)[:-1]
        return SplineBasis(self.breaks, grown)


def b_splines(breaks: Floats, degree: int) -> SplineBasis:
    """Return the s + `degree` B-splines on `breaks` (s + 1,), which sum to 1.

    All are ≥ 0, so a sum of them with coefficients ≥ 0 is so too; they are `degree` − 1
    times continuously differentiable.
    """
    breaks = np.asarray(breaks, dtype=float)
    spans = breaks.size - 1
    knots = np.concatenate([np.repeat(breaks[:1], degree), breaks, np.repeat(breaks[-1:], degree)])
    # degree 0: function j is 1 on the span between knots j and j + 1
    c = np.zeros((spans, knots.size - 1, 1))
    c[np.arange(spans), degree + np.arange(spans), 0] = 1.0
    for d in range(1, degree + 1):
        higher = np.zeros((spans, knots.size - 1 - d, d + 1))
        for j in range(knots.size - 1 - d):
            for one, first, last, sign in ((j, j, j + d, 1.0), (j + 1, j + d + 1, j + 1, -1.0)):
                width = abs(knots[last] - knots[first])
                if width > 0.0:
                    # (x − t_first) / width, rising or falling, times the lower function
                    higher[:, j, 1:] += sign * c[:, one] / width
                    offset = sign * (breaks[:-1] - knots[first])[:, None]
                    higher[:, j, :-1] += offset * c[:, one] / width
        c = higher
    return SplineBasis(breaks, c)
