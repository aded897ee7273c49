"""Measured frequency responses: read from CSV, converted to SI, refused if unclear.

The header names each column with its unit, such as ``frequency (Hz), velocity (mm/s)``.
Nothing is repaired or guessed; a file that cannot be used gives one sentence.
"""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from tactgen.geometry.arrays import Bools, Floats, Ints, Numbers
from tactgen.geometry.csv_tables import (
    Column,
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
from tactgen.validation.catalogue.row import QuantityRow

_WEIGHT = Unit("", "weight", "1", limits=(1e-12, 1e12))
_PARTS = ("", "_re", "_im", "_phase")
_EXAMPLE = "frequency (Hz), velocity (mm/s)"
#: Most points of a curve: a sweep of a laboratory analyser has a few thousand.
_MOST = 100_000


@dataclass(frozen=True)
class MeasuredCurve:
    """One measured frequency response in SI units, peak amplitudes."""

    source: str  #: Name of the file, for messages
    kind: str  #: One of :func:`validation.catalogue.quantities.measurable`, such as ``velocity``
    frequencies: Floats  #: (n,) Hz, ascending, above 0
    #: (n,) Complex (time factor e^{+jΩt}, phase relative to the drive voltage), or real and
    #: positive where only the magnitude was measured
    values: Numbers
    #: (n,) Standard deviation of the magnitude, or of the real and of the imaginary part
    error: Floats | None
    #: (n,) How much each point counts in the sum of squares, whatever the scale; 0 leaves it out
    weight: Floats

    @property
    def has_phase(self) -> bool:
        """Whether the values are complex."""
        return np.iscomplexobj(self.values)

    @property
    def used(self) -> Bools:
        """Which points (n,) count."""
        return np.asarray(self.weight > 0.0)

    @property
    def relative_weight(self) -> Floats:
        """Weights (n,) with a mean of 1."""
        return np.asarray(self.weight / self.weight.mean())

    def at(self, points: Ints | Bools) -> MeasuredCurve:
        """Curve at some of its points."""
        return replace(
            self,
            frequencies=self.frequencies[points],
            values=self.values[points],
            error=None if self.error is None else self.error[points],
            weight=self.weight[points],
        )

    @property
    def unit(self) -> str:
        """SI unit of the values."""
        return self.quantity.unit

    @property
    def quantity(self) -> QuantityRow:
        """Row of the quantity that the curve is compared with."""
        return measurable()[self.kind]


def read_measured(path: str | Path) -> MeasuredCurve:
    """Read a measured curve.

    Columns, each with its unit in the header: ``frequency``; one of ``velocity``,
    ``displacement``, ``admittance``, ``current`` as a magnitude, as a magnitude with
    ``…_phase``, or as ``…_re`` with ``…_im``; optionally ``uncertainty`` (one standard
    deviation, same unit) or ``weight`` (no unit).  Separated by comma, semicolon or tab;
    decimal point; comments from ``#`` to the end of the line.

    Raises InputError in one sentence with file, line, column, value and remedy.
    """
    source = "".join(c if c.isprintable() else "?" for c in str(path))
    remedy = f"give a CSV file with columns such as {_EXAMPLE}"
    (number, names), *rows = csv_rows(path, source, remedy)
    if not any(heading(cell).name in _known() for cell in names):
        plain = all(plain_number(cell) is not None for cell in names)
        raise InputError(
            f"{source} line {number} holds {'numbers' if plain else 'other text'} where the "
            f"column names should be; begin the file with a header such as {_EXAMPLE}, and lines "
            "of remarks with #"
        )
    check_widths([(number, names), *rows], source)
    columns = _columns(names, f"{source} line {number}")
    if len(rows) < 2:
        raise InputError(f"{source} holds {len(rows)} measured points; a curve needs at least 5")
    if len(rows) > _MOST:
        raise InputError(f"{source} holds {len(rows)} points; thin it to at most {_MOST}")
    data = {name: numbers(rows, column, names, source) for name, column in columns.items()}
    lines = [line for line, _ in rows]
    check_ascending(data["frequency"], lines, source)
    kind = next(c for c in measurable() if c in data or f"{c}_re" in data)
    values, weight = _values(kind, data, lines, source), _weight(data, source)
    return MeasuredCurve(source, kind, data["frequency"], values, data.get("uncertainty"), weight)


def _known() -> tuple[str, ...]:
    """Names that a column may have."""
    curves = (curve + part for curve in measurable() for part in _PARTS)
    return ("frequency", *curves, "uncertainty", "weight")


def _columns(names: list[str], where: str) -> dict[str, Column]:
    """Place, factor to SI and unit of each column by its plain name."""
    places: dict[str, int] = {}
    stated: dict[str, str] = {}
    for at, text in enumerate(names):
        name, unit = heading(text)
        if name not in _known():
            raise InputError(
                f"{where}: column {at + 1} {quoted(text)} is unknown{nearest(name, _known())}; "
                f"name the columns like {_EXAMPLE} and remove those that are not needed"
            )
        if name in places:
            raise InputError(f"{where}: column {quoted(text)} is there twice; keep one of them")
        stated[name], places[name] = unit, at
    kind = _only_curve(places, where)
    units = {name: _unit(name, kind) for name in places}
    return {
        name: Column(at, _scale(name, stated[name], units[name], where), units[name])
        for name, at in places.items()
    }


def _only_curve(names: Collection[str], where: str) -> str:
    """Kind of the one curve that the columns hold completely."""
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
    have = [part for part in _PARTS if kind + part in names]
    if set(have) not in ({""}, {"", "_phase"}, {"_re", "_im"}):
        raise InputError(
            f"{where}: {' and '.join(kind + part for part in have)} without what belongs to it is "
            f"no curve; give {kind} alone, {kind} with {kind}_phase, or {kind}_re with {kind}_im"
        )
    if "uncertainty" in names and "weight" in names:
        raise InputError(f"{where}: uncertainty and weight are both there; keep one of them")
    return kind


def _unit(name: str, kind: str) -> Unit:
    fixed = {"frequency": FREQUENCY, "weight": _WEIGHT, f"{kind}_phase": PHASE}
    if name in fixed:
        return fixed[name]
    unit = measurable()[kind].curve
    assert unit is not None
    # one part of a complex number may be as small as it likes
    return unit if name == kind else replace(unit, limits=(0.0, (unit.limits or (0.0, np.inf))[1]))


def _scale(name: str, text: str, unit: Unit, where: str) -> float:
    """Factor from the column's unit to SI."""
    if unit.si:
        return scale_to_si(name, text, unit, where)
    if text not in ("", "1", "-"):
        raise InputError(
            f'{where}: column "{name}" has the unit {quoted(text)}; a weight has none, '
            f'so name the column "{name}"'
        )
    return 1.0


def _values(kind: str, data: dict[str, Floats], lines: list[int], source: str) -> Numbers:
    """Curve (n,), complex if its phase is known; no value may vanish."""
    if kind not in data:
        values = data[f"{kind}_re"] + 1j * data[f"{kind}_im"]
        if (values == 0.0).any():
            line = lines[int(np.argmax(values == 0.0))]
            raise InputError(f"{source} line {line}: {kind} is 0 in both parts; remove the line")
        return np.asarray(values)
    if (data[kind] <= 0.0).any():
        first = int(np.argmax(data[kind] <= 0.0))
        raise InputError(
            f"{source} line {lines[first]}: {kind} {data[kind][first]:g} {measurable()[kind].unit} "
            "is not above 0 as a magnitude must be; remove the line, or give "
            f"{kind}_re and {kind}_im"
        )
    if f"{kind}_phase" not in data:
        return data[kind]
    return np.asarray(data[kind] * np.exp(1j * data[f"{kind}_phase"]))


def _weight(data: dict[str, Floats], source: str) -> Floats:
    def first_where(wrong: Bools) -> str:
        return f"{float(data['frequency'][np.argmax(wrong)]):g} Hz"

    error, weight = data.get("uncertainty"), data.get("weight", np.ones(data["frequency"].size))
    if error is not None and (error <= 0.0).any():
        raise InputError(
            f"{source}: the uncertainty at {first_where(error <= 0.0)} is not above 0; give one "
            "standard deviation for every point, or leave the column out"
        )
    if (weight < 0.0).any():
        raise InputError(
            f"{source}: the weight at {first_where(weight < 0.0)} is negative; give 0 to leave a "
            "point out"
        )
    if not weight.any():
        raise InputError(f"{source}: all weights are 0; give the points that count a weight of 1")
    return weight
