"""What the iron does: its magnetisation curve H(B), with the energy of the same curve.

Reads top to bottom like the interpolation: the monotone cubic through the table, its
slope, its exact integral, its inverse, the curves.  No hysteresis, no remanence, no
field problem.
"""

from __future__ import annotations

import csv
import math
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from geometry.arrays import Floats
from geometry.errors import InputError
from geometry.units import quoted

if TYPE_CHECKING:
    from geometry.parameters import Steel

#: Permeability of vacuum (H/m), CODATA 2018; equal to 4e-7 π to 1e-9.
MU0 = 1.25663706212e-6

#: A table may be steeper than vacuum by this much: measured curves are rounded to about 1 %.
_ROUNDING = 0.01

#: The header of a curve file, as messages give it.
_HEADER = '"B (T), H (A/m)"'


@dataclass(frozen=True, eq=False)
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

    @cached_property
    def _cubics(self) -> tuple[Floats, Floats]:
        """Coefficients (n, 4) of H in powers of B − B_i, and energy (n,) at the points.

        The last row is the straight line beyond the table.
        """
        b, h = self.flux_density, self.field
        slopes = _monotone_slopes(b, h)
        width, secant = np.diff(b), np.diff(h) / np.diff(b)
        second = (3.0 * secant - 2.0 * slopes[:-1] - slopes[1:]) / width
        third = (slopes[:-1] + slopes[1:] - 2.0 * secant) / width**2
        inside = np.stack([h[:-1], slopes[:-1], second, third], axis=1)
        beyond = np.array([[h[-1], self.slope_beyond, 0.0, 0.0]])
        pieces = _integral(inside, width)
        energy = np.concatenate([[0.0], np.cumsum(pieces)])
        return np.concatenate([inside, beyond]), energy

    def _piece(self, b: Floats) -> tuple[Floats, Floats, Floats]:
        """Return coefficients (..., 4), distance from the left point, energy at that point."""
        coefficients, energy = self._cubics
        b = np.asarray(b, dtype=float)
        # searching the inner points only sends all b ≥ 0 to a valid piece
        i = np.searchsorted(self.flux_density[1:], b, side="right")
        return coefficients[i], b - self.flux_density[i], energy[i]

    def field_strength(self, b: Floats) -> Floats:
        """Return H (A/m) at flux density `b` (T)."""
        c, s, _ = self._piece(b)
        return c[..., 0] + s * (c[..., 1] + s * (c[..., 2] + s * c[..., 3]))

    def slope(self, b: Floats) -> Floats:
        """Return dH/dB (m/H) at flux density `b` (T)."""
        c, s, _ = self._piece(b)
        return c[..., 1] + s * (2.0 * c[..., 2] + s * 3.0 * c[..., 3])

    def reluctivity(self, b: Floats) -> Floats:
        """Return H/B (m/H) at flux density `b` (T), its limit dH/dB at b = 0."""
        b = np.asarray(b, dtype=float)
        # the first piece starts at (0, 0): dividing its polynomial avoids 0/0
        c, s, _ = self._piece(b)
        safe = np.where(b > 0.0, b, 1.0)
        first = c[..., 1] + s * (c[..., 2] + s * c[..., 3])
        other = (c[..., 0] + s * first) / safe
        return np.where(b < self.flux_density[1], first, other)

    def energy_density(self, b: Floats) -> Floats:
        """Return ∫₀ᴮ H dB (J/m³) at flux density `b` (T)."""
        c, s, energy = self._piece(b)
        return energy + _integral(c, s)

    def coenergy_density(self, b: Floats) -> Floats:
        """Return H·B − ∫H dB (J/m³) at flux density `b` (T)."""
        return np.asarray(b) * self.field_strength(b) - self.energy_density(b)

    def flux_density_at(self, h: Floats) -> Floats:
        """Return B (T) at field strength `h` (A/m), the inverse of :meth:`field_strength`.

        Newton's method kept inside a shrinking bracket; to rounding.
        """
        h = np.asarray(h, dtype=float)
        inside = np.minimum(h, self.field[-1])
        i = np.searchsorted(self.field[1:-1], inside, side="right")
        low, high = self.flux_density[i], self.flux_density[i + 1]
        b = np.interp(inside, self.field, self.flux_density)
        for _ in range(100):  # bisection alone would need 53
            miss = self.field_strength(b) - inside
            low, high = np.where(miss < 0.0, b, low), np.where(miss < 0.0, high, b)
            slope = self.slope(b)
            step = b - miss / np.where(slope > 0.0, slope, np.inf)
            within = (step >= low) & (step <= high)
            new = np.where(miss == 0.0, b, np.where(within, step, 0.5 * (low + high)))
            settled = np.all(np.abs(new - b) <= 4.0 * np.finfo(float).eps * b)
            b = new
            if settled:
                break
        return np.asarray(b + (h - inside) / self.slope_beyond)


