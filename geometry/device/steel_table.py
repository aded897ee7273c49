"""Magnetisation curves from CSV files: read, and refused if no steel can have them."""

from __future__ import annotations

import csv
import math
from pathlib import Path

import numpy as np

from geometry.arrays import Floats
from geometry.device.steel_law import MU0, MagnetisationCurve
from geometry.errors import InputError
from geometry.units import quoted

#: A table may be steeper than vacuum by this much: measured curves are rounded to about 1 %.
_ROUNDING = 0.01
#: Steps of B in a table (T).
_STEPS = (1e-9, 100.0)
#: The largest differential relative permeability, as that of steel.relative_permeability.
_MOST_PERMEABLE = 1e7

#: The header of a curve file, as messages give it.
_HEADER = '"B (T), H (A/m)"'


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
    # each line by itself: what quotes leave open would join lines and shift their numbers
    rows = [(number, _cells(line, path, number)) for number, line in numbered]
    columns = _columns(rows[0][1], path)
    b, h = (
        np.array([_number(row, column, path, number) for number, row in rows[1:]])
        for column in columns
    )
    _check(b, h, [number for number, _ in numbered[1:]], path)
    return MagnetisationCurve(b, h, name=path.name)


def _cells(line: str, path: Path, number: int) -> list[str]:
    try:
        return next(csv.reader([line]))
    except csv.Error as error:
        raise InputError(
            f"{path} line {number} cannot be read ({error}); write two plain numbers on each line"
        ) from None


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
    _check_steps(b, lines, path)
    steep = np.flatnonzero(np.diff(h) > (1.0 + _ROUNDING) / MU0 * np.diff(b))
    if steep.size:
        i = int(steep[0]) + 1
        raise InputError(
            f"{path} line {lines[i]} has B = {b[i]:g} T at H = {h[i]:g} A/m, a rise by less than "
            "vacuum's mu0 since the line before; check the units of both columns"
        )
    loose = np.flatnonzero(np.diff(b) > MU0 * _MOST_PERMEABLE * np.diff(h))
    if loose.size:
        i = int(loose[0]) + 1
        raise InputError(
            f"{path} line {lines[i]} has B = {b[i]:g} T at H = {h[i]:g} A/m, a rise by more than "
            f"{_MOST_PERMEABLE:g} mu0 since the line before; check the units of both columns"
        )


def _check_steps(b: Floats, lines: list[int], path: Path) -> None:
    """Refuse steps of B that no table has, which arithmetic could not follow."""
    low, high = _STEPS
    odd = np.flatnonzero((np.diff(b) < low) | (np.diff(b) > high))
    if odd.size:
        i = int(odd[0]) + 1
        raise InputError(
            f"{path} line {lines[i]} has B = {b[i]:g} T after {b[i - 1]:g} T; "
            f"steps must lie between {low:g} and {high:g} T: check the unit of B"
        )
