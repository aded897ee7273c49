"""The magnetisation curve that a device's steel names: built in, straight, or a CSV table.

A table is refused if no steel can have it.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from tactgen.geometry.arrays import Floats
from tactgen.geometry.csv_tables import check_widths, csv_rows, plain_number
from tactgen.geometry.device.magnetisation import MU0, MagnetisationCurve, linear
from tactgen.geometry.device.material_library import STEELS, built_in_curve
from tactgen.geometry.device.parameters import Steel
from tactgen.geometry.errors import InputError
from tactgen.geometry.names import nearest
from tactgen.geometry.units import quoted

#: A table may be steeper than vacuum by this much: measured curves are rounded to about 1 %.
_ROUNDING = 0.01
#: Steps of B in a table (T).
_STEPS = (1e-9, 100.0)
#: The largest differential relative permeability, as that of steel.relative_permeability.
_MOST_PERMEABLE = 1e7

#: The header of a curve file, as messages give it.
_HEADER = '"B (T), H (A/m)"'


def magnetisation_curve(steel: Steel) -> MagnetisationCurve:
    """Curve that a device's `steel` names.

    Raises InputError if the file cannot be used.
    """
    if steel.curve == "linear":
        return linear(steel.relative_permeability)
    if steel.curve in STEELS:
        return built_in_curve(steel.curve)
    return read_curve(steel.curve)


def read_curve(path: str | Path) -> MagnetisationCurve:
    """Read a magnetisation curve from a CSV file with the columns B (T) and H (A/m).

    Comments begin with #; other columns are ignored.

    Raises InputError if the file cannot be read, a column or its unit is missing, or the rows are
    not a magnetisation curve.
    """
    path = Path(path)
    remedy = f"use {', '.join(STEELS)}, or the path of a CSV file with the header {_HEADER}"
    rows = csv_rows(path, f"steel.curve = {quoted(str(path))}{nearest(path.name, STEELS)}", remedy)
    columns = _columns(rows[0][1], path)
    check_widths(rows, str(path), short=True)
    b, h = (
        np.array([_number(row, column, path, number) for number, row in rows[1:]])
        for column in columns
    )
    _check(b, h, [number for number, _ in rows[1:]], path)
    return MagnetisationCurve(b, h, name=path.name)


def _columns(header: list[str], path: Path) -> tuple[int, int]:
    """Where B (T) and H (A/m) stand."""
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
    cell = row[column] if column < len(row) else ""
    value = plain_number(cell)
    if value is None:
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