def _integral(c: Floats, s: Floats) -> Floats:
    """Return ∫₀ˢ of the cubics with coefficients `c` (..., 4)."""
    whole = s * (c[..., 0] + s * (c[..., 1] / 2.0 + s * (c[..., 2] / 3.0 + s * c[..., 3] / 4.0)))
    return np.asarray(whole)


def _monotone_slopes(x: Floats, y: Floats) -> Floats:
    """Return slopes (n,) at the points that keep the cubic between them increasing.

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
    """Return the straight curve B = µ0 µr H.

    Raises
    ------
    InputError
        If `relative_permeability` is not a finite number of at least 1.
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


def magnetisation_curve(steel: Steel) -> MagnetisationCurve:
    """Return the curve that a device's `steel` names: built in, straight, or from a file.

    Raises
    ------
    InputError
        If the file cannot be used.
    """
    if steel.curve == "team20":
        return TEAM20
    if steel.curve == "linear":
        return linear(steel.relative_permeability)
    return read_curve(steel.curve)


def read_curve(path: str | Path) -> MagnetisationCurve:
    """Read a magnetisation curve from a CSV file with the columns B (T) and H (A/m).

    Lines that start with # are skipped; other columns are ignored.

    Raises
    ------
    InputError
        If the file cannot be read, a column or its unit is missing, or the rows are not
        a magnetisation curve.
    """
    path = Path(path)
    try:
        text = path.read_text(encoding="utf-8-sig")
    except (OSError, UnicodeDecodeError, ValueError) as error:
        reason = (getattr(error, "strerror", None) or "not a text file").lower()
        raise InputError(
            f"steel.curve = {quoted(str(path))} cannot be read ({reason}); use team20, linear, or "
            f"the path of a CSV file with the header {_HEADER}"
        ) from None
    numbered = [
        (number, line)
        for number, line in enumerate(text.splitlines(), start=1)
        if line.strip() and not line.lstrip().startswith("#")
    ]
    if not numbered:
        raise InputError(f"{path} is empty; start it with the header {_HEADER}")
    rows = list(csv.reader(line for _, line in numbered))
    columns = _columns(rows[0], path)
    b, h = (
        np.array([
            _number(row, column, path, number)
            for row, (number, _) in zip(rows[1:], numbered[1:], strict=True)
        ])
        for column in columns
    )  # fmt: skip
    _check(b, h, [number for number, _ in numbered[1:]], path)
    return MagnetisationCurve(b, h, name=path.name)


def _columns(header: list[str], path: Path) -> tuple[int, int]:
    """Return where B (T) and H (A/m) stand."""
    plain = ["".join(c for c in cell.casefold() if c not in " ()[]_") for cell in header]
    found = []
    for letter, units in (("b", ("t", "tesla")), ("h", ("a/m", "aperm", "am^-1"))):
        match = [i for i, cell in enumerate(plain) if cell in {letter + unit for unit in units}]
        if len(match) != 1:
            raise InputError(
                f"{path} has the header {quoted(', '.join(header))}, where B in T and H in A/m "
                f"are not named once each; write {_HEADER}"
            )
        found.append(match[0])
    return found[0], found[1]


def _number(row: list[str], column: int, path: Path, line: int) -> float:
    cell = row[column].strip() if column < len(row) else ""
    try:
        value = float(cell)
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise InputError(
            f"{path} line {line} has {quoted(cell)} where a number is needed; "
            "write plain numbers with a decimal point"
        )
    return value


def _check(b: Floats, h: Floats, lines: list[int], path: Path) -> None:
    """Refuse tables that are no magnetisation curve."""
    if b.size < 2:
        raise InputError(f"{path} has {b.size} rows of numbers; a curve needs at least 2")
    if b[0] != 0.0 or h[0] != 0.0:
        raise InputError(
            f"{path} line {lines[0]} starts at B = {b[0]:g} T, H = {h[0]:g} A/m; "
            "start the curve at 0, 0"
        )
    for values, letter, unit in ((b, "B", "T"), (h, "H", "A/m")):
        falls = np.flatnonzero(np.diff(values) <= 0.0)
        if falls.size:
            i = int(falls[0]) + 1
            raise InputError(
                f"{path} line {lines[i]} has {letter} = {values[i]:g} {unit} after "
                f"{values[i - 1]:g} {unit}; sort the rows so that B and H both increase"
            )
    steep = np.flatnonzero(MU0 * np.diff(h) > (1.0 + _ROUNDING) * np.diff(b))
    if steep.size:
        i = int(steep[0]) + 1
        raise InputError(
            f"{path} line {lines[i]} has B = {b[i]:g} T at H = {h[i]:g} A/m, a rise by less than "
            "vacuum's mu0 since the line before; check the units of both columns"
        )
