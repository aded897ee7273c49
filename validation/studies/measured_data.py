"""Measured frequency responses: read from CSV, converted to SI, refused if unclear.

The header names each column with its unit, such as ``frequency (Hz), velocity (mm/s)``.
Nothing is repaired or guessed; a file that cannot be used gives one sentence.
"""

from __future__ import annotations

import math
import re
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Annotated, Any

import numpy as np
from pydantic import BeforeValidator, TypeAdapter, ValidationError

from tactgen.geometry.arrays import Bools, Floats, Ints, Numbers
from tactgen.geometry.csv_tables import csv_rows, heading, read_table
from tactgen.geometry.errors import InputError
from tactgen.geometry.names import nearest
from tactgen.geometry.units import FREQUENCY, PHASE, Unit, quoted
from tactgen.tmm.beam.parametric import check_length_free
from tactgen.validation.catalogue.quantities import QuantityRow, measurable
from tactgen.validation.scene.files import one_line
from tactgen.validation.scene.scene import Scene, scene_keys
from tactgen.validation.scene.variation import SYMBOLS, value_of

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
        """Mask (n,) of the points used."""
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
    (number, header), *_ = csv_rows(
        path, source, f"give a CSV file with columns such as {_EXAMPLE}"
    )
    kind = _only_curve([heading(cell).name for cell in header], f"{source} line {number}")
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
            f"there is no measured curve{close}; begin the file with a header such as {_EXAMPLE}, "
            f"and lines of remarks with #; known are {', '.join(measurable())}"
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


#: Bounds where none are given: this factor below and above the start.
_REACH = 100.0
_REMEDY = (
    "write for example --fit c_s=0.2N*m/rad:0.05..2N*m/rad, --fit c_s:0.05..2N*m/rad or --fit c_s"
)
_LEADING_NUMBER = re.compile(r"[+-]?[\d.]+(?:e[+-]?\d+)?", re.IGNORECASE | re.ASCII)


@dataclass(frozen=True)
class FitParameter:
    """One number of a scene that is fitted, SI units.

    `start`, `low` and `high` have one sign and none is 0, for the fit runs over the
    logarithm of the magnitude; ``|low| < |high|``.
    """

    key: str
    unit: Unit
    start: float
    low: float
    high: float

    @property
    def symbol(self) -> str:
        """The paper's symbol, or the key."""
        return next((s for s, key in SYMBOLS.items() if key == self.key), self.key)


@dataclass(frozen=True)
class FittedParameter:
    """One fitted parameter, SI units.

    `interval` is the 95 % confidence interval; `opened` names the ends of it (``low``, ``high``)
    that are only bounds of the search, `edge` the bound that the value itself is at.
    """

    parameter: FitParameter
    value: float
    interval: tuple[float, float]
    opened: tuple[str, ...]
    edge: str

    @property
    def half_width(self) -> float:
        """Half width of the interval of ln(value)."""
        return abs(float(np.log(self.interval[1] / self.interval[0]))) / 2.0


def fit_parameter(scene: Scene, text: str) -> FitParameter:
    """Read ``NAME[=START][:LOW..HIGH]``; NAME is a scene key or a symbol of the paper.

    The start is the scene's value unless given, the bounds a factor 100 either side of it.  A LOW
    without a unit has that of HIGH.

    Raises InputError if the name, a value or its unit cannot be used.
    """
    head, colon, bounds = text.partition(":")
    name, equals, start_text = (part.strip() for part in head.partition("="))
    low_text, dots, high_text = (part.strip() for part in bounds.partition(".."))
    if not name or (equals and not start_text) or (colon and not (low_text and high_text and dots)):
        raise InputError(
            f"--fit {quoted(text)} is not of the form NAME[=START][:LOW..HIGH]; {_REMEDY}"
        )
    key = SYMBOLS.get(name, name)
    unit = _unit_of_parameter(scene, key, name)
    if key == "bimorph.length":
        check_length_free(scene.bimorph)
    start = _read(key, start_text, unit) if equals else float(value_of(scene, key))
    if start == 0.0:
        raise InputError(
            f"{key} = {unit.show(0.0)} cannot be where a fit starts; give a value that is not 0, "
            f'for example --fit "{name}={unit.example}"'
        )
    if colon:
        if _LEADING_NUMBER.fullmatch(low_text):
            low_text += _LEADING_NUMBER.sub("", high_text, count=1)
        low, high = sorted((_read(key, end, unit) for end in (low_text, high_text)), key=abs)
    else:
        least, most = unit.limits or (0.0, math.inf)
        low, high = (
            math.copysign(min(max(abs(end), least), most), start)
            for end in (start / _REACH, start * _REACH)
        )
    if low * start <= 0.0 or not abs(low) <= abs(start) <= abs(high) or abs(low) == abs(high):
        raise InputError(
            f"--fit {quoted(text)} starts {key} at {unit.show(start)}, outside its bounds "
            f"{unit.show(low)} to {unit.show(high)}; give LOW and HIGH of one sign, not 0, with "
            "the start between them"
        )
    return FitParameter(key, unit, start, low, high)


def _read(key: str, text: str, unit: Unit) -> float:
    """SI value as the scene would read it."""
    reader: TypeAdapter[float] = TypeAdapter(Annotated[float, BeforeValidator(unit)])
    try:
        return reader.validate_python(text, context={"units_required": True})
    except ValidationError as error:
        reason = error.errors()[0]["ctx"]["error"]
        raise InputError(one_line(f"--fit: {key} = {quoted(text)} {reason}")) from None


def _unit_of_parameter(scene: Scene, key: str, name: str) -> Unit:
    if key not in scene_keys():
        raise InputError(
            f"--fit {quoted(name)} is not a scene key{nearest(name, (*SYMBOLS, *scene_keys()))}; "
            f"use {', '.join(SYMBOLS)} or a key that tactgen init FILE.toml writes"
        )
    group, _, last = key.rpartition(".")
    holder: Any = value_of(scene, group) if group else scene
    metadata = type(holder).model_fields[last].metadata
    unit = next((m for m in metadata if isinstance(m, Unit)), None)
    if unit is None or getattr(holder, last) is None:
        raise InputError(
            f"--fit {key} is not a number that can be fitted; use for example {', '.join(SYMBOLS)}"
        )
    return unit
