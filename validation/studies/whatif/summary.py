"""A study as a table on the terminal: one line a point and model, one column a quantity."""

from __future__ import annotations

from typing import Any

import numpy as np

from tactgen.validation.catalogue.models import gives
from tactgen.validation.engine.results import Quantity
from tactgen.validation.studies.whatif.answers import Answer
from tactgen.validation.studies.whatif.run import Study
from tactgen.validation.studies.whatif.scene_field import scene_field
from tactgen.validation.view.formats import engineering, with_bar

#: Lines that are shown; of longer studies evenly spaced ones.
_SHOWN = 60


def table_lines(study: Study) -> list[str]:
    """Return the table's lines; of modes the first, of a response its largest magnitude."""
    quantities = study.statement.quantities
    axes = study.statement.axes
    rows = list(study.rows)
    picked = np.unique(np.linspace(0, len(rows) - 1, min(len(rows), _SHOWN)).astype(int))
    lines = [[*(axis.key for axis in axes), "model", *(heading(study, q) for q in quantities)]]
    for number in picked:
        point, model, answer = rows[number]
        at = [scene_field(key).show(value) for key, value in point.items()]
        lines.append([*at, model, *_cells(model, answer, quantities)])
    widths = [max(len(line[n]) for line in lines) for n in range(len(lines[0]))]
    found = [
        "  ".join(cell.rjust(width) for cell, width in zip(line, widths, strict=True))
        for line in lines
    ]
    if len(picked) < len(rows):
        found.append(f"{len(picked)} of {len(rows)} lines are shown; --out STUDY writes all")
    return found


def heading(study: Study, name: str) -> str:
    """Return what is shown of a quantity."""
    for _, _, answer in study.rows:
        for q in answer.quantities:
            if q.name == name:
                if q.value.ndim > 1:
                    return f"{name}, largest entry"
                if q.frequency is not None and q.value.size > 1:
                    return f"{name}, largest"
                return name if q.value.ndim == 0 or q.frequency else f"{name}, first"
    return name


def _cells(model: str, answer: Answer, quantities: tuple[str, ...]) -> list[str]:
    by_name = {q.name: q for q in answer.quantities}
    return [
        shown(by_name[name]) if name in by_name
        else answer.status if gives(model, name) else "-"
        for name in quantities
    ]  # fmt: skip


def shown(q: Quantity) -> str:
    """Return one number that stands for a quantity, with its bar."""
    if q.value.ndim == 0 or q.frequency is None:
        place: Any = (0,) * q.value.ndim
        return with_bar(float(q.value[place]), float(q.uncertainty[place]), q.unit)
    size = np.abs(q.value)
    if not np.isfinite(size).any():
        return "no value"
    place = np.unravel_index(int(np.nanargmax(size)), size.shape)
    at = f" at {q.frequency[place[0]]:g} Hz" if size.size > 1 else ""
    bar = float(np.broadcast_to(q.uncertainty, size.shape)[place])
    if q.value.ndim > 1:
        return f"{engineering(float(size[place]), q.unit)}{at}"
    return with_bar(float(size[place]), bar, q.unit) + at
