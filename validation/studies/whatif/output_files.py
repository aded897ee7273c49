"""Files of a study: a tidy table (CSV) and arrays over its axes (netCDF 3)."""

from __future__ import annotations

import hashlib
import json
import math
from collections.abc import Callable, Sequence
from importlib.metadata import version
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

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
TABLE, ARRAYS = "study.csv", "study.nc"
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
