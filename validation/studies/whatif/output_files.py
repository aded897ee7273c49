"""Files of a study: a tidy table (CSV) and arrays over its axes (netCDF 3)."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterator
from importlib.metadata import version
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from tactgen.validation.catalogue.models import MODELS, gives
from tactgen.validation.engine import answers
from tactgen.validation.engine.answers import Answer, representative
from tactgen.validation.studies.whatif.definition import FORMAT
from tactgen.validation.studies.whatif.key_values import scene_field
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


def table(study: Study) -> Iterator[tuple[Any, ...]]:
    """Yield the values of a point's axes and every number there."""
    for point, model, answer in study.rows:
        for row in answers.rows(model, study.statement.quantities, answer):
            yield (*point.values(), *row)


def write_tidy(folder: Path, study: Study) -> Path:
    """Write the table, whole or not at all."""
    return answers.write_csv(
        folder / TABLE, (axis.label for axis in study.statement.axes), table(study)
    )


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


#: Lines that are shown; of longer studies evenly spaced ones.
_SHOWN = 60


def table_lines(study: Study) -> list[str]:
    """Table's lines; of modes the first, of a response its largest magnitude."""
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
    """Heading of a quantity: name and representative."""
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
