"""Comparison of two scenes or two studies, in input and answers."""

from __future__ import annotations

import csv
import math
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from tactgen.geometry.errors import InputError
from tactgen.geometry.formats import percent, with_error
from tactgen.validation.engine.answers import COLUMNS, quantity_rows
from tactgen.validation.scene.parameter_list import parameter_rows
from tactgen.validation.scene.scene import Scene, checked_scene, load_scene, scene_values
from tactgen.validation.studies.whatif.axes import scene_field
from tactgen.validation.studies.whatif.defaults import chosen
from tactgen.validation.studies.whatif.definition import FILE, Statement, read_statement
from tactgen.validation.studies.whatif.output_files import TABLE

#: Longest list of frequencies that is shown whole.
_LISTED = 6


class Key(NamedTuple):
    """Identity of a number: point, quantity, model, frequency (Hz), index."""

    point: tuple[tuple[str, str], ...]
    quantity: str
    model: str
    frequency: str
    number: str


@dataclass(frozen=True)
class Number:
    """A number with its absolute bar, both SI; nan where there is no answer."""

    value: complex
    error: float
    unit: str


@dataclass(frozen=True)
class Side:
    """One of the two."""

    name: str  #: As it was given
    inputs: dict[str, str]  #: Scene keys with their values, and of a study its axes
    numbers: dict[Key, Number]  #: By what they are
    missing: dict[Key, str]  #: Answers that are missing, and why
    scene: Scene  #: The scene; of a study without its axes
    axes: tuple[str, ...]  #: Headings of the axes' columns


def read_sides(
    names: Sequence[str],
    overrides: Sequence[str],
    models: Sequence[str] | None,
    quantities: Sequence[str] | None,
    announce: Callable[[str], None],
) -> tuple[Side, ...]:
    """Both sides; scenes are solved, studies are read as they were written.

    Raises InputError if one cannot be read, a scene is held against a study, or models are named
    for studies.
    """
    studies = [Path(name, FILE).exists() for name in names]
    if len(set(studies)) > 1:
        raise InputError(
            f"{names[0]} and {names[1]} are a scene and a study; compare two of one kind"
        )
    if not studies[0]:
        return tuple(_scene(name, overrides, models, quantities, announce) for name in names)
    if overrides or models or quantities:
        raise InputError(
            "studies are compared as they were written, so --set, --model, --quantity and "
            "--frequency are for scenes; leave them out"
        )
    return tuple(_study(Path(name)) for name in names)


def _scene(
    name: str,
    overrides: Sequence[str],
    models: Sequence[str] | None,
    quantities: Sequence[str] | None,
    announce: Callable[[str], None],
) -> Side:
    from tactgen.validation.engine.solve import solve

    values, _ = scene_values(name, overrides)
    which = chosen(values, models, quantities, Statement("", {}, (), (), ()))
    scene, origins = load_scene(name, [*overrides, f"models={','.join(which[0])}"])
    announce(f"scene {name}")
    solution = solve(scene, *which, announce)
    rows = (row for q in solution.quantities for row in quantity_rows(q))
    numbers, missing = _numbered(
        ["" if cell is None else str(cell) for cell in row] for row in rows
    )
    return Side(name, _inputs(scene, origins), numbers, missing, scene, ())


def _study(folder: Path) -> Side:
    statement = read_statement(folder)
    scene = checked_scene({**statement.values, "models": list(statement.models)})
    path = folder / TABLE
    try:
        with path.open(newline="", encoding="utf-8") as file:
            rows = list(csv.reader(file))
        head, axes = rows[0], len(statement.axes)
        if tuple(head[axes:]) != COLUMNS:
            raise ValueError("other columns")
        numbers, missing = _numbered(
            (tuple(zip(head[:axes], row[:axes], strict=True)), *row[axes:]) for row in rows[1:]
        )
    except OSError as error:
        reason = (error.strerror or str(error)).lower()
        raise InputError(
            f"{path} cannot be read ({reason}); finish the study with tactgen whatif --resume "
            f"--out {folder}"
        ) from None
    except (ValueError, IndexError, csv.Error) as error:
        raise InputError(
            f"{path} is not the table of a study ({error}); write it again with tactgen whatif "
            f"--resume --out {folder}"
        ) from None
    varied = {f"axis {axis.key}": axis.text for axis in statement.axes}
    inputs = {k: v for k, v in _inputs(scene, {}).items() if f"axis {k}" not in varied}
    return Side(str(folder), inputs | varied, numbers, missing, scene, tuple(head[:axes]))


