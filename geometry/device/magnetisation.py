"""Magnetisation curve H(B) of the iron, with its energy.

Reads top to bottom like the interpolation: the monotone cubic through the table, its
slope, its exact integral, its inverse, the curves.  No hysteresis, no remanence, no
field problem.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from tactgen.geometry.arrays import Floats, Ints
from tactgen.geometry.errors import InputError

#: Permeability of vacuum (H/m), CODATA 2018; equal to 4e-7 π to 1e-9.
MU0 = 1.25663706212e-6

#: A table whose last step still rises this many times as fast as what comes after it ends
#: before the steel is saturated.
_EARLY = 2.0
#: Steps of Newton's method, of which bisection alone would need 53, and the relative change after
#: which nothing but rounding is left.
_MOST_STEPS, _SETTLED = 100, 4.0 * float(np.finfo(float).eps)


@dataclass(frozen=True)
class MagnetisationCurve:
    """A single-valued isotropic magnetisation curve: B and H parallel, H(B) increasing.

    Between the points H(B) is the monotone piecewise cubic of Fritsch and Butland,
    SIAM J. Sci. Stat. Comput. 5 (1984) 300 (the "pchip" of Kahaner, Moler and Nash);
    beyond the last point it is straight.  Energies are exact integrals of that same
    function, so forces from energy and from stress belong to one material.

    All methods take magnitudes |B| or |H| ≥ 0, arrays of any shape.

    Parameters
    ----------
    flux_density, field : (n,) float
        Points of the curve, from (0, 0), both strictly increasing (T, A/m).
    slope_beyond : float
        dH/dB above the last point (m/H); vacuum's by default, which is saturation.
    name : str
        What reports call it.
    """

    flux_density: Floats
    field: Floats
    slope_beyond: float = 1.0 / MU0
    name: str = "steel"

    @property
    def ends_early(self) -> bool:
        """Whether the table ends before saturation.

        What lies beyond is then no longer this steel's: it is taken for saturated too soon.
        """
        (b_before, b), (h_before, h) = self.flux_density[-2:], self.field[-2:]
        return bool(self.slope_beyond * (b - b_before) > _EARLY * (h - h_before))

    @cached_property
    def _cubics(self) -> tuple[Floats, Floats]:
        """Coefficients (4, n) of H in powers of B − B_i, and energy (n,) at the points.

        The last column is the straight line beyond the table.
        """
        b, h = self.flux_density, self.field
        slopes = _monotone_slopes(b, h)
        width, secant = np.diff(b), np.diff(h) / np.diff(b)
        second = (3.0 * secant - 2.0 * slopes[:-1] - slopes[1:]) / width
        third = (slopes[:-1] + slopes[1:] - 2.0 * secant) / width**2
        inside = np.stack([h[:-1], slopes[:-1], second, third])
        beyond = np.array([[h[-1]], [self.slope_beyond], [0.0], [0.0]])
        pieces = _integral(inside, width)
        energy = np.concatenate([[0.0], np.cumsum(pieces)])
        return np.concatenate([inside, beyond], axis=1), energy

    def _piece(self, b: Floats) -> tuple[Floats, Floats, Ints]:
        """Coefficients (4, ...), distance from the left point, number of that point."""
        b = np.asarray(b, dtype=float)
        # searching the inner points only sends all b ≥ 0 to a valid piece
        i = np.searchsorted(self.flux_density[1:], b, side="right")
        return np.take(self._cubics[0], i, axis=1), b - np.take(self.flux_density, i), i

    def field_strength(self, b: Floats) -> Floats:
        """H (A/m) at flux density `b` (T)."""
        c, s, _ = self._piece(b)
        return np.asarray(c[0] + s * (c[1] + s * (c[2] + s * c[3])))

    def slope(self, b: Floats) -> Floats:
        """DH/dB (m/H) at flux density `b` (T)."""
        c, s, _ = self._piece(b)
        return np.asarray(c[1] + s * (2.0 * c[2] + s * 3.0 * c[3]))

    def reluctivity(self, b: Floats) -> Floats:
        """H/B (m/H) at flux density `b` (T), its limit dH/dB at b = 0."""
        b = np.asarray(b, dtype=float)
        # the first piece starts at (0, 0): dividing its polynomial avoids 0/0
        c, s, _ = self._piece(b)
        safe = np.where(b > 0.0, b, 1.0)
        first = c[1] + s * (c[2] + s * c[3])
        other = (c[0] + s * first) / safe
        return np.asarray(np.where(b < self.flux_density[1], first, other))

    def energy_density(self, b: Floats) -> Floats:
        """∫₀ᴮ H dB (J/m³) at flux density `b` (T)."""
        c, s, i = self._piece(b)
        return np.asarray(self._cubics[1][i] + _integral(c, s))

    def coenergy_density(self, b: Floats) -> Floats:
        """H·B − ∫H dB (J/m³) at flux density `b` (T)."""
        return np.asarray(b) * self.field_strength(b) - self.energy_density(b)

    @property
    def highest_permeability(self) -> float:
        """The largest B/(µ0 H) of the table."""
        return float(np.max(self.flux_density[1:] / self.field[1:]) / MU0)

    def volume_beyond(self, b: Floats, volumes: Floats) -> float:
        """Volume (m³) with `b` (T) beyond the end of a short table."""
        return float(volumes[b > self.flux_density[-1]].sum()) if self.ends_early else 0.0

    def flux_density_at(self, h: Floats) -> Floats:
        """B (T) at field strength `h` (A/m), the inverse of :meth:`field_strength`.

        Newton's method kept inside a shrinking bracket; to rounding.
        """
        h = np.asarray(h, dtype=float)
        inside = np.minimum(h, self.field[-1])
        i = np.searchsorted(self.field[1:-1], inside, side="right")
        low, high = self.flux_density[i], self.flux_density[i + 1]
        b = np.interp(inside, self.field, self.flux_density)
        for _ in range(_MOST_STEPS):
            miss = self.field_strength(b) - inside
            low, high = np.where(miss < 0.0, b, low), np.where(miss < 0.0, high, b)
            slope = self.slope(b)
            step = b - miss / np.where(slope > 0.0, slope, np.inf)
            within = (step >= low) & (step <= high)
            new = np.where(miss == 0.0, b, np.where(within, step, 0.5 * (low + high)))
            settled = np.all(np.abs(new - b) <= _SETTLED * b)
            b = new
            if settled:
                break
        return np.asarray(b + (h - inside) / self.slope_beyond)


def _integral(c: Floats, s: Floats) -> Floats:
    """∫₀ˢ of the cubics with coefficients `c` (4, ...)."""
    return np.asarray(s * (c[0] + s * (c[1] / 2.0 + s * (c[2] / 3.0 + s * c[3] / 4.0))))


def _monotone_slopes(x: Floats, y: Floats) -> Floats:
    """Slopes (n,) at the points that keep the cubic between them increasing.

    Inside: the weighted harmonic mean of the neighbouring secants (Fritsch and Butland
    1984).  First point: the same mean with the mirrored point, H(B) being odd; so the
    permeability stays finite at the origin.  Last point: the one-sided three-point
    formula, held between 0 and three times the end secant, the bound of Fritsch and
    Carlson, SIAM J. Numer. Anal. 17 (1980) 238.
    """
    width, secant = np.diff(x), np.diff(y) / np.diff(x)
    if x.size == 2:
        return np.repeat(secant, 2)
    left, right = 2.0 * width[1:] + width[:-1], width[1:] + 2.0 * width[:-1]
    inside = (left + right) / (left / secant[:-1] + right / secant[1:])

    one_sided = ((2.0 * width[-1] + width[-2]) * secant[-1] - width[-1] * secant[-2]) / (
        width[-1] + width[-2]
    )
    last = np.clip(one_sided, 0.0, 3.0 * secant[-1])
    return np.concatenate([secant[:1], inside, [last]])


def linear(relative_permeability: float) -> MagnetisationCurve:
    """Straight curve B = µ0 µr H.

    Raises InputError if `relative_permeability` is not a finite number of at least 1.
    """
    if not (math.isfinite(relative_permeability) and relative_permeability >= 1.0):
        raise InputError(
            f"steel.relative_permeability = {relative_permeability:g} is not that of iron; "
            "use a number of at least 1"
        )
    slope = 1.0 / (MU0 * relative_permeability)
    return MagnetisationCurve(
        np.array([0.0, 1.0]),
        np.array([0.0, slope]),
        slope_beyond=slope,
        name=f"linear, relative permeability {relative_permeability:g}",
    )


#: Steel of the TEAM Workshop (COMPUMAG), problem 20, "3-D static force problem": the points
#: of its magnetisation curve up to 2.3 T.
TEAM20 = MagnetisationCurve(
    np.array([
        0.0, 0.01, 0.025, 0.05, 0.1, 0.15, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 1.0, 1.1,
        1.2, 1.3, 1.35, 1.4, 1.45, 1.5, 1.55, 1.6, 1.65, 1.7, 1.75, 1.8, 1.85, 1.9, 1.95,
        2.0, 2.05, 2.1, 2.15, 2.2, 2.25, 2.3,
    ]),
    np.array([
        0.0, 27.0, 58.0, 100.0, 153.0, 185.0, 205.0, 233.0, 255.0, 285.0, 320.0, 355.0, 405.0,
        470.0, 555.0, 673.0, 836.0, 1065.0, 1220.0, 1420.0, 1720.0, 2130.0, 2670.0, 3480.0,
        4500.0, 5950.0, 7650.0, 10100.0, 13000.0, 15900.0, 21100.0, 26300.0, 32900.0, 42700.0,
        61700.0, 84300.0, 110000.0, 135000.0,
    ]),
    name="TEAM problem 20 steel",
)  # fmt: skip
