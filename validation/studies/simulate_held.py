"""A run of a held bimorph as netCDF (version 3), as plain values, as text and as a plot."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from tactgen.geometry.arrays import Floats
from tactgen.geometry.files import written_whole
from tactgen.geometry.formats import engineering, prefixed, share
from tactgen.validation.models.held_bimorph import HeldRun, oscillations
from tactgen.validation.show.figures import BLUE, GREEN, panels, svg
from tactgen.validation.studies.simulate import put_variable, run_attributes, run_summary

#: What the global attribute `title` says.
TITLE = "time simulation of a held bimorph"
#: Natural frequencies that are listed.
_LISTED = 3


def series(result: HeldRun) -> dict[str, tuple[Floats, str, str]]:
    """Everything over time by name: values (k,), unit, meaning."""
    run, (name, output) = result.answer.run, next(iter(result.system.outputs.items()))
    return {
        name: (result.answer.outputs[name], output.unit, output.meaning),
        f"{name}_velocity": (run.velocity @ output.row, "m/s", "of the tip, lateral"),
        "voltage": (run.voltage, "V", "across the bimorph"),
        "charge": (run.charge, "C", "on the bimorph, without dielectric loss"),
        "kinetic_energy": (run.kinetic, "J", "of all that moves"),
        "strain_energy": (run.strain, "J", "of bimorph, support and load"),
        "electric_energy": (run.electric, "J", "of the bimorph's capacitance"),
        "bimorph_work": (run.bimorph_work, "J", "of the voltage source since the start"),
        "structure_loss": (run.structure_loss, "J", "in bimorph, support and load since the start"),
        "imbalance": (run.imbalance, "J", "energy less start, works and losses: rounding"),
    }


def write_held_run(path: str | Path, result: HeldRun, drives: dict[str, str]) -> None:
    """Write a run, with units, errors and where it comes from, whole or not at all.

    Raises InputError if the file cannot be written.
    """
    from scipy.io import netcdf_file  # slow to import

    answer = result.answer
    rows = {"time": (answer.run.time, "s", "since the start"), **series(result)}
    for name, error in answer.bars.items():
        rows[f"{name}_error"] = (error, rows[name][1], f"error bar of {name} up to each time")
    with written_whole(path) as temporary, netcdf_file(str(temporary), "w") as file:
        for name, value in run_attributes(TITLE, result.scene, answer, drives).items():
            setattr(file, name, value)
        file.createDimension("time", answer.run.time.size)
        for name, (values, unit, meaning) in rows.items():
            put_variable(file, name, ("time",), values, meaning).units = unit


def held_values(result: HeldRun) -> dict[str, Any]:
    """Summary of a run as plain values: extremes, natural frequencies, balance, errors."""
    return {
        **run_summary(result.scene, result.answer, result.load_misfit, series(result)),
        "oscillations": [
            {"frequency_hz": frequency, "damping_ratio": ratio}
            for frequency, ratio in oscillations(result.system)
        ],
    }


def held_lines(result: HeldRun) -> list[str]:
    """Extremes of the tip, natural frequencies, steps and errors."""
    answer, tip = result.answer, result.answer.outputs["lateral_tip"]
    low, high, last = (engineering(float(v), "m") for v in (tip.min(), tip.max(), tip[-1]))
    found = oscillations(result.system)[:_LISTED]
    listed = ", ".join(f"{engineering(f, 'Hz')} (damping ratio {share(z)})" for f, z in found)
    at = int(np.searchsorted(answer.run.time, answer.certain_until))
    bar = engineering(float(answer.bars["lateral_tip"][at]), "m", 2)
    return [
        f"lateral motion {result.scene.measurement.where}: {low} to {high}, {last} at the end",
        f"natural frequencies: {listed or 'none, all motions decay without oscillation'}",
        f"{answer.run.time.size} steps; error bar until {1e3 * answer.certain_until:.4g} ms: {bar}",
        f"energy balance kept to {answer.run.worst_imbalance:.1e} of what was exchanged",
    ]


def held_plot(result: HeldRun) -> str:
    """Plot the tip and the voltage over time."""
    run, tip = result.answer.run, result.answer.outputs["lateral_tip"]
    figure, axes = panels(9.0, 5.0, nrows=2, sharex=True)
    for axis, values, label, unit, colour in (
        (axes[0], tip, "tip, lateral", "m", BLUE),
        (axes[1], run.voltage, "voltage", "V", GREEN),
    ):
        scale, shown = prefixed(float(np.abs(values).max()), unit)
        axis.plot(1e3 * run.time, scale * values, color=colour, linewidth=1.0)
        axis.set_ylabel(f"{label} ({shown})")
    axes[1].set_xlabel("time (ms)")
    return svg(figure)
