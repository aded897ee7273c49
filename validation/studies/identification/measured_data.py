"""A measured frequency response as a CSV file: read, converted to SI, and refused if unclear.

The header names each column with its unit, such as ``frequency (Hz), velocity (mm/s)``.
Nothing is repaired or guessed; a file that cannot be used gives one sentence.
"""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import replace
from pathlib import Path

import numpy as np

from tactgen.geometry.arrays import Floats, Numbers
from tactgen.geometry.csv_tables import (
    Column,
    Row,
    check_ascending,
    check_widths,
    csv_rows,
    heading,
    numbers,
    plain_number,
    scale_to_si,
)
from tactgen.geometry.errors import InputError
from tactgen.geometry.names import nearest
from tactgen.geometry.units import FREQUENCY, PHASE, Unit, quoted
from tactgen.validation.catalogue.quantities import measurable
from tactgen.validation.studies.identification.measured_curve import MeasuredCurve

_WEIGHT = Unit("", "weight", "1", limits=(1e-12, 1e12))
_PARTS = ("", "_re", "_im", "_phase")
_EXAMPLE = "frequency (Hz), velocity (mm/s)"
#: Most points that a curve may have: a sweep of a laboratory analyser has a few thousand.
_MOST = 100_000


def read_measured(path: str | Path) -> MeasuredCurve:
    """Read a measured curve.

    Columns, each with its unit in the header: ``frequency``; one of ``velocity``,
    ``displacement``, ``admittance``, ``current`` as a magnitude, as a magnitude with
    ``…_phase``, or as ``…_re`` with ``…_im``; optionally ``uncertainty`` (one standard
    deviation, same unit) or ``weight`` (no unit).  Separated by comma, semicolon or tab;
    decimal point; comments from ``#`` to the end of the line.

    Raises
    ------
    InputError
        In one sentence with file, line, column, value and remedy.
    """
    source = _printable(str(path))
    (number, names), rows = _table(path, source)
    columns = _columns(names, f"{source} line {number}")
    if len(rows) < 2:
        raise InputError(f"{source} holds {len(rows)} measured points; a curve needs at least 5")
    if len(rows) > _MOST:
        raise InputError(f"{source} holds {len(rows)} points; thin it to at most {_MOST}")
    data = {name: numbers(rows, column, names, source) for name, column in columns.items()}
    lines = [line for line, _ in rows]
    check_ascending(data["frequency"], lines, source)
    kind = next(c for c in measurable() if c in data or f"{c}_re" in data)
    return MeasuredCurve(
        source=source,
        kind=kind,
        frequencies=data["frequency"],
        values=_values(kind, data, lines, source),
        error=data.get("uncertainty"),
        weight=_weight(data, source),
    )


def _printable(text: str) -> str:
    return "".join(c if c.isprintable() else "?" for c in text)


def _table(path: str | Path, source: str) -> tuple[Row, list[Row]]:
    """Return the header and the rows of measured points, each as wide as the header."""
    remedy = f"give a CSV file with columns such as {_EXAMPLE}"
    (number, header), *rows = csv_rows(path, source, remedy)
    if not any(heading(cell).name in _known() for cell in header):
        plain = all(plain_number(cell) is not None for cell in header)
        what = "numbers" if plain else "other text"
        raise InputError(
            f"{source} line {number} holds {what} where the column names should be; begin the "
            f"file with a header such as {_EXAMPLE}, and lines of remarks with #"
        )
    check_widths([(number, header), *rows], source)
    return (number, header), rows


def _known() -> tuple[str, ...]:
    """Return the names that a column may have."""
    curves = (curve + part for curve in measurable() for part in _PARTS)
    return ("frequency", *curves, "uncertainty", "weight")


def _columns(names: list[str], where: str) -> dict[str, Column]:
    """Return position, factor to SI and kind of unit of each column, by its plain name."""
    found: dict[str, int] = {}
    units: dict[str, str] = {}
    for at, text in enumerate(names):
        name, unit = heading(text)
        if name not in _known():
            raise InputError(
                f"{where}: column {at + 1} {quoted(text)} is unknown{nearest(name, _known())}; "
                f"name the columns like {_EXAMPLE} and remove those that are not needed"
            )
        if name in found:
            raise InputError(f"{where}: column {quoted(text)} is there twice; keep one of them")
        units[name], found[name] = unit, at
    curve = _the_curve(found, where)
    kinds = {name: _unit_of(name, curve) for name in found}
    return {
        name: Column(at, _scale(name, units[name], kinds[name], where), kinds[name])
        for name, at in found.items()
    }


