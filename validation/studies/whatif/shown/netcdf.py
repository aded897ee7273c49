"""A study as a netCDF file (version 3), which xarray and most other tools open.

Real and imaginary parts are apart, since netCDF knows no complex numbers.
"""

from __future__ import annotations

import hashlib
import json
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np

from tactgen.geometry.files import written_whole
from tactgen.validation.catalogue.models import MODELS
from tactgen.validation.studies.whatif.answers import code_of
from tactgen.validation.studies.whatif.asked.statement import FORMAT
from tactgen.validation.studies.whatif.run import Study
from tactgen.validation.studies.whatif.shown.dataset import STATUSES, Dataset, Variable, dataset

#: File of the arrays in a study's folder.
FILE = "study.nc"
#: What the global attribute `title` says.
TITLE = "tactgen what-if study"
#: Libraries whose versions are written down.
_LIBRARIES = ("tactgen", "numpy", "scipy", "scikit-fem")


def write_netcdf(folder: Path, study: Study) -> Path:
    """Write the study's arrays with units, bars and provenance, whole or not at all.

    Raises
    ------
    InputError
        If the file cannot be written.
    """
    from scipy.io import netcdf_file  # slow to import

    path, found = folder / FILE, dataset(study)
    with written_whole(path) as temporary, netcdf_file(str(temporary), "w", version=2) as file:
        for name, text in _provenance(study).items():
            setattr(file, name, text.encode())
        dimensions: dict[str, int] = {}
        for variable in (*found.coordinates.values(), *found.variables.values(), found.status):
            dimensions.update(zip(variable.dimensions, variable.values.shape, strict=True))
        for name, size in dimensions.items():
            file.createDimension(name, size)
        for name, variable in found.coordinates.items():
            _add(file, name, variable)
        auxiliary = " ".join(key for key, v in found.coordinates.items() if (key,) != v.dimensions)
        for name, variable in _parts(found).items():
            made = _add(file, name, variable)
            if auxiliary:
                made.coordinates = auxiliary.encode()
    return path


def _parts(found: Dataset) -> dict[str, Variable]:
    """Return the variables with real and imaginary parts apart."""
    parts: dict[str, Variable] = {}
    for name, v in found.variables.items():
        if np.iscomplexobj(v.values):
            for part, values in (("re", v.values.real), ("im", v.values.imag)):
                words = f"{'real' if part == 're' else 'imaginary'} part: {v.meaning}"
                parts[f"{name}_{part}"] = Variable(v.dimensions, values, v.unit, words)
        else:
            parts[name] = v
    return parts | {"status": found.status, "reason": found.reason, "seconds": found.seconds}


def _add(file: Any, name: str, variable: Variable) -> Any:
    """Add a variable to an open file."""
    values, dimensions = variable.values, variable.dimensions
    if values.dtype.kind == "U":
        values, dimensions = _characters(file, name, values, dimensions)
        made = file.createVariable(name, "S1", dimensions)
        made._Encoding = b"utf-8"
    else:
        kind = {"f": "f8", "i": "i4"}[values.dtype.kind] if values.dtype != np.int8 else "i1"
        made = file.createVariable(name, kind, dimensions)
    made[:] = values
    made.long_name = variable.meaning.encode()
    if variable.unit:
        made.units = variable.unit.encode()
    if name == "status":
        made.flag_values = np.arange(len(STATUSES), dtype=np.int8)
        made.flag_meanings = " ".join(STATUSES).encode()
    return made


def _characters(
    file: Any, name: str, values: Any, dimensions: tuple[str, ...]
) -> tuple[Any, tuple[str, ...]]:
    """Return texts as arrays of single characters, which is all that netCDF 3 knows."""
    encoded = np.char.encode(values, "utf-8")
    length = max(1, encoded.dtype.itemsize)
    file.createDimension(f"{name}_length", length)
    characters = encoded.astype(f"S{length}")[..., None].view("S1")
    return characters, (*dimensions, f"{name}_length")


def _provenance(study: Study) -> dict[str, str]:
    """Return what the numbers were made from and by."""
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