def _inputs(scene: Scene, origins: dict[str, str]) -> dict[str, str]:
    rows = parameter_rows(scene, origins)
    found = {row.key: row.written for row in rows if row.key not in ("name", "description")}
    for key in ("models", "quantities"):
        names = getattr(scene, key)
        if len(names) > _LISTED:
            found[key] = f"{', '.join(names[:2])} and {len(names) - 2} more"
    stated = scene.frequency
    if len(stated) > _LISTED:
        ends = f"{stated[0]:g}, {stated[1]:g} … {stated[-1]:g} Hz"  # the second tells the spacing
        found["frequency"] = f"{len(stated)} values: {ends}"
    return found


def _numbered(rows: Iterable[Sequence[object]]) -> tuple[dict[Key, Number], dict[Key, str]]:
    """Numbers and missing answers from rows of the tidy table."""
    numbers: dict[Key, Number] = {}
    missing: dict[Key, str] = {}
    for row in rows:
        point: tuple[tuple[str, str], ...] = ()
        if row and isinstance(row[0], tuple):
            point, row = row[0], row[1:]
        cells = dict(zip(COLUMNS, (str(cell) for cell in row), strict=True))
        key = Key(point, cells["quantity"], cells["model"], cells["frequency"], cells["index"])
        if cells["value"] == "":
            missing[key] = cells["reason"]
            continue
        value = complex(float(cells["value"]), float(cells["value_im"] or 0.0))
        numbers[key] = Number(value, float(cells["uncertainty"] or "nan"), cells["unit"])
    return numbers, missing


#: Rounding of numbers that are written and read, and of one order of summation for another.
_ROUNDING = 1e-13


@dataclass(frozen=True)
class InputDifference:
    """A key with its value on both sides; empty where one has none."""

    key: str
    first: str
    second: str


@dataclass(frozen=True)
class AnswerDifference:
    """One quantity by one model on both sides."""

    quantity: str
    model: str
    #: How many numbers both have, and how many of them differ by more than both bars together
    count: int
    beyond: int
    only: tuple[int, int]  #: (int, int) How many numbers only the one and only the other has
    key: Key  #: Where the difference is largest, in bars beyond them or else relative to the value
    #: There
    first: Number
    second: Number

    @property
    def relative(self) -> float:
        """Change from the first to the second where it is largest, of the magnitudes."""
        return _relative(self.first, self.second)

    @property
    def verdict(self) -> str:
        """Verdict on the change, in words."""
        if not self.beyond:
            return "the same" if self.relative == 0.0 else "covered by the bars"
        of = "" if self.count == 1 else f" at {self.beyond} of {self.count} values"
        return f"beyond the bars{of}"


def input_differences(first: Side, second: Side) -> list[InputDifference]:
    """Keys whose values differ, in the order of the scene."""
    keys = dict.fromkeys((*first.inputs, *second.inputs))
    found = [InputDifference(k, first.inputs.get(k, ""), second.inputs.get(k, "")) for k in keys]
    return [each for each in found if each.first != each.second]


def answer_differences(first: Side, second: Side) -> list[AnswerDifference]:
    """Largest difference of every quantity and model that both have."""
    return list(_differences(first, second))


def _differences(first: Side, second: Side) -> Iterator[AnswerDifference]:
    groups: dict[tuple[str, str], list[Key]] = {}
    for key in dict.fromkeys((*first.numbers, *second.numbers)):
        groups.setdefault((key.quantity, key.model), []).append(key)
    for (quantity, model), keys in groups.items():
        both = [key for key in keys if key in first.numbers and key in second.numbers]
        only = (
            sum(key not in second.numbers for key in keys),
            sum(key not in first.numbers for key in keys),
        )
        if not both:
            continue
        pairs = [(first.numbers[key], second.numbers[key]) for key in both]
        beyond = [_beyond(*pair) for pair in pairs]
        weight = [(out, abs(_relative(*pair))) for out, pair in zip(beyond, pairs, strict=True)]
        worst = max(range(len(both)), key=weight.__getitem__)
        yield AnswerDifference(
            quantity, model, len(both), sum(beyond), only, both[worst], *pairs[worst]
        )


def _beyond(first: Number, second: Number) -> bool:
    """Whether two numbers differ by more than both bars together."""
    if _unknown(first) or _unknown(second):
        return _unknown(first) != _unknown(second)
    rounding = _ROUNDING * max(abs(first.value), abs(second.value))
    bars = sum(0.0 if math.isnan(each.error) else each.error for each in (first, second))
    return bool(abs(first.value - second.value) > bars + rounding)


