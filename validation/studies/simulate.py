"""A run in time as netCDF (version 3), as text and plain values, as a film and as a plot.

Beside everything over time the file of a generator on its rod holds the body that moved and the
coordinates that it follows: whoever draws it needs neither the scene nor a model.
"""

from __future__ import annotations

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
    from xarray import Dataset

    from tactgen.validation.show.generator_body import MovingBody

#: Everything over time by name: values (k,), unit, meaning.
Series = dict[str, tuple[Floats, str, str]]
#: Names of an array's dimensions, its values and its attributes.
Variable = tuple[tuple[str, ...], np.ndarray[Any, Any], dict[str, Any]]

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


def _attributes(result: Simulation | HeldRun) -> dict[str, Any]:
    """Attributes of a run's file: where it comes from, and how far it can be trusted."""
    scene, answer = result.scene, result.answer
    parameters = leaves(scene.model_dump())
    return {
        "title": TITLE_HELD if isinstance(result, HeldRun) else TITLE,
        "source": f"tactgen {metadata.version('tactgen')}",
        "scene": scene.name,
        "parameters": "; ".join(f"{key} = {value}" for key, value in parameters),
        "conventions": "SI units; a time at which a source jumps appears twice",
        "accuracy": answer.accuracy,
        "error": answer.error,
        "certain_until_s": answer.certain_until,
        "energy_imbalance": answer.run.worst_imbalance,
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
    found = _dataset(result).assign_attrs(drives)
    plain = {name: {"_FillValue": None} for name in found.variables}
    with written_whole(path) as temporary:
        found.to_netcdf(temporary, format="NETCDF3_CLASSIC", engine="scipy", encoding=plain)


def _dataset(result: Simulation | HeldRun) -> Dataset:
    """Everything over time with its error bars; of a generator the body that moved, too."""
    from xarray import Dataset  # slow to import

    answer = result.answer
    rows = {"time": (answer.run.time, "s", "since the start"), **series(result)}
    for name, error in answer.bars.items():
        unit = rows[name][1] if name in rows else "A"
        rows[f"{name}_error"] = (error, unit, f"error bar of {name} up to each time")
    variables: dict[str, Variable] = {
        name: (("time",), values, {"units": unit, "long_name": meaning})
        for name, (values, unit, meaning) in rows.items()
    }
    if isinstance(result, HeldRun):
        return Dataset(variables, attrs=_attributes(result))
    for name in answer.errors.keys() & variables.keys():
        variables[name][2]["error_bar"] = answer.errors[name]
    body = body_of(result)
    own = {
        "phases": " ".join(PHASES), "stroke_m": result.stroke,
        "head_radius_m": result.scene.device.rod.head_radius,
        "body_regions": " ".join(body.mesh.regions),
    }  # fmt: skip
    return Dataset(variables | _motion(result, body), attrs=_attributes(result) | own)


def _motion(result: Simulation, body: MovingBody) -> dict[str, Variable]:
    """Phases, and the body that moved with the coordinates that it follows."""
    run, surface, width = result.answer.run, surface_of(body.mesh), body.lateral.shape[1]
    used, corners = np.unique(surface.triangles, return_inverse=True)
    named = phases(result)
    number = np.array([PHASES.index(phase.name) for phase in named])
    ends = np.array([phase.end for phase in named])
    phase = number[np.minimum(np.searchsorted(ends, run.time), number.size - 1)]
    moved = ("point", "coordinate")
    variables = (
        ("phase", ("time",), phase, "of the rod, a number of the attribute phases"),
        ("body_point", ("point", "axis"), body.mesh.points[used], "at rest (m)"),
        ("body_triangle", ("triangle", "axis"), corners.reshape(surface.triangles.shape),
         "points of the surface"),
        ("body_region", ("triangle",), surface.region_of_triangle,
         "a number of the attribute body_regions"),
        ("body_lateral", moved, body.lateral[used], "motion along x per coordinate"),
        ("body_axial", moved, body.axial[used], "motion along z per coordinate"),
        ("coordinates", ("time", "coordinate"), run.position[:, :width],
         "lift of the rod (m), lateral motion (m) and tilt (rad) of its head, modes (m kg^1/2)"),
    )  # fmt: skip
    return {name: (sizes, of, {"long_name": meaning}) for name, sizes, of, meaning in variables}


def film_of(result: Simulation) -> Film:
    """Run as a page shows it."""
    return _film(_dataset(result))


def read_film(path: Path) -> Film:
    """Run of a file of ``tactgen simulate --out``.

    Raises InputError if the file cannot be read, or does not hold what a film needs.
    """
    from xarray import open_dataset  # slow to import

    remedy = "write it with tactgen simulate --out FILE.nc"
    try:
        with open_dataset(path, engine="scipy", decode_cf=False, mmap=False) as file:
            if file.attrs.get("title") != TITLE:
                raise InputError(f"--run {path} is not a run of a generator on its rod; {remedy}")
            return _film(file)
    except InputError:
        raise
    except OSError as error:
        why = error.strerror or "it does not exist or is cut off"
        raise InputError(f"--run {path} cannot be read ({why}); {remedy}") from None
    except (KeyError, AttributeError, TypeError, ValueError, IndexError) as error:
        why = str(error).partition("\n")[0]  # xarray goes on with advice
        raise InputError(
            f"--run {path} does not hold the body that moved ({why}); {remedy} again"
        ) from None


def _film(file: Dataset) -> Film:
    def values(name: str, kind: type = float) -> Any:
        return np.array(file[name], dtype=kind)

    said = file.attrs
    if tuple(said.get("phases", "").split()) != PHASES:
        raise ValueError("its phases have other names")
    bars = ", ".join(
        f"{title} ± {float(file[name].error_bar) / size:.2g} {unit}"
        for name, title, unit, size in _CURVES
        if "error_bar" in file[name].attrs
    )
    return Film(
        scene=said["scene"],
        time=values("time"),
        coordinates=values("coordinates"),
        points=values("body_point"),
        triangles=values("body_triangle", int),
        regions=tuple(said["body_regions"].split()),
        region_of_triangle=values("body_region", int),
        lateral=values("body_lateral"),
        axial=values("body_axial"),
        curves={title: (values(name), unit, size) for name, title, unit, size in _CURVES},
        forces=(values("upper_stop_force"), values("lower_stop_force")),
        phase=values("phase", int),
        stroke=float(said["stroke_m"]),
        rim=float(said["head_radius_m"]),
        words=(
            f"Error bars over the whole run: {bars}. The accuracy of {said['accuracy']:g} "
            f"holds until {1e3 * said['certain_until_s']:.4g} ms."
        ),
    )


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
