"""A run in time as netCDF (version 3), as text and plain values, as a film and as a plot.

Beside everything over time the file of a generator on its rod holds the body that moved and the
coordinates that it follows: whoever draws it needs neither the scene nor a model.
"""

from __future__ import annotations

import tempfile
from importlib import metadata
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from tactgen.geometry.arrays import Floats
from tactgen.geometry.errors import InputError
from tactgen.geometry.files import written_whole
from tactgen.geometry.formats import engineering, prefixed, share
from tactgen.geometry.meshing.mesh import surface_of
from tactgen.tmm.generator.transient.machine import LOWER, UPPER
from tactgen.validation.models.held_bimorph import HeldRun, oscillations
from tactgen.validation.models.transient import Simulation, phases
from tactgen.validation.scene.conditions import answer_head
from tactgen.validation.scene.files import leaves
from tactgen.validation.show.figures import AMBER, BLUE, GREEN, GREY, ORANGE, SKY, panels, svg
from tactgen.validation.show.gather import body_of
from tactgen.validation.show.run import PHASES, Film

if TYPE_CHECKING:
    from scipy.io import netcdf_file

#: Everything over time by name: values (k,), unit, meaning.
Series = dict[str, tuple[Floats, str, str]]

#: What the global attribute `title` says of a generator and of a bimorph on its own support.
TITLE, TITLE_HELD = "time simulation of a tactile generator", "time simulation of a held bimorph"
#: Natural frequencies that are listed.
_LISTED = 3
#: Curves below the body: name in the file, title, unit and its size in SI.
_CURVES = (
    ("rod_lift", "rod", "µm", 1e-6),
    ("lateral_tip", "tip, lateral", "µm", 1e-6),
    ("coil_current", "coil current", "mA", 1e-3),
    ("voltage", "voltage", "V", 1.0),
)
_SHADES = {"held": SKY, "rising": AMBER, "pressed": GREY, "falling": GREEN}


def series(result: Simulation | HeldRun) -> Series:
    """Everything over time."""
    return _held_series(result) if isinstance(result, HeldRun) else _generator_series(result)