def _unknown(number: Number) -> bool:
    return bool(np.isnan(number.value))


def _relative(first: Number, second: Number) -> float:
    if _unknown(first) or _unknown(second):
        return 0.0
    before, after = (
        (each.value.real if each.value.imag == 0.0 else abs(each.value)) for each in (first, second)
    )
    if before == after:
        return abs(first.value - second.value) / abs(before) if before else 0.0
    return after / before - 1.0 if before else math.inf


#: Where no quantity of the one is one of the other by the same model.
NOTHING_SHARED = (
    "no answer is on both sides; ask both for one quantity by one model (of scenes with --quantity "
    "and --model, of studies where tactgen whatif makes them)"
)


def lines(
    sides: tuple[Side, ...], inputs: list[InputDifference], answers: list[AnswerDifference]
) -> list[str]:
    """Lines of the comparison, input first."""
    first, second = sides
    found = [f"A: {first.name}", f"B: {second.name}", ""]
    found.append("input that differs:" if inputs else "the input is the same")
    table = [("key", "A", "B"), *((i.key, i.first or "-", i.second or "-") for i in inputs)]
    found += _aligned(table) if inputs else []
    lacking = [(side.name, len(side.missing)) for side in sides if side.missing]
    unanswered = [f"{name} has no answer to {count} questions" for name, count in lacking]
    if not answers:
        return [*found, "", NOTHING_SHARED, *unanswered]
    found += ["", "answers, where they differ most:"]
    rows = [("quantity", "model", "at", "A", "B", "change", "")]
    rows += [
        (d.quantity, d.model, place(d.key), format_number(d.first), format_number(d.second),
            percent(d.relative),
         d.verdict + _only(d))
        for d in answers
    ]  # fmt: skip
    return [*found, *_aligned(rows), *unanswered]


def place(key: Key) -> str:
    """Where a number is: the point, frequency, index."""
    parts = [_coordinate(heading.partition(" (")[0], value) for heading, value in key.point]
    parts += [f"{_short(key.frequency)} Hz"] if key.frequency else []
    parts += [f"no. {key.number}"] if key.number else []
    return ", ".join(parts)


def format_number(number: Number) -> str:
    """Number with its bar; of complex ones the magnitude."""
    value = number.value.real if number.value.imag == 0.0 else abs(number.value)
    return with_error(value, number.error, number.unit)


def as_values(
    sides: tuple[Side, ...], inputs: list[InputDifference], answers: list[AnswerDifference]
) -> dict[str, Any]:
    """Comparison as plain JSON values, SI units."""
    return {
        "a": sides[0].name, "b": sides[1].name,
        "inputs": [{"key": i.key, "a": i.first, "b": i.second} for i in inputs],
        "answers": [
            {"quantity": d.quantity, "model": d.model, "values": d.count,
             "beyond_bars": d.beyond, "only": list(d.only), "at": place(d.key),
             "a": _pair(d.first.value), "b": _pair(d.second.value),
             "uncertainty_a": _known(d.first.error), "uncertainty_b": _known(d.second.error),
             "unit": d.first.unit, "change": _known(d.relative), "verdict": d.verdict}
            for d in answers
        ],
        "missing": [len(side.missing) for side in sides],
    }  # fmt: skip


def _only(d: AnswerDifference) -> str:
    words = [f"{n} only in {side}" for n, side in zip(d.only, "AB", strict=True) if n]
    return f" ({', '.join(words)})" if words else ""


def _coordinate(key: str, value: str) -> str:
    """Axis' key with its value as people write it."""
    field = scene_field(key)
    return f"{key} {field.show(float(value)) if field.numeric else value}"


def _short(number: str) -> str:
    try:
        return f"{float(number):.6g}"
    except ValueError:
        return number


def _pair(value: complex) -> Any:
    if value != value:
        return None
    return value.real if value.imag == 0.0 else [value.real, value.imag]


def _known(value: float) -> float | None:
    return value if abs(value) < float("inf") else None


def _aligned(rows: Sequence[Sequence[str]]) -> list[str]:
    widths = [max(len(row[n]) for row in rows) for n in range(len(rows[0]))]
    return [
        "  "
        + "  ".join(cell.ljust(width) for cell, width in zip(row, widths, strict=True)).rstrip()
        for row in rows
    ]
