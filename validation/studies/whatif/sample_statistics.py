"""Statistics of drawn points: mean, standard deviation, percentiles of each quantity by model."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from tactgen.geometry.csv_tables import write_csv
from tactgen.geometry.formats import engineering
from tactgen.validation.studies.whatif.axes import shown_value
from tactgen.validation.studies.whatif.output_files import aligned, column, heading
from tactgen.validation.studies.whatif.study import Study

#: File in a study's folder.
FILE = "statistics.csv"
#: The percentiles (%).
PERCENTILES = (5, 50, 95)


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
    stepped = [axis.label for axis in study.statement.axes if axis.drawn is None]
    head = ("quantity", "number", "model", "samples", "mean", "standard_deviation",
            *(f"percentile_{p}" for p in PERCENTILES), "unit")  # fmt: skip
    rows = (
        (*one.at.values(), one.quantity, one.what, one.model, one.count, one.mean,
         None if np.isnan(one.deviation) else one.deviation, *one.percentiles, one.unit)
        for one in found
    )  # fmt: skip
    return write_csv(folder / FILE, (*stepped, *head), rows)