def _generator_series(result: Simulation) -> Series:
    run, outputs = result.answer.run, result.machine.system.outputs
    rows = {
        name: (result.answer.outputs[name], output.unit, output.meaning)
        for name, output in outputs.items()
    }
    rows["rod_velocity"] = (run.velocity[:, 0], "m/s", "of the rod, upwards")
    rows["lateral_tip_velocity"] = (
        run.velocity @ outputs["lateral_tip"].row, "m/s", "of the tip, lateral",
    )  # fmt: skip
    of_coil = "A" if result.machine.system.coil.source == "current" else "V"  # type: ignore[union-attr]
    for name, values, unit, meaning in (
        ("voltage", run.voltage, "V", "across the bimorph"),
        ("charge", run.charge, "C", "on the bimorph, without dielectric loss"),
        ("coil_source", run.coil_source, of_coil, "what is prescribed in the coil"),
        ("coil_current", run.current, "A", "in the winding"),
        ("flux_linkage", run.flux_linkage, "Wb", "of the winding"),
        ("gap", run.gap, "m", "working gap"),
        ("magnetic_pull", run.pull, "N", "on the rod, downwards"),
        ("upper_stop_force", result.stop_force[UPPER], "N", "on the head, downwards"),
        ("lower_stop_force", result.stop_force[LOWER], "N", "on the head, upwards"),
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


def _held_series(result: HeldRun) -> Series:
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


def _attributes(result: Simulation | HeldRun, drives: dict[str, str]) -> dict[str, Any]:
    """Attributes of a run's file: where it comes from, and how far it can be trusted.

    Plain floats would be stored in single precision.
    """
    scene, answer = result.scene, result.answer
    parameters = leaves(scene.model_dump())
    return {
        "title": TITLE_HELD if isinstance(result, HeldRun) else TITLE,
        "source": f"tactgen {metadata.version('tactgen')}",
        "scene": scene.name,
        "parameters": "; ".join(f"{key} = {value}" for key, value in parameters),
        "conventions": "SI units; a time at which a source jumps appears twice",
        **drives,
        "accuracy": np.float64(answer.accuracy),
        "error": np.float64(answer.error),
        "certain_until_s": np.float64(answer.certain_until),
        "energy_imbalance": np.float64(answer.run.worst_imbalance),
    }


def as_json(result: Simulation | HeldRun) -> dict[str, Any]:
    """Summary of a run as plain values: length, errors, energy balance, extremes.

    Of a generator its phases, of a held bimorph its natural frequencies.
    """
    answer = result.answer
    found = {
        **answer_head(result.scene),
        "until_s": float(answer.run.time[-1]),
        "steps": int(answer.run.time.size),
        "accuracy": answer.accuracy,
        "error": answer.error,
        "load_misfit": result.load_misfit,
        "certain_until_s": answer.certain_until,
        "error_bars": answer.errors,
        "energy_imbalance": answer.run.worst_imbalance,
        "quantities": {
            name: {
                "unit": unit, "meaning": meaning, "least": float(values.min()),
                "largest": float(values.max()), "last": float(values[-1]),
            }
            for name, (values, unit, meaning) in series(result).items()
        },
    }  # fmt: skip
    if isinstance(result, HeldRun):
        own = [{"frequency_hz": f, "damping_ratio": z} for f, z in oscillations(result.system)]
        return {**found, "oscillations": own}
    return {
        **found,
        "sideways_m": float(result.sideways.max()),
        "flange_gap_m": result.flange_gap,
        "phases": [
            {
                "name": phase.name,
                "start_s": phase.start,
                "end_s": phase.end,
                "lateral_amplitude_m": phase.amplitude,
            }
            for phase in phases(result)
        ],
    }


def lines(result: Simulation | HeldRun) -> list[str]:
    """Run for people: motion, steps and errors."""
    answer = result.answer
    last = int(np.searchsorted(answer.run.time, answer.certain_until))
    steps = f"{answer.run.time.size} steps; error"
    until = f"until {1e3 * answer.certain_until:.4g} ms:"
    balance = f"energy balance kept to {answer.run.worst_imbalance:.1e} of what was exchanged"
    if isinstance(result, HeldRun):
        tip = answer.outputs["lateral_tip"]
        low, high, end = (engineering(float(v), "m") for v in (tip.min(), tip.max(), tip[-1]))
        found = oscillations(result.system)[:_LISTED]
        listed = ", ".join(f"{engineering(f, 'Hz')} (damping ratio {share(z)})" for f, z in found)
        bar = engineering(float(answer.bars["lateral_tip"][last]), "m", 2)
        return [
            f"lateral motion {result.scene.measurement.where}: {low} to {high}, {end} at the end",
            f"natural frequencies: {listed or 'none, all motions decay without oscillation'}",
            f"{steps} bar {until} {bar}",
            balance,
        ]
    bars = ", ".join(
        f"{name} {1e6 * answer.bars[name][last]:.2g} um" for name in ("rod_lift", "lateral_tip")
    )
    return [
        f"{'phase':10} {'from (ms)':>10} {'to (ms)':>10}  lateral amplitude (um)",
        *(
            f"{phase.name:10} {1e3 * phase.start:10.3f} {1e3 * phase.end:10.3f}  "
            f"{1e6 * phase.amplitude:.4g}"
            for phase in phases(result)
        ),
        f"{steps} bars {until} {bars}; {balance}",
    ]


def write_run(path: str | Path, result: Simulation | HeldRun, drives: dict[str, str]) -> None:
    """Write a run, with units, errors and its `drives` by option, whole or not at all.

    Raises InputError if the file cannot be written.
    """
    from scipy.io import netcdf_file  # slow to import

    answer = result.answer
    rows = {"time": (answer.run.time, "s", "since the start"), **series(result)}
    for name, error in answer.bars.items():
        unit = rows[name][1] if name in rows else "A"
        rows[f"{name}_error"] = (error, unit, f"error bar of {name} up to each time")
    with written_whole(path) as temporary, netcdf_file(str(temporary), "w") as file:
        for name, value in _attributes(result, drives).items():
            setattr(file, name, value)
        file.createDimension("time", answer.run.time.size)
        for name, (values, unit, meaning) in rows.items():
            _put(file, name, ("time",), values, meaning).units = unit
        if isinstance(result, Simulation):
            _put_motion(file, result)


def _put_motion(file: netcdf_file, result: Simulation) -> None:
    """Error bars, phases, and the body that moved with the coordinates that it follows."""
    answer, body = result.answer, body_of(result)
    for name in answer.errors.keys() & file.variables.keys():
        file.variables[name].error_bar = np.float64(answer.errors[name])
    file.phases = " ".join(PHASES)
    file.stroke_m = np.float64(result.stroke)
    file.head_radius_m = np.float64(result.scene.device.rod.head_radius)
    file.body_regions = " ".join(body.mesh.regions)
    surface = surface_of(body.mesh)
    used, corners = np.unique(surface.triangles, return_inverse=True)
    triangles, width = corners.reshape(surface.triangles.shape), body.lateral.shape[1]
    sizes = {"point": used.size, "triangle": len(triangles), "axis": 3, "coordinate": width}
    for name, size in sizes.items():
        file.createDimension(name, size)
    named = phases(result)
    number = np.array([PHASES.index(phase.name) for phase in named])
    ends = np.array([phase.end for phase in named])
    phase = number[np.minimum(np.searchsorted(ends, answer.run.time), number.size - 1)]
    moved = ("point", "coordinate")
    _put(file, "phase", ("time",), phase, "of the rod, a number of the attribute phases")
    _put(file, "body_point", ("point", "axis"), body.mesh.points[used], "at rest (m)")
    _put(file, "body_triangle", ("triangle", "axis"), triangles, "points of the surface")
    _put(file, "body_region", ("triangle",), surface.region_of_triangle,
         "a number of the attribute body_regions")  # fmt: skip
    _put(file, "body_lateral", moved, body.lateral[used], "motion along x per coordinate")
    _put(file, "body_axial", moved, body.axial[used], "motion along z per coordinate")
    _put(file, "coordinates", ("time", "coordinate"), answer.run.position[:, :width],
         "lift of the rod (m), lateral motion (m) and tilt (rad) of its head, "
         "modes (m kg^1/2)")  # fmt: skip


def _put(
    file: netcdf_file, name: str, sizes: tuple[str, ...], values: np.ndarray[Any, Any], meaning: str
) -> Any:
    """Variable of a file, with its values and its meaning."""
    kind = "i4" if np.issubdtype(values.dtype, np.integer) else "f8"
    variable = file.createVariable(name, kind, sizes)
    variable[:] = values
    variable.long_name = meaning
    return variable


def film_of(result: Simulation) -> Film:
    """Run read back from its file, as a page shows it."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "run.nc"
        write_run(path, result, {})
        return read_film(path)


def read_film(path: Path) -> Film:
    """Run of a file of ``tactgen simulate --out``.

    Raises InputError if the file cannot be read, or does not hold what a film needs.
    """
    from scipy.io import netcdf_file  # slow to import

    remedy = "write it with tactgen simulate --out FILE.nc"
    try:
        with netcdf_file(str(path), "r", mmap=False) as file:
            if _text(file, "title") != TITLE:
                raise InputError(f"--run {path} is not a run of a generator on its rod; {remedy}")
            return _film(file)
    except InputError:
        raise
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


def time_plot(result: Simulation) -> str:
    """Plot lift, lateral tip, coil current and stop forces over time; phases as background."""
    run, outputs = result.answer.run, result.answer.outputs
    figure, axes = panels(9.0, 7.0, nrows=4, sharex=True)
    time = 1e3 * run.time
    for axis, values, label, colour in (
        (axes[0], 1e6 * outputs["rod_lift"], "rod (µm)", ORANGE),
        (axes[1], 1e6 * outputs["lateral_tip"], "tip, lateral (µm)", BLUE),
        (axes[2], 1e3 * run.current, "coil current (mA)", GREEN),
    ):
        axis.plot(time, values, color=colour, linewidth=1.0)
        axis.set_ylabel(label)
    for name, colour in (("upper_stop", ORANGE), ("lower_stop", BLUE)):
        force = 1e3 * result.stop_force[name]
        axes[3].plot(time, force, color=colour, linewidth=1.0, label=name.replace("_", " "))
    axes[3].set_yscale("symlog", linthresh=100.0)
    axes[3].set_ylabel("force (mN)")
    axes[3].set_xlabel("time (ms)")
    axes[3].legend(fontsize=8)
    for phase in phases(result):
        for axis in axes[:2]:
            axis.axvspan(
                1e3 * phase.start, 1e3 * phase.end, color=_SHADES[phase.name], alpha=0.15, lw=0
            )
        axes[0].text(
            0.5e3 * (phase.start + phase.end), 0.9, phase.name,
            transform=axes[0].get_xaxis_transform(), ha="center", fontsize=7, clip_on=True,
        )  # fmt: skip
    axes[0].margins(y=0.15)
    return svg(figure)


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
