"""Mutual inductance and axial force of coaxial ring windings by Maxwell's elliptic integrals.

J. C. Maxwell, A Treatise on Electricity and Magnetism, vol. 2, art. 701; filaments
spread over both sections by Gauss-Legendre points.
"""

from __future__ import annotations

import numpy as np
from scipy.special import ellipe, ellipk

from geometry.steel import MU0


def mutual_inductance(a, b, distance):
    """Return M of two coaxial filaments with radii a, b at an axial distance (H)."""
    m = 4.0 * a * b / ((a + b) ** 2 + distance**2)
    k = np.sqrt(m)
    return MU0 * np.sqrt(a * b) * ((2.0 / k - k) * ellipk(m) - 2.0 / k * ellipe(m))


def mutual_inductance_slope(a, b, distance):
    """Return dM/d(distance) of the same (H/m)."""
    m = 4.0 * a * b / ((a + b) ** 2 + distance**2)
    k = np.sqrt(m)
    bracket = ellipk(m) - (2.0 - m) / (2.0 * (1.0 - m)) * ellipe(m)
    return MU0 * distance * k / (2.0 * np.sqrt(a * b)) * bracket


def between_windings(one, other, function, points=8):
    """Return the mean of a filament function over both sections, times the turns."""
    (r1, z1, w1), (r2, z2, w2) = (_filaments(winding, points) for winding in (one, other))
    values = function(r1[:, None], r2[None, :], z2[None, :] - z1[:, None])
    return one.turns * other.turns * float(w1 @ values @ w2)


def _filaments(winding, points):
    x, w = np.polynomial.legendre.leggauss(points)
    (r0, r1), (z0, z1) = winding.radii, winding.heights
    r, z = np.meshgrid((r0 + r1 + (r1 - r0) * x) / 2.0, (z0 + z1 + (z1 - z0) * x) / 2.0)
    return r.ravel(), z.ravel(), np.outer(w, w).ravel() / 4.0
