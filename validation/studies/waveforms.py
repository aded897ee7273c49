"""Waveforms as people write them: ``10 V sine 200 Hz``, ``120 mA square 100 Hz delay 2 ms``.

    LEVEL [constant]
    LEVEL sine FREQUENCY [phase ANGLE] [delay TIME]
    LEVEL square FREQUENCY [low LEVEL] [duty SHARE] [delay TIME]
    LEVEL step [at TIME] [until TIME]
    LEVEL chirp FREQUENCY to FREQUENCY in TIME
    FILE.csv            with the columns time (s) and voltage (V) or current (A), or mA, ms, ...

A square is `LEVEL` for the first half of each period (or `duty`) and `low`, 0 by default, after.
"""

from __future__ import annotations

import math
import re
from dataclasses import dataclass
from typing import Literal

from tactgen.geometry.csv_tables import check_widths, csv_rows, heading, plain_number
from tactgen.geometry.errors import InputError
from tactgen.geometry.units import Unit, quoted
from tactgen.tmm.generator.transient.waveform import (
    Chirp,
    Constant,
    Sampled,
    Sine,
    Square,
    Step,
    Waveform,
)

VOLTS = Unit("V", "voltage", "10 V", limits=(1e-9, 1e5))
AMPERES = Unit("A", "current", "120 mA", limits=(1e-9, 1e3))
SECONDS = Unit("s", "time", "30 ms", at_least=0.0, limits=(1e-9, 1e4))
_HERTZ = Unit("Hz", "frequency", "200 Hz", above=0.0, limits=(1e-3, 1e7))
_SHARE = Unit("", "share", "0.5", above=0.0, below=1.0)
_ANGLE = Unit("rad", "angle", "90 deg", limits=(1e-9, 1e3))

#: Keywords after each kind, with the unit of what follows.
_KINDS: dict[str, tuple[Unit | None, dict[str, Unit | None]]] = {
    "constant": (None, {}),
    "sine": (_HERTZ, {"phase": _ANGLE, "delay": SECONDS}),
    "square": (_HERTZ, {"low": None, "duty": _SHARE, "delay": SECONDS}),
    "step": (None, {"at": SECONDS, "until": SECONDS}),
    "chirp": (_HERTZ, {"to": _HERTZ, "in": SECONDS}),
}
_EXAMPLES = (
    '"10 V sine 200 Hz", "120 mA square 100 Hz", "5 V step at 1 ms", '
    '"1 V chirp 10 Hz to 1000 Hz in 20 ms" or a CSV file'
)
_WORD = re.compile(r"\b(constant|sine|square|step|chirp|phase|delay|low|duty|at|until|to|in)\b")


@dataclass(frozen=True)
class Written:
    """A waveform and what it is of."""

    waveform: Waveform
    of: Literal["voltage", "current"]


def parsed(text: str, option: str, units: tuple[Unit, ...]) -> Written:
    """What an option's text says.

    Parameters
    ----------
    option : str
        What messages call it, such as ``--voltage``.
    units : tuple of Unit
        VOLTS, AMPERES or both: what the level may be.

    Raises InputError in one sentence with an example.
    """
    text = text.strip()
    if text.lower().endswith(".csv"):
        return _sampled(text, option, units)
    pieces = _WORD.split(text)
    level, unit = _level(pieces[0], option, text, units)
    kind = pieces[1] if len(pieces) > 1 else "constant"
    if kind not in _KINDS:
        raise InputError(f"{option} {quoted(text)} is no waveform; write {_EXAMPLES}")
    first, known = _KINDS[kind]
    given: dict[str, float] = {}
    stated = pieces[2].strip() if len(pieces) > 2 else ""
    if first is not None:
        given["frequency"] = _value(stated, first, option, text, f"the {kind}'s frequency")
    elif stated:
        raise InputError(f"{option} {quoted(text)} has {quoted(stated)} after {kind}; leave it out")
    for word, value in zip(pieces[3::2], pieces[4::2], strict=True):
        if word not in known or word in given:
            why = "twice" if word in given else f"which {kind} does not know"
            raise InputError(f"{option} {quoted(text)} has {word}, {why}; write {_EXAMPLES}")
        given[word] = _value(value.strip(), known[word] or unit, option, text, word)
    return Written(
        _made(kind, level, given, option, text), "current" if unit is AMPERES else "voltage"
    )


def _made(kind: str, level: float, given: dict[str, float], option: str, text: str) -> Waveform:
    delay = given.get("delay", 0.0)
    match kind:
        case "constant":
            return Constant(level)
        case "sine":
            return Sine(level, given["frequency"], given.get("phase", 0.0), delay)
        case "square":
            low, duty = given.get("low", 0.0), given.get("duty", 0.5)
            return Square(level, given["frequency"], low, duty, delay)
        case "step":
            start, stop = given.get("at", 0.0), given.get("until", math.inf)
            if stop <= start:
                raise InputError(
                    f"{option} {quoted(text)} ends at {stop:g} s, not after its start at "
                    f"{start:g} s; give a later end"
                )
            return Step(level, start, stop)
    if "to" not in given or not given.get("in"):
        raise InputError(
            f"{option} {quoted(text)} needs the last frequency and the time of the chirp; write "
            'for example "1 V chirp 10 Hz to 1000 Hz in 20 ms"'
        )
    return Chirp(level, given["frequency"], given["to"], given["in"])


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
        reason = "is no level in volts or amperes"
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
    rows = csv_rows(path, name, remedy)
    check_widths(rows, name)
    known = {("current" if unit is AMPERES else "voltage"): unit for unit in units}
    heads = [heading(cell) for cell in rows[0][1]]
    if len(heads) != 2 or heads[0].name != "time" or heads[1].name not in known:
        raise InputError(
            f"{name} has the columns {', '.join(rows[0][1])}; give the columns time (s) and "
            + " or ".join(f"{what} ({unit.si})" for what, unit in known.items())
        )
    scales = []
    for cell, head, unit in zip(rows[0][1], heads, (SECONDS, known[heads[1].name]), strict=True):
        try:
            scales.append(unit.parse(f"1 {head.unit}"))
        except ValueError as error:
            raise InputError(f"{name}: the column {cell} {error}") from None
    times, values = [], []
    for line, cells in rows[1:]:
        time, value = (plain_number(cell) for cell in cells)
        if time is None or value is None:
            raise InputError(f"{name} line {line} does not hold two numbers; mend it")
        times.append(time * scales[0])
        values.append(value * scales[1])
        if times[-1] < 0.0 or (len(times) > 1 and times[-1] < times[-2]):
            raise InputError(
                f"{name} line {line}: time = {time:g} {heads[0].unit} is negative or before "
                "the line above; sort the rows from 0 on"
            )
    if not times:
        raise InputError(f"{name} has no rows; {remedy}")
    of: Literal["voltage", "current"] = "current" if heads[1].name == "current" else "voltage"
    return Written(Sampled(tuple(times), tuple(values)), of)