def _the_curve(names: Collection[str], where: str) -> str:
    """Return which curve the columns hold; there must be one, completely."""
    if "frequency" not in names:
        raise InputError(f'{where}: there is no frequency column; add one named "frequency (Hz)"')
    kinds = [c for c in measurable() if any(c + part in names for part in _PARTS)]
    if not kinds:
        raise InputError(
            f"{where}: there is no measured curve; add a column such as "
            f'"velocity (mm/s)"; known are {", ".join(measurable())}'
        )
    if len(kinds) > 1:
        raise InputError(
            f"{where}: {' and '.join(kinds)} are both there; keep one measured curve per file"
        )
    kind = kinds[0]
    have = {part for part in _PARTS if kind + part in names}
    if have not in ({""}, {"", "_phase"}, {"_re", "_im"}):
        alone = " and ".join(kind + part for part in _PARTS if part in have)
        raise InputError(
            f"{where}: {alone} without what belongs to it is no curve; give {kind} "
            f"alone, {kind} with {kind}_phase, or {kind}_re with {kind}_im"
        )
    if "uncertainty" in names and "weight" in names:
        raise InputError(f"{where}: uncertainty and weight are both there; keep one of them")
    return kind


def _unit_of(name: str, curve: str) -> Unit:
    if name == "frequency":
        return FREQUENCY
    if name == "weight":
        return _WEIGHT
    if name.endswith("_phase"):
        return PHASE
    unit = _unit_of_curve(curve)
    _, largest = unit.limits or (0.0, np.inf)
    # one part of a complex number may be as small as it likes
    return unit if name == curve else replace(unit, limits=(0.0, largest))


def _unit_of_curve(curve: str) -> Unit:
    unit = measurable()[curve].curve
    assert unit is not None
    return unit


def _scale(name: str, text: str, unit: Unit, where: str) -> float:
    """Return the factor from the column's unit to SI."""
    if unit.si:
        return scale_to_si(name, text, unit, where)
    if text not in ("", "1", "-"):
        raise InputError(
            f'{where}: column "{name}" has the unit {quoted(text)}; a weight has none, '
            f'so name the column "{name}"'
        )
    return 1.0


def _values(kind: str, data: dict[str, Floats], lines: list[int], source: str) -> Numbers:
    """Return the curve, complex if its phase is known; no value may vanish."""
    if kind in data:
        si = _unit_of_curve(kind).si
        for line, value in zip(lines, data[kind], strict=True):
            if value <= 0.0:
                raise InputError(
                    f"{source} line {line}: {kind} {value:g} {si} is not above 0 as a magnitude "
                    f"must be; remove the line, or give {kind}_re and {kind}_im"
                )
        if f"{kind}_phase" not in data:
            return data[kind]
        return np.asarray(data[kind] * np.exp(1j * data[f"{kind}_phase"]))
    values = data[f"{kind}_re"] + 1j * data[f"{kind}_im"]
    for line, value in zip(lines, values, strict=True):
        if value == 0.0:
            raise InputError(f"{source} line {line}: {kind} is 0 in both parts; remove the line")
    return np.asarray(values)


def _weight(data: dict[str, Floats], source: str) -> Floats:
    n = data["frequency"].size
    if "uncertainty" in data and (data["uncertainty"] <= 0.0).any():
        first = float(data["frequency"][np.argmax(data["uncertainty"] <= 0.0)])
        raise InputError(
            f"{source}: the uncertainty at {first:g} Hz is not above 0; give one standard "
            "deviation for every point, or leave the column out"
        )
    weight = data.get("weight", np.ones(n))
    if (weight < 0.0).any():
        first = float(data["frequency"][np.argmax(weight < 0.0)])
        raise InputError(
            f"{source}: the weight at {first:g} Hz is negative; give 0 to leave a point out"
        )
    if not weight.any():
        raise InputError(f"{source}: all weights are 0; give the points that count a weight of 1")
    return weight
