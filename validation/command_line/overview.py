"""One screen of an answer: the numbers that matter, models side by side, and where more is."""

from __future__ import annotations

import math

import numpy as np

from tactgen.validation.catalogue.models import ranked
from tactgen.validation.catalogue.quantities import QUANTITIES
from tactgen.validation.engine.results import Quantity
from tactgen.validation.engine.solve import Solution
from tactgen.validation.view.formats import engineering, share

#: Error bars below this share of their value are not shown.
_FINE = 1e-5
#: Modes that are shown of each list.
_ORDINALS = ("first", "second")


def print_overview(solution: Solution) -> None:
    """Print the main quantities, one row each, and how to see the others."""
    models = [m for a in ("bimorph", "reluctance") for m in ranked(solution.models_of(a))]
    rows = [row for name in _names(solution) for row in _rows(name, solution, models)]
    table = [["", *models], *([label, *cells] for label, cells in rows)]
    widths = [max(len(line[i]) for line in table) for i in range(len(models) + 1)]
    for line in table:
        print(
            "  ".join(
                text.rjust(width) if i else text.ljust(width)
                for i, (text, width) in enumerate(zip(line, widths, strict=True))
            ).rstrip()
        )
    print(
        f"\n± is the numerical error, left out below {100 * _FINE:g} %.  More: --quantity all or "
        "NAME for every value,\n--json for all frequencies, tactgen report for why models differ"
    )


def _names(solution: Solution) -> list[str]:
    """Return the quantities of the solution, those that are no matrix."""
    names = dict.fromkeys(q.name for q in solution.quantities if q.value.ndim < 2)
    return list(names)


def _rows(name: str, solution: Solution, models: list[str]) -> list[tuple[str, list[str]]]:
    """Return label and cells of a quantity: a number, the lowest modes, or the largest value."""
    found, label = solution.by_model(name), QUANTITIES[name].label
    if all(q.value.ndim == 0 for q in found.values()):
        return [(label, [_cell(found.get(m), ()) for m in models])]
    if all(q.classes is not None for q in found.values()):
        count = min(len(_ORDINALS), max(q.value.size for q in found.values()))
        return [
            (
                label.replace("first", _ORDINALS[i]),
                [_cell(found.get(m), i, of_class=True) for m in models],
            )
            for i in range(count)
        ]
    first = next(iter(found.values()))
    sizes = np.abs(first.value)
    if not np.isfinite(sizes).any():
        return []
    at = int(np.nanargmax(sizes))
    where = (first.frequency or ())[at]
    several = ", largest" if sizes.size > 1 else ""
    return [
        (f"{label}{several} at {engineering(where, 'Hz', 4)}",
         [_cell(found.get(m), at) for m in models])
    ]  # fmt: skip


def _cell(q: Quantity | None, at: int | tuple[()], *, of_class: bool = False) -> str:
    """Return one value with its unit and error bar, nothing where the model has none."""
    if q is None or (isinstance(at, int) and at >= q.value.size):
        return ""
    value, bar = abs(complex(q.value[at])), float(q.uncertainty[at])
    if not np.iscomplexobj(q.value):
        value = float(q.value[at])
    if math.isnan(value):
        return "no value"
    text = engineering(value, q.unit)
    if of_class and q.classes and isinstance(at, int) and q.classes[at] != "bending_x":
        text += f" {q.classes[at].replace('bending_', '')}"
    relative = abs(bar / value) if value else 0.0
    return f"{text} ±{share(relative)}" if relative >= _FINE else text
