"""A comparison as lines on the terminal and as plain values."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from tactgen.geometry.formats import percent, with_bar
from tactgen.validation.studies.whatif.asked.scene_field import scene_field
from tactgen.validation.studies.whatif.compare.differences import AnswerDifference, InputDifference
from tactgen.validation.studies.whatif.compare.sides import Key, Number, Side

#: Where no quantity of the one is one of the other by the same model.
NOTHING_SHARED = (
    "no answer is on both sides; ask both for one quantity by one model (of scenes with --quantity "
    "and --model, of studies where tactgen whatif makes them)"
)


def lines(
    sides: tuple[Side, ...], inputs: list[InputDifference], answers: list[AnswerDifference]
) -> list[str]:
    """Return what differs, input first."""
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
        (d.quantity, d.model, place(d.key), shown(d.first), shown(d.second), percent(d.relative),
         d.verdict + _only(d))
        for d in answers
    ]  # fmt: skip
    return [*found, *_aligned(rows), *unanswered]


def place(key: Key) -> str:
    """Return where a number is: the point, frequency, index."""
    parts = [_coordinate(heading.partition(" (")[0], value) for heading, value in key.point]
    parts += [f"{_short(key.frequency)} Hz"] if key.frequency else []
    parts += [f"no. {key.number}"] if key.number else []
    return ", ".join(parts)


def shown(number: Number) -> str:
    """Return a number with its bar; of complex ones the magnitude."""
    value = number.value.real if number.value.imag == 0.0 else abs(number.value)
    return with_bar(value, number.error, number.unit)


def as_values(
    sides: tuple[Side, ...], inputs: list[InputDifference], answers: list[AnswerDifference]
) -> dict[str, Any]:
    """Return the comparison as plain JSON values, SI units."""
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
    """Return an axis' key with its value as people write it."""
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
