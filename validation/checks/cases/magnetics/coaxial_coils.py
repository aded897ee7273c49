"""Two coaxial ring windings in air: inductance and force by Maxwell's elliptic integrals.

J. C. Maxwell, A Treatise on Electricity and Magnetism, vol. 2, art. 701; filaments
spread over both sections by Gauss-Legendre points.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from tactgen.fem.magnetics.axisymmetric_field import MagneticField, solve_field
from tactgen.fem.magnetics.axisymmetric_space import discretise
from tactgen.geometry.arrays import Floats
from tactgen.geometry.device.steel_law import MU0
from tactgen.geometry.reluctance.section_grid import Region, graded_grid
from tactgen.validation.checks.cases.fineness import cached, counted, degree

LOW = Region("low", (0.04, 0.05), (-0.02, -0.005), turns=100.0)
HIGH = Region("high", (0.03, 0.045), (0.01, 0.02), turns=50.0, moves=True)
#: Currents (A) at which the force is compared.
CURRENTS = (2.0, 3.0)


def mutual_inductance(a: Floats, b: Floats, distance: Floats) -> Floats:
    """Return M of two coaxial filaments with radii a, b at an axial distance (H)."""
    from scipy.special import ellipe, ellipk

    m = 4.0 * a * b / ((a + b) ** 2 + distance**2)
    k = np.sqrt(m)
    return np.asarray(
        MU0 * np.sqrt(a * b) * ((2.0 / k - k) * ellipk(m) - 2.0 / k * ellipe(m)), dtype=float
    )


def mutual_inductance_slope(a: Floats, b: Floats, distance: Floats) -> Floats:
    """Return dM/d(distance) of the same (H/m)."""
    from scipy.special import ellipe, ellipk

    m = 4.0 * a * b / ((a + b) ** 2 + distance**2)
    k = np.sqrt(m)
    bracket = ellipk(m) - (2.0 - m) / (2.0 * (1.0 - m)) * ellipe(m)
    return np.asarray(MU0 * distance * k / (2.0 * np.sqrt(a * b)) * bracket, dtype=float)


def between_windings(
    one: Region,
    other: Region,
    function: Callable[[Floats, Floats, Floats], Floats],
    points: int = 8,
) -> float:
    """Return the mean of a filament function over both sections, times the turns."""
    (r1, z1, w1), (r2, z2, w2) = (_filaments(winding, points) for winding in (one, other))
    values = function(r1[:, None], r2[None, :], z2[None, :] - z1[:, None])
    return one.turns * other.turns * float(w1 @ values @ w2)


def _filaments(winding: Region, points: int) -> tuple[Floats, Floats, Floats]:
    x, w = np.polynomial.legendre.leggauss(points)
    (r0, r1), (z0, z1) = winding.radii, winding.heights
    r, z = np.meshgrid((r0 + r1 + (r1 - r0) * x) / 2.0, (z0 + z1 + (z1 - z0) * x) / 2.0)
    return r.ravel(), z.ravel(), np.outer(w, w).ravel() / 4.0


@cached
def solved() -> MagneticField:
    """Return the field of both coils, walls at eighty times their radius."""
    space = discretise(graded_grid((LOW, HIGH), 4.0, refinement=2.0), degree(4))
    counted(space.size)
    return solve_field(space, np.array(CURRENTS))
