"""A run as netCDF (version 3), which xarray and most other tools read.

Beside everything over time the file holds the body that moved and the coordinates that it follows:
whoever draws it needs neither the scene nor a model.
"""

from __future__ import annotations

from importlib import metadata
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from tactgen.geometry.arrays import Floats, Ints
from tactgen.geometry.files import written_whole
from tactgen.geometry.meshing.mesh import surface_of
from tactgen.tmm.generator.transient.machine import LOWER, UPPER
from tactgen.validation.fields.run import body_of
from tactgen.validation.models.generator.phases import phases
from tactgen.validation.models.generator.transient import Simulation
from tactgen.validation.scene.files import leaves
from tactgen.validation.view.run.page import PHASES

if TYPE_CHECKING:
    from scipy.io import netcdf_file

#: What the global attribute `title` says.
TITLE = "time simulation of a tactile generator"


def series(found: Simulation) -> dict[str, tuple[Floats, str, str]]:
    """Return everything over time by name: values (k,), unit, meaning."""
    run, outputs = found.answer.run, found.machine.system.outputs
    rows = {
        name: (found.answer.outputs[name], output.unit, output.meaning)
        for name, output in outputs.items()
    }
    rows["rod_velocity"] = (run.velocity[:, 0], "m/s", "of the rod, upwards")
    rows["lateral_tip_velocity"] = (
        run.velocity @ outputs["lateral_tip"].row, "m/s", "of the tip, lateral",
    )  # fmt: skip
    of_coil = "A" if found.machine.system.coil.source == "current" else "V"  # type: ignore[union-attr]
    for name, values, unit, meaning in (
        ("voltage", run.voltage, "V", "across the bimorph"),
        ("charge", run.charge, "C", "on the bimorph, without dielectric loss"),
        ("coil_source", run.coil_source, of_coil, "what is prescribed in the coil"),
        ("coil_current", run.current, "A", "in the winding"),
        ("flux_linkage", run.flux_linkage, "Wb", "of the winding"),
        ("gap", run.gap, "m", "working gap"),
        ("magnetic_pull", run.pull, "N", "on the rod, downwards"),
        ("upper_stop_force", found.stop_force[UPPER], "N", "on the head, downwards"),
        ("lower_stop_force", found.stop_force[LOWER], "N", "on the head, upwards"),
        ("kinetic_energy", run.kinetic, "J", "of all that moves"),
        ("strain_energy", run.strain, "J", "of bimorph, guide and spring"),
        ("contact_energy", run.springs, "J", "of both stops"),
        ("preload_energy", run.load, "J", "of the spring's preload"),
        ("magnetic_energy", run.magnetic, "J", "of the coil's field"),
        ("electric_energy", run.electric, "J", "of the bimorph's capacitance"),
        ("bimorph_work", run.bimorph_work, "J", "of the voltage source since the start"),
        ("coil_work", run.coil_work, "J", "of the coil's source since the start"),
        ("structure_loss", run.structure_loss, "J", "in bimorph and guide since the start"),
        ("contact_loss", run.element_loss, "J", "in stops and friction since the start"),
        ("wire_loss", run.wire_loss, "J", "in the coil's circuit since the start"),
        ("imbalance", run.imbalance, "J", "energy less start, works and losses: rounding"),
    ):
        rows[name] = (values, unit, meaning)
    return rows


def write_run(path: str | Path, found: Simulation, drives: dict[str, str]) -> None:
    """Write a run, with units, error bars and where it comes from, whole or not at all.

    Parameters
    ----------
    drives : dict of str to str
        What was written for the sources, by option.

    Raises
    ------
    InputError
        If the file cannot be written.
    """
    from scipy.io import netcdf_file  # slow to import

    answer, named = found.answer, phases(found)
    with written_whole(path) as temporary, netcdf_file(str(temporary), "w") as file:
        file.title = TITLE
        file.source = f"tactgen {metadata.version('tactgen')}"
        file.scene = found.scene.name
        groups = found.scene.model_dump()
        file.parameters = "; ".join(f"{key} = {value}" for key, value in leaves(groups))
        file.conventions = "SI units; a time at which a source jumps appears twice"
        for option, text in drives.items():
            setattr(file, option, text)
        # plain floats would be stored in single precision
        file.accuracy = np.float64(answer.accuracy)
        file.error = np.float64(answer.error)
        file.certain_until_s = np.float64(answer.certain_until)
        file.energy_imbalance = np.float64(answer.run.worst_imbalance)
        file.phases = " ".join(PHASES)
        file.stroke_m = np.float64(found.stroke)
        file.head_radius_m = np.float64(found.scene.device.rod.head_radius)
        file.createDimension("time", answer.run.time.size)
        rows = {"time": (answer.run.time, "s", "since the start"), **series(found)}
        for name, bar in answer.bars.items():
            unit = rows[name][1] if name in rows else "A"
            rows[f"{name}_error"] = (bar, unit, f"error bar of {name} up to each time")
        for name, (values, unit, meaning) in rows.items():
            variable = file.createVariable(name, "f8", ("time",))
            variable[:] = values
            variable.units = unit
            variable.long_name = meaning
            if name in answer.errors:
                variable.error_bar = np.float64(answer.errors[name])
        ends = np.array([phase.end for phase in named])
        number = np.array([PHASES.index(phase.name) for phase in named])
        at = np.minimum(np.searchsorted(ends, answer.run.time), number.size - 1)
        _put(file, "phase", ("time",), number[at], "of the rod, a number of the attribute phases")
        _write_body(file, found)


def _write_body(file: netcdf_file, found: Simulation) -> None:
    """Write the surface of what moves, and the coordinates that it follows."""
    body = body_of(found)
    surface = surface_of(body.mesh)
    used, corners = np.unique(surface.triangles, return_inverse=True)
    triangles = corners.reshape(surface.triangles.shape)
    width = body.lateral.shape[1]
    file.body_regions = " ".join(body.mesh.regions)
    for name, size in (
        ("point", used.size), ("triangle", len(triangles)), ("axis", 3), ("coordinate", width)
    ):  # fmt: skip
        file.createDimension(name, size)
    _put(file, "body_point", ("point", "axis"), body.mesh.points[used], "of the body at rest (m)")
    _put(file, "body_triangle", ("triangle", "axis"), triangles, "points of the body's surface")
    _put(
        file, "body_region", ("triangle",), surface.region_of_triangle,
        "a number of the attribute body_regions",
    )  # fmt: skip
    moved = ("point", "coordinate")
    _put(file, "body_lateral", moved, body.lateral[used], "motion along x per coordinate")
    _put(file, "body_axial", moved, body.axial[used], "motion along z per coordinate")
    _put(
        file, "coordinates", ("time", "coordinate"), found.answer.run.position[:, :width],
        "lift of the rod (m), lateral motion (m) and tilt (rad) of its head, modes (m kg^1/2)",
    )  # fmt: skip


def _put(
    file: netcdf_file, name: str, sizes: tuple[str, ...], values: Floats | Ints, meaning: str
) -> None:
    whole = np.issubdtype(values.dtype, np.integer)
    variable = file.createVariable(name, "i4" if whole else "f8", sizes)
    variable[:] = values
    variable.long_name = meaning
