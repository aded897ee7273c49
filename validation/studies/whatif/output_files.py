"""A study's numbers as files, table and JSON, and the statistics of drawn points.

Files are a tidy table (CSV), arrays over the axes (netCDF 3), and the statistics (CSV): mean,
standard deviation and percentiles of each quantity by model.
"""

from __future__ import annotations

import hashlib
import json
import math
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from importlib.metadata import version
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from tactgen.geometry.csv_tables import write_csv
from tactgen.geometry.formats import engineering
from tactgen.validation.catalogue.models import MODELS, gives
from tactgen.validation.engine import answers
from tactgen.validation.engine.answers import Representative, representative
from tactgen.validation.studies.whatif.axes import shown_value
from tactgen.validation.studies.whatif.definition import FORMAT
from tactgen.validation.studies.whatif.point_answers import code_of
from tactgen.validation.studies.whatif.study import Study

if TYPE_CHECKING:
    from xarray import Dataset

#: Files in a study's folder.
TABLE, ARRAYS, STATISTICS = "study.csv", "study.nc", "statistics.csv"
#: The percentiles of the statistics (%).
PERCENTILES = (5, 50, 95)
#: What the global attribute `title` says.
TITLE = "tactgen what-if study"
#: Libraries whose versions are written down.
_LIBRARIES = ("tactgen", "numpy", "scipy", "scikit-fem")


def write_tidy(folder: Path, study: Study) -> Path:
    """Write a point's axes with every number there, whole or not at all."""
    rows = (
        (*point.values(), *row)
        for point, model, answer in study.rows
        for row in answers.rows(model, study.statement.quantities, answer)
    )
    return answers.write_csv(folder / TABLE, (axis.label for axis in study.statement.axes), rows)


def dataset(study: Study) -> Dataset:
    """Study's arrays."""
    stated = study.statement
    axes = {
        axis.key: answers.variable(
            (dimension,), np.array(values, dtype=None if axis.numeric else np.str_),
            f"scene key {axis.key}", axis.unit,
        )
        for axis in stated.axes
        for dimension, values in (stated.columns[axis.key],)
    }  # fmt: skip
    by_model = [{m: at[m] for m in stated.models} for at in study.answers]
    return answers.dataset(axes, stated.shape, stated.quantities, by_model)


def write_netcdf(folder: Path, study: Study) -> Path:
    """Write the study's arrays with units, errors and provenance, whole or not at all.

    Raises InputError if the file cannot be written.
    """
    return answers.write_netcdf(folder / ARRAYS, dataset(study), _provenance(study))


def _provenance(study: Study) -> dict[str, str]:
    """Provenance of the numbers."""
    stated = study.statement
    scene = json.dumps(stated.values, sort_keys=True, default=str)
    return {
        "title": TITLE,
        "format": str(FORMAT),
        "conventions": "SI units; complex numbers are peak amplitudes, time factor e^(+j Omega t); "
        "NAME_uncertainty is the numerical error bar of NAME",
        "scene": stated.scene,
        "scene_values": scene,
        "scene_sha256": hashlib.sha256(scene.encode()).hexdigest(),
        "vary": "\n".join(stated.vary),
        "seed": str(stated.seed),
        "models": "\n".join(f"{name}: {MODELS[name].description}" for name in stated.models),
        "code_sha256": "\n".join(f"{name}: {code_of(name)}" for name in stated.models),
        "versions": ", ".join(f"{name} {version(name)}" for name in _LIBRARIES),
    }


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
    return [
        next((representative(q) for q in answers[model].quantities if q.name == name), None)
        for answers in study.answers
    ]


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
    stepped = [axis.label for axis in study.statement.axes if axis.drawn is None]
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
            {"at": point, "model": model, **answers.answer_json(answer)}
            for point, model, answer in study.rows
        ],
        "counts": {
            "points": len(study.points), "models": len(stated.models), **asdict(study.counts),
        },
    }  # fmt: skip
