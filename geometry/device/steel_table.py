"""The magnetisation curve that a device's steel names: built in, straight, or a CSV table.

A table is refused if no steel can have it.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from tactgen.geometry.arrays import Floats
from tactgen.geometry.csv_tables import read_columns
from tactgen.geometry.device.magnetisation import MU0, MagnetisationCurve, linear
from tactgen.geometry.device.parameters import Steel
from tactgen.geometry.device.steel_library import STEELS, built_in_curve
from tactgen.geometry.errors import InputError
from tactgen.geometry.synonyms import nearest
from tactgen.geometry.units import Unit, quoted

#: A table may be steeper than vacuum by this much: measured curves are rounded to about 1 %.
_ROUNDING = 0.01
#: Steps of B in a table (T).
_STEPS = (1e-9, 100.0)
#: The largest differential relative permeability, as that of steel.relative_permeability.
_MOST_PERMEABLE = 1e7

#: The header of a curve file, as messages give it, and what its columns measure.
_HEADER = '"B (T), H (A/m)"'
_COLUMNS = {"b": Unit("T", "flux density", "1 T"), "h": Unit("A/m", "field strength", "100 A/m")}


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
    """Read a magnetisation curve from a CSV file with the columns B and H, each with its unit.

    Comments begin with #; other columns are ignored.

    Raises InputError if the file cannot be read, a column or its unit is missing, or the rows are
    not a magnetisation curve.
    """
    path = Path(path)
    remedy = f"use {', '.join(STEELS)}, or the path of a CSV file with the header {_HEADER}"
    name = f"steel.curve = {quoted(str(path))}{nearest(path.name, STEELS)}"
    table = read_columns(path, name, _COLUMNS, _HEADER, _COLUMNS, remedy=remedy, others=True)
    b, h = table.columns["b"], table.columns["h"]
    _check(b, h, table.lines, path)
    return MagnetisationCurve(b, h, name=path.name)


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
            f"vacuum's mu0 since the line before; {_remedy(i)}"
        )
    loose = np.flatnonzero(np.diff(b) > MU0 * _MOST_PERMEABLE * np.diff(h))
    if loose.size:
        i = int(loose[0]) + 1
        raise InputError(
            f"{path} line {lines[i]} has B = {b[i]:g} T at H = {h[i]:g} A/m, a rise by more than "
            f"{_MOST_PERMEABLE:g} mu0 since the line before; {_remedy(i)}"
        )


def _remedy(row: int) -> str:
    """Remedy of an impossible slope: the first one is that of all, a later one of its line."""
    if row == 1:
        return "check the units of both columns"
    return "correct that line, or end the table before it: beyond its end the curve rises with mu0"


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
