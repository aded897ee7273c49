"""One screen of an answer: the numbers that matter, models side by side, and where more is."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from tactgen.geometry.formats import engineering, share
from tactgen.validation.catalogue.models import ranked
from tactgen.validation.catalogue.quantities import QUANTITIES, Actuator
from tactgen.validation.engine.solve import Solution
from tactgen.validation.models.model import Quantity

#: Error bars below this share of their value are not shown.
_FINE = 1e-5
#: What each part of the screen is about.
_TITLES: dict[Actuator, str] = {
    "bimorph": "bimorph", "reluctance": "normal actuator", "generator": "machine, small motions",
    "display": "display",
}  # fmt: skip
#: Classes of listed entries that go without saying.
_USUAL = ("bending_x", "decays")
#: Entries that are shown of each list.
_ORDINALS = ("first", "second")


@dataclass(frozen=True)
class _Part:
    """Rows of one actuator: title and models, then label and cells; those all 0."""

    rows: tuple[tuple[str, ...], ...]
    idle: tuple[str, ...]


def print_overview(solution: Solution) -> None:
    """Print the main quantities, one row each, and how to see the others.

    Where a scene is about several of bimorph, normal actuator and machine, each has a part.
    """
    parts = [part for actuator in _TITLES if (part := _part(actuator, solution)).rows]
    labels = max(len(row[0]) for part in parts for row in part.rows)
    for number, part in enumerate(parts):
        head, *body = part.rows
        _print_rows([head if len(parts) > 1 else ("", *head[1:]), *body], labels)
        if part.idle:
            why = "by symmetry, or without voltage, current, coupling or load"
            print(f"0 {why}: {', '.join(part.idle)}")
        if number < len(parts) - 1:
            print()
    print(
        f"\n± is the numerical error, left out below {100 * _FINE:g} %.  More: --quantity all or "
        "NAME for every value,\n--json for all frequencies, tactgen report for why models differ"
    )


def _print_rows(rows: Sequence[tuple[str, ...]], labels: int) -> None:
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    for label, *cells in rows:
        padded = (c.rjust(width) for c, width in zip(cells, widths[1:], strict=True))
        print("  ".join([label.ljust(labels), *padded]).rstrip())


def _part(actuator: Actuator, solution: Solution) -> _Part:
    """Rows about an actuator; none if none of its quantities is asked for."""
    asked = [
        q
        for q in solution.quantities
        # those that are no matrix
        if QUANTITIES[q.name].actuator == actuator and q.value.ndim < 2
    ]
    models = ranked({q.model for q in asked})
    names = list(dict.fromkeys(q.name for q in asked))
    idle = [n for n in names if all(_is_nothing(q) for q in solution.by_model(n).values())]
    rows = [row for n in names if n not in idle for row in _rows(n, solution, models)]
    head = [(_TITLES[actuator], *models)] if asked else []
    return _Part(
        (*head, *((label, *cells) for label, cells in rows)),
        tuple(QUANTITIES[n].label for n in idle),
    )


def _is_nothing(q: Quantity) -> bool:
    """Whether a response is 0 at every frequency."""
    return q.frequency is not None and not q.value.any()


def _rows(name: str, solution: Solution, models: list[str]) -> list[tuple[str, list[str]]]:
    """Label and cells of a quantity: a number, the first of a list, or the largest value."""
    found, label = solution.by_model(name), QUANTITIES[name].label
    first = next(iter(found.values()))
    if all(q.value.ndim == 0 for q in found.values()):
        return [(label, [_cell(found.get(m), ()) for m in models])]
    if first.classes is not None:
        # of a pair of poles one says it all
        listed = np.flatnonzero(np.imag(first.value) >= 0.0)[: len(_ORDINALS)].tolist()
        labels = [label.replace("first", ordinal) for ordinal in _ORDINALS]
        if "first" not in label:
            labels[1:] = [""] * (len(_ORDINALS) - 1)
        return [
            (text, [_cell(found.get(m), i, of_class=True) for m in models])
            for text, i in zip(labels, listed, strict=False)
        ]
    sizes = np.abs(first.value)
    if not np.isfinite(sizes).any():
        return []
    at = int(np.nanargmax(sizes))
    several = ", largest" if sizes.size > 1 else ""
    where = engineering((first.frequency or ())[at], "Hz", 4)
    return [(f"{label}{several} at {where}", [_cell(found.get(m), at) for m in models])]


def _cell(q: Quantity | None, at: int | tuple[()], *, of_class: bool = False) -> str:
    """One value with its unit and error bar, nothing where the model has none."""
    if q is None or (isinstance(at, int) and at >= q.value.size):
        return ""
    number = complex(q.value[at])
    value, bar = abs(number), float(q.error[at])
    if not np.iscomplexobj(q.value):
        value = float(q.value[at])
    if math.isnan(value):
        return "no value"
    text = _pole(number) if q.unit == "rad/s" else engineering(value, q.unit)
    if of_class and q.classes and isinstance(at, int) and q.classes[at] not in _USUAL:
        text += f" {q.classes[at].replace('bending_', '')}"
    if not value:
        return f"{text} ±{engineering(bar, q.unit, 2)}" if bar else text
    relative = abs(bar / value)
    return f"{text} ±{share(relative)}" if relative >= _FINE else text


def _pole(value: complex) -> str:
    """Pole (rad/s) as its natural frequency and damping ratio, or its rate of decay."""
    if not value.imag:
        return engineering(-value.real, "1/s")
    natural = engineering(abs(value) / (2.0 * math.pi), "Hz")
    return f"{natural} ζ {-value.real / abs(value):.2g}"
