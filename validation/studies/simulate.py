"""A run in time as netCDF (version 3), as a page in which it moves, and as a plot.

Beside everything over time the file holds the body that moved and the coordinates that it follows:
whoever draws it needs neither the scene nor a model.
"""

from __future__ import annotations

import math
import re
import tempfile
from dataclasses import dataclass
from importlib import metadata
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from tactgen.geometry.arrays import Floats
from tactgen.geometry.csv_tables import read_columns
from tactgen.geometry.errors import InputError
from tactgen.geometry.files import written_whole
from tactgen.geometry.meshing.mesh import surface_of
from tactgen.geometry.units import Unit, quoted
from tactgen.tmm.generator.transient.machine import LOWER, UPPER
from tactgen.tmm.generator.transient.waveform import Chirp, Sampled, Sine, Square, Step, Waveform
from tactgen.validation.models.transient import Simulation, phases
from tactgen.validation.scene.conditions import answer_head
from tactgen.validation.scene.files import leaves
from tactgen.validation.show.figures import AMBER, BLUE, GREEN, GREY, ORANGE, SKY, panels, svg
from tactgen.validation.show.gather import body_of
from tactgen.validation.show.run import PHASES, Film

if TYPE_CHECKING:
    from scipy.io import netcdf_file

    from tactgen.tmm.generator.transient.time_integration import Answer
    from tactgen.validation.scene.scene import Scene

#: What the global attribute `title` says.
TITLE = "time simulation of a tactile generator"
#: Curves below the body: name in the file, title, unit and its size in SI.
_CURVES = (
    ("rod_lift", "rod", "µm", 1e-6),
    ("lateral_tip", "tip, lateral", "µm", 1e-6),
    ("coil_current", "coil current", "mA", 1e-3),
    ("voltage", "voltage", "V", 1.0),
)
_SHADES = {"held": SKY, "rising": AMBER, "pressed": GREY, "falling": GREEN}


def series(result: Simulation) -> dict[str, tuple[Floats, str, str]]:
    """Everything over time by name: values (k,), unit, meaning."""
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


