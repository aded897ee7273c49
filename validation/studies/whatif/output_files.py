"""A study's numbers as tidy table (CSV), lines and JSON, and the statistics of drawn points (CSV).

Statistics are mean, standard deviation and percentiles of each quantity by model.
"""

from __future__ import annotations

import csv
import io
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from tactgen.geometry.csv_tables import write_csv
from tactgen.geometry.files import write_text
from tactgen.geometry.formats import engineering
from tactgen.validation.catalogue.models import gives
from tactgen.validation.catalogue.quantities import QUANTITIES
from tactgen.validation.engine.answers import (
    COLUMNS,
    Representative,
    quantity_json,
    quantity_rows,
    representative,
)
from tactgen.validation.studies.whatif.axes import scene_field, shown_value
from tactgen.validation.studies.whatif.study import Study

#: Files in a study's folder.
TABLE, STATISTICS = "study.csv", "statistics.csv"
#: The percentiles of the statistics (%).
PERCENTILES = (5, 50, 95)


def write_tidy(folder: Path, study: Study) -> Path:
    """Write a point's axes with every number there, whole or not at all (RFC 4180, UTF-8).

    Numbers are written so that reading gives the same double; what is missing is empty, and a
    quantity that is missing has one row.
    """
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow([*(scene_field(axis.key).label for axis in study.statement.axes), *COLUMNS])
    for point, model, answer in study.rows:
        for name in study.statement.quantities:
            found, unit = answer.get(name), QUANTITIES[name].unit
            none = name, model, *(None,) * 7, unit, answer.status, answer.reason
            for row in quantity_rows(found) if found else [none] if gives(model, name) else ():
                writer.writerow([*point.values(), *row])
    return write_text(folder / TABLE, text.getvalue())


#: Lines that are shown at most; of longer studies evenly spaced points by every model.
_SHOWN = 60


def table_lines(study: Study, rest: str) -> list[str]:
    """Table's lines; `rest` says where all points are, if some are left out."""
    heads, rows, left_out = table_rows(study)
    narrow = [head.replace(".", ".\n").replace(", ", ",\n") for head in heads]
    found = aligned([*headed(narrow), *rows], str.rjust)
    return [*found, f"{left_out}; {rest}"] if left_out else found


def table_rows(study: Study) -> tuple[list[str], list[list[str]], str]:
    """Table's headings and rows, and a sentence if points are left out.

    Of modes the first is shown, of a response its largest magnitude.
    """
    quantities, axes = study.statement.quantities, study.statement.axes
    heads = [*(a.key for a in axes), "model", *(heading(study, name) for name in quantities)]
    places, rows = _spaced_points(study), list[list[str]]()
    for place in places:
        at = [shown_value(key, value) for key, value in study.points[place].items()]
        for model, answer in study.answers[place].items():
            shown = {q.name: representative(q).text for q in answer.quantities}
            missing = {name: answer.status if gives(model, name) else "-" for name in quantities}
            rows.append([*at, model, *({**missing, **shown}[name] for name in quantities)])
    whole, shown_points = len(study.points), len(places)
    left_out = f"{shown_points} of {whole} points are shown" if shown_points < whole else ""
    return heads, rows, left_out


