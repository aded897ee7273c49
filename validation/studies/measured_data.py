"""Measured frequency responses: read from CSV, converted to SI, refused if unclear.

The header names each column with its unit, such as ``frequency (Hz), velocity (mm/s)``.
Nothing is repaired or guessed; a file that cannot be used gives one sentence.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from tactgen.geometry.arrays import Bools, Floats, Ints, Numbers
from tactgen.geometry.csv_tables import csv_rows, heading, read_table
from tactgen.geometry.errors import InputError
from tactgen.geometry.synonyms import nearest
from tactgen.geometry.units import FREQUENCY, PHASE, Unit
from tactgen.validation.catalogue.quantities import QuantityRow, measurable

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
    (number, header), *_ = csv_rows(
        path, source, f"give a CSV file with columns such as {_EXAMPLE}"
    )
    kind = _only_curve([heading(cell)[0] for cell in header], f"{source} line {number}")
    data, lines = read_table(path, source, _units(kind), _EXAMPLE)
    if not 2 <= len(lines) <= _MOST:
        raise InputError(
            f"{source} holds {len(lines)} points; "
            + (f"thin it to at most {_MOST}" if lines else "a curve needs at least 5")
        )
    error, weight = data.get("uncertainty"), data.get("weight", np.ones(len(lines)))

    def check(wrong: Bools, reason: str) -> None:
        if wrong.any():
            raise InputError(f"{source} line {lines[int(np.argmax(wrong))]}: {reason}")

    if kind in data:
        check(
            data[kind] <= 0.0,
            f"{kind} is not above 0 as a magnitude must be; remove the line, or give {kind}_re "
            f"and {kind}_im",
        )
        phase = data.get(f"{kind}_phase")
        values = data[kind] if phase is None else data[kind] * np.exp(1j * phase)
    else:
        values = data[f"{kind}_re"] + 1j * data[f"{kind}_im"]
        check(values == 0.0, f"{kind} is 0 in both parts; remove the line")
    if error is not None:
        check(
            error <= 0.0,
            "the uncertainty is not above 0; give one standard deviation for every point, or "
            "leave the column out",
        )
    check(weight < 0.0, "the weight is negative; give 0 to leave a point out")
    if not weight.any():
        raise InputError(f"{source}: all weights are 0; give the points that count a weight of 1")
    return MeasuredCurve(source, kind, data["frequency"], np.asarray(values), error, weight)


def _only_curve(names: list[str], where: str) -> str:
    """Kind of the one curve that the columns hold completely."""
    kinds = [c for c in measurable() if any(c + part in names for part in _PARTS)]
    if len(kinds) != 1:
        both = f"{' and '.join(kinds)} are both there; keep one measured curve per file"
        known = [c + part for c in measurable() for part in _PARTS]
        close = next(filter(None, (nearest(name, known) for name in names)), "")
        none = (
            f'"{", ".join(names)}" holds no measured curve{close}; begin the file with a header '
            f"such as {_EXAMPLE}, and lines of remarks with #; known are {', '.join(measurable())}"
        )
        raise InputError(f"{where}: {both if kinds else none}")
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


def _units(kind: str) -> dict[str, Unit]:
    """Unit of each column beside a curve."""
    unit = measurable()[kind].curve
    assert unit is not None
    # one part of a complex number may be as small as it likes
    part = replace(unit, limits=(0.0, (unit.limits or (0.0, np.inf))[1]))
    return {
        "frequency": FREQUENCY, kind: unit, f"{kind}_phase": PHASE, f"{kind}_re": part,
        f"{kind}_im": part, "uncertainty": part, "weight": _WEIGHT,
    }  # fmt: skip
