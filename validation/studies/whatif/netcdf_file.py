"""A study as arrays over its axes, and their file (netCDF 3)."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable, Sequence
from importlib.metadata import version
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from tactgen.geometry.files import written_whole
from tactgen.validation.catalogue.models import MODELS
from tactgen.validation.catalogue.quantities import QUANTITIES
from tactgen.validation.engine.answers import Array
from tactgen.validation.models.model import Quantity
from tactgen.validation.studies.whatif.definition import FORMAT, Statement
from tactgen.validation.studies.whatif.point_answers import code_of
from tactgen.validation.studies.whatif.study import Study

if TYPE_CHECKING:
    from xarray import Dataset

#: File in a study's folder.
FILE = "study.nc"
#: Statuses by their number in the file.
_STATUSES = ("ok", "failed", "refused")
#: Libraries whose versions are written down.
_LIBRARIES = ("tactgen", "numpy", "scipy", "scikit-fem")
_COUNTED = "number, from 1, of the mode or of the row or column of the port matrix"

#: An array with the names of its dimensions, its unit and its meaning.
Variable = tuple[tuple[str, ...], Array, dict[str, Any]]
#: A quantity by model and point; None where it has no answer.
_Found = list[list[Quantity | None]]


def _variable(dimensions: tuple[str, ...], values: Any, meaning: str, unit: str = "") -> Variable:
    """Array over named dimensions, as xarray takes it."""
    words = {"long_name": meaning} | ({"units": unit} if unit else {})
    return dimensions, np.asarray(values), words


def dataset(study: Study) -> Dataset:
    """Answers over model, the axes' dimensions and their own; nan where there is none.

    With errors as ``NAME_uncertainty``, `status` (its number), `reason` and `seconds`.
    """
    from xarray import Dataset  # slow to import

    stated, models = study.statement, study.statement.models
    coordinates = _axes(stated) | {"model": _variable(("model",), models, "model")}
    variables: dict[str, Variable] = {}

    def add(name: str, values: Any, meaning: str, unit: str = "", own: Sequence[str] = ()) -> None:
        sizes = (len(models), *stated.shape.values(), *np.shape(values)[2:])
        dimensions = ("model", *stated.shape, *own)
        variables[name] = _variable(dimensions, np.reshape(values, sizes), meaning, unit)

    for name in stated.quantities:
        found = [[at[m].get(name) for at in study.answers] for m in models]
        first = next((q for each in found for q in each if q is not None), None)
        if first is None:
            continue
        own: tuple[str, ...] = ("frequency", "effort", "motion")
        own = (("mode",) if first.frequency is None else own)[: first.value.ndim]
        varied = own[:1] == ("frequency",) and "frequency" in stated.columns
        for part, (values, meaning, unit) in _parts(name, found).items():
            add(part, values[:, :, 0] if varied else values, meaning, unit, own[varied:])
        inner = variables[name][1].shape[1 + len(stated.shape) :]
        for key, size in zip(own[varied:], inner, strict=True):
            if key == "frequency":
                frequencies = first.frequency
                coordinates[key] = _variable((key,), frequencies, "frequency of the drive", "Hz")
            elif key not in coordinates or coordinates[key][1].size < size:
                coordinates[key] = _variable((key,), np.arange(1, size + 1), _COUNTED)
    every = [[at[m] for at in study.answers] for m in models]
    status = np.array([[_STATUSES.index(a.status) for a in each] for each in every], np.int8)
    add("status", status, "whether answered")
    flags = np.arange(len(_STATUSES), dtype=np.int8)
    variables["status"][2].update(flag_values=flags, flag_meanings=" ".join(_STATUSES))
    add("reason", [[a.reason for a in each] for each in every], "why there is no answer")
    cost = "cost of the answer when it was computed"
    add("seconds", [[a.seconds for a in each] for each in every], cost, "s")
    return Dataset(variables, coordinates)


def _axes(stated: Statement) -> dict[str, Variable]:
    """Coordinates by scene key."""
    found = {}
    for axis in stated.axes:
        dimension, column = stated.columns[axis.key]
        values = np.array(column, dtype=None if axis.numeric else np.str_)
        found[axis.key] = _variable((dimension,), values, f"scene key {axis.key}", axis.unit)
    return found


def _parts(name: str, found: _Found) -> dict[str, tuple[Array, str, str]]:
    """A quantity and its errors, and classes if it has any, with their meanings and units."""
    row = QUANTITIES[name]
    bars = f"numerical error bar of {name}, absolute, of the magnitude"
    beside = f"modelling error of {name}, absolute, beside the most detailed model"
    parts = {
        name: (_filled(found, lambda q: q.value), row.meaning, row.unit),
        f"{name}_uncertainty": (_filled(found, lambda q: q.error), bars, row.unit),
        f"{name}_modelling_error": (
            _filled(found, lambda q: q.modelling_error), beside, row.unit,
        ),
    }  # fmt: skip
    if any(q.classes for each in found for q in each if q is not None):
        kinds = _filled(found, lambda q: q.classes or "", "")
        parts[f"{name}_class"] = kinds, "class of the mode's motion", ""
    return parts


def _filled(found: _Found, of: Callable[[Quantity], Any], nothing: Any = np.nan) -> Array:
    """Something of the values of a quantity over model and point, `nothing` where none is."""
    known: list[tuple[Any, tuple[int, ...], Array]] = [
        ((m, n, *map(slice, q.value.shape)), q.value.shape, np.asarray(of(q)))
        for m, each in enumerate(found) for n, q in enumerate(each) if q is not None
    ]  # fmt: skip
    inner = (max(sizes) for sizes in zip(*(shape for _, shape, _ in known), strict=True))
    kind = np.result_type(*(values for *_, values in known))
    whole = np.full((len(found), len(found[0]), *inner), nothing, kind)
    for place, _, values in known:
        whole[place] = values
    return whole


def write_netcdf(folder: Path, study: Study) -> Path:
    """Write the study's arrays with units, errors and provenance, whole or not at all.

    Real and imaginary parts apart: netCDF knows no complex numbers.

    Raises InputError if the file cannot be written.
    """
    found = dataset(study)
    for name, values in found.data_vars.items():
        if np.iscomplexobj(values):
            parts = {f"{name}_re": values.real, f"{name}_im": values.imag}
            found = found.drop_vars([name]).assign(
                {part: of.assign_attrs(values.attrs) for part, of in parts.items()}
            )
    with written_whole(folder / FILE) as temporary:
        found.assign_attrs(_provenance(study)).to_netcdf(temporary, engine="scipy")
    return folder / FILE


def _provenance(study: Study) -> dict[str, str]:
    """Provenance of the numbers."""
    stated = study.statement
    scene = json.dumps(stated.values, sort_keys=True, default=str)
    return {
        "title": "tactgen what-if study",
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
