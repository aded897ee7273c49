"""A run as netCDF (version 3), which xarray and most other tools read."""

from __future__ import annotations

from importlib import metadata
from pathlib import Path

import numpy as np

from tactgen.geometry.arrays import Floats
from tactgen.geometry.files import written_whole
from tactgen.tmm.generator.transient.machine import LOWER, UPPER
from tactgen.validation.models.generator.transient import Simulation
from tactgen.validation.scene.files import leaves

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

    answer = found.answer
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