def _spaced_points(study: Study) -> list[int]:
    """Places of the points that are shown: every first, second, third ... along each dimension."""
    sizes = tuple(study.statement.shape.values())
    shown = [range(size) for size in sizes]
    most = max(1, _SHOWN // len(study.statement.models))
    while math.prod(map(len, shown)) > most:
        longest = max(range(len(shown)), key=lambda n: len(shown[n]))
        shown[longest] = range(0, sizes[longest], shown[longest].step + 1)
    places: list[int] = np.ravel_multi_index(np.ix_(*shown), sizes).ravel().tolist()
    return places


def headed(heads: Sequence[str]) -> list[list[str]]:
    """Rows of headings that have several lines each, the last at the bottom."""
    stacks = [head.split("\n") for head in heads]
    most = max(map(len, stacks))
    return [list(row) for row in zip(*([""] * (most - len(s)) + s for s in stacks), strict=True)]


def aligned(
    rows: Sequence[Sequence[str]], side: Callable[[str, int], str] = str.ljust
) -> list[str]:
    """Lines of a table whose columns are of one width."""
    widths = [max(map(len, cells)) for cells in zip(*rows, strict=True)]
    return ["  ".join(map(side, row, widths)).rstrip() for row in rows]


def column(study: Study, model: str, name: str) -> list[Representative | None]:
    """Number that stands for a quantity at each point; None where there is none."""
    every = (answers[model].get(name) for answers in study.answers)
    return [representative(q) if q else None for q in every]


def heading(study: Study, name: str) -> str:
    """Heading of a quantity: name and representative."""
    columns = (column(study, model, name) for model in study.statement.models)
    what = next((shown.what for each in columns for shown in each if shown), "")
    return f"{name}, {what}" if what else name


@dataclass(frozen=True)
class Statistics:
    """Statistics of one quantity by one model over the samples, SI units."""

    at: dict[str, Any]  #: Values of the axes that are not drawn
    quantity: str
    what: str  #: Number that stands for the quantity, as ``first`` or ``largest``
    model: str
    unit: str
    count: int  #: Samples with a value
    mean: float
    deviation: float  #: Standard deviation, nan of one sample
    percentiles: tuple[float, ...]  #: At :data:`PERCENTILES`


def sample_statistics(study: Study) -> list[Statistics]:
    """Statistics of every quantity by every model; nothing if no axis is drawn."""
    stated = study.statement
    if not stated.samples:
        return []
    stepped = [axis.key for axis in stated.axes if axis.drawn is None]
    groups: dict[tuple[Any, ...], list[int]] = {}
    for place, point in enumerate(study.points):
        groups.setdefault(tuple(point[key] for key in stepped), []).append(place)
    found = []
    for name in stated.quantities:
        for model in stated.models:
            shown = column(study, model, name)
            for values, places in groups.items():
                own = [s for place in places if (s := shown[place]) and np.isfinite(s.value)]
                if own:
                    sizes = [s.value for s in own]
                    found.append(Statistics(
                        dict(zip(stepped, values, strict=True)), name, own[0].what, model,
                        own[0].unit, len(sizes), float(np.mean(sizes)),
                        float(np.std(sizes, ddof=1)) if len(sizes) > 1 else np.nan,
                        tuple(map(float, np.percentile(sizes, PERCENTILES))),
                    ))  # fmt: skip
    return found


def statistics_lines(study: Study, found: Sequence[Statistics]) -> list[str]:
    """Table's lines; nothing if there are none."""
    if not found:
        return []
    heads, rows = statistics_rows(study, found)
    lines = aligned([heads, *rows], str.rjust)
    return ["statistics of the samples, with percentiles:", *lines]


def statistics_rows(study: Study, found: Sequence[Statistics]) -> tuple[list[str], list[list[str]]]:
    """Table's headings and rows."""
    heads = ["quantity", "model", "samples", "mean", "deviation", *(f"{p} %" for p in PERCENTILES)]
    rows = []
    for one in found:
        numbers = (one.mean, one.deviation, *one.percentiles)
        rows.append([
            *(shown_value(key, value) for key, value in one.at.items()),
            heading(study, one.quantity), one.model, str(one.count),
            *("-" if np.isnan(number) else engineering(number, one.unit) for number in numbers),
        ])  # fmt: skip
    return [*found[0].at, *heads], rows


def write_statistics(folder: Path, study: Study, found: Sequence[Statistics]) -> Path:
    """Write the statistics, whole or not at all."""
    axes = study.statement.axes
    stepped = [scene_field(axis.key).label for axis in axes if axis.drawn is None]
    head = ("quantity", "number", "model", "samples", "mean", "standard_deviation",
            *(f"percentile_{p}" for p in PERCENTILES), "unit")  # fmt: skip
    rows = (
        (*one.at.values(), one.quantity, one.what, one.model, one.count, one.mean,
         None if np.isnan(one.deviation) else one.deviation, *one.percentiles, one.unit)
        for one in found
    )  # fmt: skip
    return write_csv(folder / STATISTICS, (*stepped, *head), rows)


def as_json(study: Study) -> dict[str, Any]:
    """Study as plain JSON values, SI units."""
    stated = study.statement
    return {
        "scene": stated.scene,
        "conditions": stated.conditions,
        "axes": [
            {"key": a.key, "unit": a.unit, "dimension": stated.columns[a.key][0],
             "values": stated.columns[a.key][1]}
            for a in stated.axes
        ],
        "points": [
            {
                "at": point, "model": model, "status": answer.status, "reason": answer.reason,
                "seconds": answer.seconds,
                "quantities": [quantity_json(q) for q in answer.quantities],
                "warnings": list(answer.warnings),
            }
            for point, model, answer in study.rows
        ],
        "counts": {"points": len(study.points), "models": len(stated.models), **study.counts},
    }  # fmt: skip
