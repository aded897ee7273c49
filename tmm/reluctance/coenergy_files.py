"""Co-energy maps as netCDF files (version 3), which xarray and most other tools read.

A file holds the samples; reading fits the surface again, so there is one truth.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from tactgen.geometry.arrays import Floats
from tactgen.geometry.errors import InputError
from tactgen.geometry.files import written_whole
from tactgen.tmm.reluctance.coenergy_fit import fit
from tactgen.tmm.reluctance.coenergy_map import CoenergyMap, Samples

#: What the global attribute `title` says; files that say otherwise are refused.
TITLE = "co-energy map of a reluctance actuator"

#: Name, dimensions, unit and meaning of each variable.
_VARIABLES = (
    ("current", ("current",), "A", "current in the winding"),
    ("gap", ("gap",), "m", "working air gap"),
    ("flux_linkage", ("current", "gap"), "Wb", "flux linkage of the winding, dW'/di"),
    ("force", ("current", "gap"), "N", "pull, positive when it closes the gap, -dW'/dg"),
    ("coenergy", ("current", "gap"), "J", "magnetic co-energy W'"),
    ("incremental_inductance", ("current", "gap"), "H", "d(flux linkage)/d(current)"),
    ("force_error", ("current", "gap"), "N", "numerical error bar of the force"),
)
#: Those that not every model has.
_OPTIONAL = ("coenergy", "incremental_inductance", "force_error")


def write_map(path: str | Path, found: CoenergyMap) -> None:
    """Write a map's samples, with units and sign conventions, whole or not at all.

    Raises
    ------
    InputError
        If the file cannot be written.
    """
    from scipy.io import netcdf_file  # slow to import

    samples = found.samples
    with written_whole(path) as temporary, netcdf_file(str(temporary), "w") as file:
        file.title = TITLE
        file.conventions = (
            "SI units; samples of one co-energy W'(i, g); W' = 0 without current and even in it"
        )
        file.model = samples.model
        file.device = samples.device
        for name in ("current", "gap"):
            file.createDimension(name, getattr(samples, name).size)
        for name, dimensions, unit, meaning in _VARIABLES:
            values = getattr(samples, name)
            if values is None:
                continue
            variable = file.createVariable(name, "f8", dimensions)
            variable[:] = values
            variable.units = unit
            variable.long_name = meaning


def read_map(path: str | Path) -> CoenergyMap:
    """Return the map whose samples a file holds.

    Raises
    ------
    InputError
        If the file cannot be read, is no co-energy map, or holds no usable samples.
    """
    from scipy.io import netcdf_file

    path = Path(path)
    try:
        # the reader trusts what it reads: a damaged file may fail anywhere in it
        with netcdf_file(str(path), "r", mmap=False) as file:
            samples = _samples(file, path)
    except InputError:
        raise
    except Exception as error:  # noqa: BLE001
        reason = (getattr(error, "strerror", None) or "not a whole netCDF file").lower()
        raise InputError(
            f"{path} cannot be read as a co-energy map ({reason}); give a file that was written "
            "as one"
        ) from None
    return fit(samples)


def _samples(file: Any, path: Path) -> Samples:
    if _text(file, "title") != TITLE:
        raise InputError(
            f'{path} is not a co-energy map: its title is not "{TITLE}"; give a file that tactgen '
            "export --map wrote"
        )
    found: dict[str, Floats | None] = {}
    for name, dimensions, unit, _ in _VARIABLES:
        variable = file.variables.get(name)
        if variable is None and name in _OPTIONAL:
            found[name] = None
            continue
        if variable is None:
            raise InputError(f"{path} has no variable {name}; write the map again")
        if variable.dimensions != dimensions or _text(variable, "units") != unit:
            raise InputError(
                f"{path} gives {name} over {variable.dimensions} in {_text(variable, 'units')!r}; "
                f"it must be over {dimensions} in {unit!r}"
            )
        # netCDF is big-endian
        found[name] = np.array(variable[:], dtype=float)
    return Samples(**found, model=_text(file, "model"), device=_text(file, "device"))  # type: ignore[arg-type]


def _text(holder: Any, name: str) -> str:
    value = getattr(holder, name, b"")
    return value.decode() if isinstance(value, bytes) else str(value)