def run_attributes(
    title: str, scene: Scene, answer: Answer, drives: dict[str, str]
) -> dict[str, Any]:
    """Attributes of a run's file: where it comes from, and how far it can be trusted.

    Plain floats would be stored in single precision.
    """
    parameters = leaves(scene.model_dump())
    return {
        "title": title,
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


def run_summary(
    scene: Scene, answer: Answer, load_misfit: float, found: dict[str, tuple[Floats, str, str]]
) -> dict[str, Any]:
    """Summary of any run as plain values: length, errors, energy balance, extremes."""
    return {
        **answer_head(scene),
        "until_s": float(answer.run.time[-1]),
        "steps": int(answer.run.time.size),
        "accuracy": answer.accuracy,
        "error": answer.error,
        "load_misfit": load_misfit,
        "certain_until_s": answer.certain_until,
        "error_bars": answer.errors,
        "energy_imbalance": answer.run.worst_imbalance,
        "quantities": extremes(found),
    }


def extremes(found: dict[str, tuple[Floats, str, str]]) -> dict[str, dict[str, Any]]:
    """Least, largest and last value of everything over time, as plain values."""
    return {
        name: {
            "unit": unit, "meaning": meaning, "least": float(values.min()),
            "largest": float(values.max()), "last": float(values[-1]),
        }
        for name, (values, unit, meaning) in found.items()
    }  # fmt: skip


def write_run(path: str | Path, result: Simulation, drives: dict[str, str]) -> None:
    """Write a run, with units, errors and its `drives` by option, whole or not at all.

    Raises InputError if the file cannot be written.
    """
    from scipy.io import netcdf_file  # slow to import

    answer, body = result.answer, body_of(result)
    surface = surface_of(body.mesh)
    used, corners = np.unique(surface.triangles, return_inverse=True)
    triangles, width = corners.reshape(surface.triangles.shape), body.lateral.shape[1]
    attributes = {
        **run_attributes(TITLE, result.scene, answer, drives),
        "phases": " ".join(PHASES),
        "stroke_m": np.float64(result.stroke),
        "head_radius_m": np.float64(result.scene.device.rod.head_radius),
        "body_regions": " ".join(body.mesh.regions),
    }
    rows = {"time": (answer.run.time, "s", "since the start"), **series(result)}
    for name, error in answer.bars.items():
        unit = rows[name][1] if name in rows else "A"
        rows[f"{name}_error"] = (error, unit, f"error bar of {name} up to each time")
    named = phases(result)
    number = np.array([PHASES.index(phase.name) for phase in named])
    ends = np.array([phase.end for phase in named])
    phase = number[np.minimum(np.searchsorted(ends, answer.run.time), number.size - 1)]
    moved = ("point", "coordinate")
    with written_whole(path) as temporary, netcdf_file(str(temporary), "w") as file:
        for name, value in attributes.items():
            setattr(file, name, value)
        for name, size in (
            ("time", answer.run.time.size), ("point", used.size), ("triangle", len(triangles)),
            ("axis", 3), ("coordinate", width),
        ):  # fmt: skip
            file.createDimension(name, size)
        for name, (values, unit, meaning) in rows.items():
            variable = put_variable(file, name, ("time",), values, meaning)
            variable.units = unit
            if name in answer.errors:
                variable.error_bar = np.float64(answer.errors[name])
        put_variable(
            file, "phase", ("time",), phase, "of the rod, a number of the attribute phases"
        )
        put_variable(file, "body_point", ("point", "axis"), body.mesh.points[used], "at rest (m)")
        put_variable(
            file, "body_triangle", ("triangle", "axis"), triangles, "points of the surface"
        )
        put_variable(file, "body_region", ("triangle",), surface.region_of_triangle,
             "a number of the attribute body_regions")  # fmt: skip
        put_variable(
            file, "body_lateral", moved, body.lateral[used], "motion along x per coordinate"
        )
        put_variable(file, "body_axial", moved, body.axial[used], "motion along z per coordinate")
        put_variable(file, "coordinates", ("time", "coordinate"), answer.run.position[:, :width],
             "lift of the rod (m), lateral motion (m) and tilt (rad) of its head, "
             "modes (m kg^1/2)")  # fmt: skip


def put_variable(
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


VOLTS = Unit("V", "voltage", "10 V", limits=(1e-9, 1e5))
AMPERES = Unit("A", "current", "120 mA", limits=(1e-9, 1e3))
SECONDS = Unit("s", "time", "30 ms", at_least=0.0, limits=(1e-9, 1e4))
_HERTZ = Unit("Hz", "frequency", "200 Hz", above=0.0, limits=(1e-3, 1e7))
_SHARE = Unit("", "share", "0.5", above=0.0, below=1.0)
_ANGLE = Unit("rad", "angle", "90 deg", limits=(1e-9, 1e3))

#: Keywords after each kind, with the unit of what follows.
_KINDS: dict[str, tuple[Unit | None, dict[str, Unit | None]]] = {
    "constant": (None, {}),
    "sine": (_HERTZ, {"phase": _ANGLE, "delay": SECONDS}),
    "square": (_HERTZ, {"low": None, "duty": _SHARE, "delay": SECONDS}),
    "step": (None, {"at": SECONDS, "until": SECONDS}),
    "chirp": (_HERTZ, {"to": _HERTZ, "in": SECONDS}),
}
_EXAMPLES = (
    '"10 V sine 200 Hz", "120 mA square 100 Hz", "5 V step at 1 ms", '
    '"1 V chirp 10 Hz to 1000 Hz in 20 ms" or a CSV file'
)
_WORD = re.compile(r"\b(constant|sine|square|step|chirp|phase|delay|low|duty|at|until|to|in)\b")


@dataclass(frozen=True)
class Written:
    """Waveform of a source."""

    waveform: Waveform
    of: Literal["voltage", "current"]


def parsed(text: str, option: str, units: tuple[Unit, ...]) -> Written:
    """Value of an option's text, whose level may be in VOLTS, AMPERES or both.

    Raises InputError in one sentence with an example.
    """
    text = text.strip()
    if text.lower().endswith(".csv"):
        return _sampled(text, option, units)
    pieces = _WORD.split(text)
    level, unit = _level(pieces[0], option, text, units)
    kind = pieces[1] if len(pieces) > 1 else "constant"
    if kind not in _KINDS:
        raise InputError(f"{option} {quoted(text)} is not a waveform; write {_EXAMPLES}")
    first, known = _KINDS[kind]
    given: dict[str, float] = {}
    stated = pieces[2].strip() if len(pieces) > 2 else ""
    if first is not None:
        given["frequency"] = _value(stated, first, option, text, f"the {kind}'s frequency")
    elif stated:
        raise InputError(f"{option} {quoted(text)} has {quoted(stated)} after {kind}; remove it")
    for word, value in zip(pieces[3::2], pieces[4::2], strict=True):
        if word not in known or word in given:
            why = "twice" if word in given else f"which {kind} does not know"
            raise InputError(f"{option} {quoted(text)} has {word}, {why}; write {_EXAMPLES}")
        given[word] = _value(value.strip(), known[word] or unit, option, text, word)
    return Written(
        _made(kind, level, given, option, text), "current" if unit is AMPERES else "voltage"
    )


def _made(kind: str, level: float, given: dict[str, float], option: str, text: str) -> Waveform:
    delay = given.get("delay", 0.0)
    match kind:
        case "constant":
            return Step(level)
        case "sine":
            return Sine(level, given["frequency"], given.get("phase", 0.0), delay)
        case "square":
            low, duty = given.get("low", 0.0), given.get("duty", 0.5)
            return Square(level, given["frequency"], low, duty, delay)
        case "step":
            start, stop = given.get("at", 0.0), given.get("until", math.inf)
            if stop <= start:
                raise InputError(
                    f"{option} {quoted(text)} ends at {stop:g} s, not after its start at "
                    f"{start:g} s; give a later end"
                )
            return Step(level, start, stop)
    if "to" not in given or not given.get("in"):
        raise InputError(
            f"{option} {quoted(text)} needs the last frequency and the time of the chirp; write "
            'for example "1 V chirp 10 Hz to 1000 Hz in 20 ms"'
        )
    return Chirp(level, given["frequency"], given["to"], given["in"])


def _level(piece: str, option: str, text: str, units: tuple[Unit, ...]) -> tuple[float, Unit]:
    reason = ""
    for unit in units:
        try:
            unit.parse(piece.strip())
        except ValueError as error:
            reason = str(error)
        else:
            return _value(piece.strip(), unit, option, text, "the level"), unit
    if len(units) > 1:
        reason = "is not a level in volts or amperes"
    such_as = ", or a waveform such as " if "; " in reason else "; write a waveform such as "
    raise InputError(
        f"{option} {quoted(text)}: {quoted(piece.strip())} {reason}{such_as}{_EXAMPLES}"
    )


def _value(piece: str, unit: Unit, option: str, text: str, name: str) -> float:
    """Read a number with its unit, within the unit's bounds."""
    shown = f"{name} {quoted(piece)}"
    try:
        value = unit.parse(piece)
        shown = f"{name} = {unit.show(value)}"
        unit.check(value)
    except ValueError as error:
        raise InputError(f"{option} {quoted(text)}: {shown} {error}") from None
    return value


def _sampled(path: str, option: str, units: tuple[Unit, ...]) -> Written:
    """Read a CSV of two columns."""
    remedy = "give a CSV with the columns time (s) and voltage (V) or current (A)"
    name = f"{option} {path}"
    known = {("current" if unit is AMPERES else "voltage"): unit for unit in units}
    example = " and ".join(("time (s)", " or ".join(f"{w} ({u.si})" for w, u in known.items())))
    table = read_columns(path, name, {"time": SECONDS, **known}, example, ("time",), remedy=remedy)
    what = [column for column in table.columns if column != "time"]
    if len(what) != 1:
        raise InputError(f"{name} has {len(what) + 1} columns; give {example}")
    times = table.columns["time"]
    for line, before, time in zip(table.lines, [0.0, *times], times, strict=False):
        if time < before:
            raise InputError(
                f"{name} line {line}: time = {time:g} s is negative or before the line above; "
                "sort the rows from 0 on"
            )
    if not times.size:
        raise InputError(f"{name} has no rows; {remedy}")
    of: Literal["voltage", "current"] = "current" if what[0] == "current" else "voltage"
    return Written(Sampled(tuple(map(float, times)), tuple(map(float, table.columns[what[0]]))), of)
