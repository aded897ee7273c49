"""One screen of an answer: the numbers that matter, models side by side, and where more is."""

from __future__ import annotations

import math

import numpy as np

from tactgen.geometry.formats import FINE, engineering, with_share
from tactgen.validation.catalogue.models import ranked
from tactgen.validation.catalogue.quantities import QUANTITIES, Actuator
from tactgen.validation.engine.answers import (
    NONE,
    Representative,
    bracketed,
    class_suffix,
    modelling_at,
    representative,
)
from tactgen.validation.engine.solve import Solution
from tactgen.validation.models.model import Quantity

#: What each part of the screen is about.
_TITLES: dict[Actuator, str] = {
    "bimorph": "bimorph", "reluctance": "normal actuator", "generator": "machine, small motions",
    "display": "display",
}  # fmt: skip
#: Entries that are shown of each list.
_ORDINALS = ("first", "second")


def print_overview(solution: Solution) -> None:
    """Print the main quantities, one row each, and how to see the others.

    Where a scene is about several of bimorph, normal actuator and machine, each has a part.
    """
    parts = {a: rows for a in _TITLES if len(rows := _part(a, solution)) > 1}
    labels = max(len(row[0]) for rows in parts.values() for row in rows)
    for actuator, rows in parts.items():
        if len(parts) == 1:
            rows[0][0] = ""
        widths = [labels, *(max(map(len, column)) for column in list(zip(*rows, strict=True))[1:])]
        for label, *cells in rows:
            padded = (cell.rjust(width) for cell, width in zip(cells, widths[1:], strict=True))
            print("  ".join([label.ljust(labels), *padded]).rstrip())
        if idle := ", ".join(QUANTITIES[n].label for n in _idle(actuator, solution)):
            print(f"0 by symmetry, or without voltage, current, coupling or load: {idle}")
        print()
    if any(q.extreme is not None for q in solution.quantities):
        print("The largest and least values are at each model's own resonance.")
    print(
        f"± is the numerical error (not shown below {100 * FINE:g} %). In brackets: modelling\n"
        "error, the known difference from the most detailed model ± its own error; (?) not known.\n"
        "For all values: --quantity all or NAME; for all frequencies: --json; for the causes of\n"
        "differences: tactgen report"
    )


def _part(actuator: Actuator, solution: Solution) -> list[list[str]]:
    """Title and models of an actuator, then label and cells of its quantities."""
    asked = _asked(actuator, solution)
    models = ranked({q.model for q in asked})
    names = dict.fromkeys(q.name for q in asked)
    idle = _idle(actuator, solution)
    rows = [row for name in names if name not in idle for row in _rows(name, solution, models)]
    return [[_TITLES[actuator], *models], *([label, *cells] for label, cells in rows)]


def _asked(actuator: Actuator, solution: Solution) -> list[Quantity]:
    """Quantities of an actuator that are no matrix."""
    found = solution.quantities
    return [q for q in found if QUANTITIES[q.name].actuator == actuator and q.value.ndim < 2]


def _idle(actuator: Actuator, solution: Solution) -> list[str]:
    """Responses that are 0 at every frequency by every model."""
    moved = {q.name for q in solution.quantities if q.frequency is None or q.value.any()}
    return [n for n in dict.fromkeys(q.name for q in _asked(actuator, solution)) if n not in moved]


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
    shown = {m: representative(q) for m, q in found.items()}
    places = sorted(r.at for r in shown.values() if r.at is not None)
    if all(math.isnan(r.value) for r in shown.values()):
        return []
    if not places:
        where = engineering((first.frequency or (0.0,))[0], "Hz", 4)
        return [(f"{label} at {where}", [_cell(found.get(m), 0) for m in models])]
    what = next(r.what for r in shown.values())
    where = " to ".join(dict.fromkeys(engineering(f, "Hz", 4) for f in (places[0], places[-1])))
    return [(f"{label}, {what} at {where}", [_value(shown.get(m)) for m in models])]


def _value(found: Representative | None) -> str:
    """Largest value over a band with its numerical error, nothing where the model has none."""
    if found is None:
        return ""
    return with_share(found.value, found.error, found.unit) + bracketed(found.modelling)


def _cell(q: Quantity | None, at: int | tuple[()], *, of_class: bool = False) -> str:
    """One value with its unit and error bar, nothing where the model has none."""
    if q is None or (isinstance(at, int) and at >= q.value.size):
        return ""
    number = complex(q.value[at])
    value, bar = abs(number), float(q.error[at])
    if not np.iscomplexobj(q.value):
        value = float(q.value[at])
    text = _pole(number) if q.unit == "rad/s" else engineering(value, q.unit)
    if of_class and isinstance(at, int):
        text += class_suffix(q, at)
    modelling = modelling_at(q, at) if value else NONE
    return with_share(value, bar, q.unit, text) + bracketed(modelling)


def _pole(value: complex) -> str:
    """Pole (rad/s) as its natural frequency and damping ratio, or its rate of decay."""
    if not value.imag:
        return engineering(-value.real, "1/s")
    natural = engineering(abs(value) / (2.0 * math.pi), "Hz")
    return f"{natural} ζ {-value.real / abs(value):.2g}"
