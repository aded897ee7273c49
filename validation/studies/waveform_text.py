"""Waveforms as users write them: text such as "10 V sine 200 Hz", or a CSV file."""

from __future__ import annotations

import math
import re
from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal

from tactgen.geometry.csv_tables import read_columns
from tactgen.geometry.errors import InputError
from tactgen.geometry.units import Unit, quoted
from tactgen.tmm.generator.transient.waveform import Chirp, Sampled, Sine, Square, Step, Waveform

VOLTS = Unit("V", "voltage", "10 V", limits=(1e-9, 1e5))
AMPERES = Unit("A", "current", "120 mA", limits=(1e-9, 1e3))
SECONDS = Unit("s", "time", "30 ms", at_least=0.0, limits=(1e-9, 1e4))
_HERTZ = Unit("Hz", "frequency", "200 Hz", above=0.0, limits=(1e-3, 1e7))
_SHARE = Unit("", "share", "0.5", above=0.0, below=1.0)
_ANGLE = Unit("rad", "angle", "90 deg", limits=(1e-9, 1e3))

#: Of each kind its waveform, the field of the frequency that follows if there is one, and the
#: keywords with their fields and units; one without a unit has that of the level.
_KINDS: dict[str, tuple[Callable[..., Waveform], str, dict[str, tuple[str, Unit | None]]]] = {
    "constant": (Step, "", {}),
    "sine": (Sine, "frequency", {"phase": ("phase", _ANGLE), "delay": ("start", SECONDS)}),
    "square": (
        Square, "frequency",
        {"low": ("low", None), "duty": ("duty", _SHARE), "delay": ("start", SECONDS)},
    ),
    "step": (Step, "", {"at": ("start", SECONDS), "until": ("stop", SECONDS)}),
    "chirp": (Chirp, "first", {"to": ("last", _HERTZ), "in": ("duration", SECONDS)}),
}  # fmt: skip
_EXAMPLES = (
    '"10 V sine 200 Hz", "120 mA square 100 Hz", "5 V step at 1 ms", '
    '"1 V chirp 10 Hz to 1000 Hz in 20 ms" or a CSV file'
)
_WORD = re.compile(r"\b(constant|sine|square|step|chirp|phase|delay|low|duty|at|until|to|in)\b")


@dataclass(frozen=True)
class Written:
    """Waveform of a source."""

    waveform: Waveform
    of: Literal["voltage", "current"]


def parsed(text: str, option: str, units: tuple[Unit, ...]) -> Written:
    """Value of an option's text, whose level may be in VOLTS, AMPERES or both.

    Raises InputError in one sentence with an example.
    """
    text = text.strip()
    if text.lower().endswith(".csv"):
        return _sampled(text, option, units)
    pieces = _WORD.split(text)
    level, unit = _level(pieces[0], option, text, units)
    kind = pieces[1] if len(pieces) > 1 else "constant"
    if kind not in _KINDS:
        raise InputError(f"{option} {quoted(text)} is not a waveform; write {_EXAMPLES}")
    made, frequency, known = _KINDS[kind]
    given: dict[str, float] = {}
    stated = pieces[2].strip() if len(pieces) > 2 else ""
    if frequency:
        given[frequency] = _value(stated, _HERTZ, option, text, f"the {kind}'s frequency")
    elif stated:
        raise InputError(f"{option} {quoted(text)} has {quoted(stated)} after {kind}; remove it")
    for word, value in zip(pieces[3::2], pieces[4::2], strict=True):
        field, scale = known.get(word, ("", None))
        if not field or field in given:
            why = "twice" if field else f"which {kind} does not know"
            raise InputError(f"{option} {quoted(text)} has {word}, {why}; write {_EXAMPLES}")
        given[field] = _value(value.strip(), scale or unit, option, text, word)
    if kind == "step" and given.get("stop", math.inf) <= given.get("start", 0.0):
        raise InputError(
            f"{option} {quoted(text)} ends at {given['stop']:g} s, not after its start at "
            f"{given.get('start', 0.0):g} s; give a later end"
        )
    if kind == "chirp" and not ("last" in given and given.get("duration")):
        raise InputError(
            f"{option} {quoted(text)} needs the last frequency and the time of the chirp; write "
            'for example "1 V chirp 10 Hz to 1000 Hz in 20 ms"'
        )
    return Written(made(level, **given), "current" if unit is AMPERES else "voltage")


def _level(piece: str, option: str, text: str, units: tuple[Unit, ...]) -> tuple[float, Unit]:
    reason = ""
    for unit in units:
        try:
            unit.parse(piece.strip())
        except ValueError as error:
            reason = str(error)
        else:
            return _value(piece.strip(), unit, option, text, "the level"), unit
    if len(units) > 1:
        reason = "is not a level in volts or amperes"
    such_as = ", or a waveform such as " if "; " in reason else "; write a waveform such as "
    raise InputError(
        f"{option} {quoted(text)}: {quoted(piece.strip())} {reason}{such_as}{_EXAMPLES}"
    )


def _value(piece: str, unit: Unit, option: str, text: str, name: str) -> float:
    """Read a number with its unit, within the unit's bounds."""
    shown = f"{name} {quoted(piece)}"
    try:
        value = unit.parse(piece)
        shown = f"{name} = {unit.show(value)}"
        unit.check(value)
    except ValueError as error:
        raise InputError(f"{option} {quoted(text)}: {shown} {error}") from None
    return value


def _sampled(path: str, option: str, units: tuple[Unit, ...]) -> Written:
    """Read a CSV of two columns."""
    remedy = "give a CSV with the columns time (s) and voltage (V) or current (A)"
    name = f"{option} {path}"
    known = {("current" if unit is AMPERES else "voltage"): unit for unit in units}
    example = " and ".join(("time (s)", " or ".join(f"{w} ({u.si})" for w, u in known.items())))
    table = read_columns(path, name, {"time": SECONDS, **known}, example, ("time",), remedy=remedy)
    what = [column for column in table.columns if column != "time"]
    if len(what) != 1:
        raise InputError(f"{name} has {len(what) + 1} columns; give {example}")
    times = table.columns["time"]
    for line, before, time in zip(table.lines, [0.0, *times], times, strict=False):
        if time < before:
            raise InputError(
                f"{name} line {line}: time = {time:g} s is negative or before the line above; "
                "sort the rows from 0 on"
            )
    if not times.size:
        raise InputError(f"{name} has no rows; {remedy}")
    of: Literal["voltage", "current"] = "current" if what[0] == "current" else "voltage"
    return Written(Sampled(tuple(map(float, times)), tuple(map(float, table.columns[what[0]]))), of)
