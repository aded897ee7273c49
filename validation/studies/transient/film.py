"""A run's file as a page in which it moves: what ``tactgen view --run`` shows."""

from __future__ import annotations

import tempfile
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from tactgen.geometry.errors import InputError
from tactgen.geometry.files import write_text
from tactgen.validation.studies.transient.files import TITLE, write_run
from tactgen.validation.view.run.page import PHASES, Film, run_page

if TYPE_CHECKING:
    from scipy.io import netcdf_file

    from tactgen.validation.models.generator.transient import Simulation

#: What is drawn beneath the body: name in the file, title, unit and its size in SI.
_CURVES = (
    ("rod_lift", "rod", "µm", 1e-6),
    ("lateral_tip", "tip, lateral", "µm", 1e-6),
    ("coil_current", "coil current", "mA", 1e-3),
    ("voltage", "voltage", "V", 1.0),
)


def write_film_page(run: Path, page: Path) -> None:
    """Write the page of a run's file, whole or not at all.

    Raises
    ------
    InputError
        If the file is no run that holds its body, or the page cannot be written.
    """
    write_text(page, run_page(read_film(run)))


def film_of(found: Simulation) -> Film:
    """Return a run as it is seen, by way of its file, so that a report shows what a page does."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "run.nc"
        write_run(path, found, {})
        return read_film(path)


def read_film(path: Path) -> Film:
    """Return the run of a file of ``tactgen simulate --out``.

    Raises
    ------
    InputError
        If the file cannot be read, or does not hold what a film needs.
    """
    from scipy.io import netcdf_file  # slow to import

    remedy = "write it with tactgen simulate --out FILE.nc"
    try:
        with netcdf_file(str(path), "r", mmap=False) as file:
            if _text(file, "title") != TITLE:
                raise InputError(f"--run {path} is no run of a generator; {remedy}")
            return _film(file)
    except OSError as error:
        why = error.strerror or "it does not exist or is cut off"
        raise InputError(f"--run {path} cannot be read ({why}); {remedy}") from None
    except (KeyError, AttributeError, TypeError, ValueError, IndexError) as error:
        raise InputError(
            f"--run {path} does not hold the body that moved ({error}); {remedy} again"
        ) from None


def _film(file: netcdf_file) -> Film:
    def values(name: str) -> Any:
        return np.array(file.variables[name][:])

    if tuple(_text(file, "phases").split()) != PHASES:
        raise ValueError("its phases have other names")
    bars = ", ".join(
        f"{title} ± {float(file.variables[name].error_bar) / size:.2g} {unit}"
        for name, title, unit, size in _CURVES
        if hasattr(file.variables[name], "error_bar")
    )
    return Film(
        scene=_text(file, "scene"),
        time=values("time").astype(float),
        coordinates=values("coordinates").astype(float),
        points=values("body_point").astype(float),
        triangles=values("body_triangle").astype(int),
        regions=tuple(_text(file, "body_regions").split()),
        region_of_triangle=values("body_region").astype(int),
        lateral=values("body_lateral").astype(float),
        axial=values("body_axial").astype(float),
        curves={
            title: (values(name).astype(float), unit, size) for name, title, unit, size in _CURVES
        },
        forces=(
            values("upper_stop_force").astype(float), values("lower_stop_force").astype(float)
        ),
        phase=values("phase").astype(int),
        stroke=float(file.stroke_m),
        rim=float(file.head_radius_m),
        words=(
            f"Error bars over the whole run: {bars}. The accuracy of {float(file.accuracy):g} "
            f"holds until {1e3 * float(file.certain_until_s):.4g} ms."
        ),
    )  # fmt: skip


def _text(file: netcdf_file, name: str) -> str:
    value = getattr(file, name, b"")
    return value.decode("utf-8") if isinstance(value, bytes) else str(value)
