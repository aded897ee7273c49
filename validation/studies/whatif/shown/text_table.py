"""A study as a table on the terminal: one line a point and model, one column a quantity."""

from __future__ import annotations

import numpy as np

from tactgen.validation.catalogue.models import gives
from tactgen.validation.engine.answers import Answer, representative
from tactgen.validation.studies.whatif.asked.scene_field import scene_field
from tactgen.validation.studies.whatif.run import Study

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
    """Return a quantity's name with what is shown of it."""
    for _, _, answer in study.rows:
        for q in answer.quantities:
            if q.name == name:
                return ", ".join(part for part in (name, representative(q).what) if part)
    return name


def _cells(model: str, answer: Answer, quantities: tuple[str, ...]) -> list[str]:
    by_name = {q.name: q for q in answer.quantities}
    return [
        representative(by_name[name]).text if name in by_name
        else answer.status if gives(model, name) else "-"
        for name in quantities
    ]  # fmt: skip
