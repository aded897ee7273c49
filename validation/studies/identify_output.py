"""An identification as text, as JSON, as a scene file and as a picture."""

from __future__ import annotations

import json
import math
import os
from collections.abc import Callable, Mapping
from pathlib import Path
from textwrap import fill
from typing import TYPE_CHECKING, Any

import numpy as np

from tactgen.geometry.arrays import Floats
from tactgen.geometry.device.profile import Profile
from tactgen.geometry.errors import InputError
from tactgen.geometry.files import write_text, written_whole
from tactgen.geometry.formats import engineering, prefixed
from tactgen.geometry.units import quoted
from tactgen.validation.scene.files import scene_name
from tactgen.validation.scene.parameter_list import parameter_rows
from tactgen.validation.scene.scene import FILE_KEYS
from tactgen.validation.scene.variation import SYMBOLS, value_of
from tactgen.validation.show.figures import BLUE, GREY, ORANGE, panels, svg
from tactgen.validation.studies.curve_fit import curve_model
from tactgen.validation.studies.identify import Assumption, Identification
from tactgen.validation.studies.measured_data import FittedParameter

if TYPE_CHECKING:
    from matplotlib.figure import Figure

#: Assumptions that shift every estimate by less than this (in percent per percent) are counted.
_SLIGHT = 0.005
#: Digits of an estimate; an interval whose half width (of ln p) is below the last is rounding.
_FEWEST, _MOST, _ROUNDING = 3, 10, 1e-8

_DATA: dict[str, Any] = {
    "color": BLUE, "linestyle": "none", "marker": "o", "markersize": 3.0,
    "markerfacecolor": "none", "markeredgewidth": 0.8,
}  # fmt: skip
_FIT: dict[str, Any] = {"color": ORANGE, "linewidth": 1.8}
_START: dict[str, Any] = {"color": GREY, "linewidth": 1.2, "linestyle": "--"}
#: Points of the smooth curves, and points above which markers become an image.
_SMOOTH, _MANY = 600, 3000


def as_text(result: Identification) -> str:
    """Estimates, correlations, misfit, assumptions and findings for people."""
    names = [e.parameter.symbol for e in result.estimates]
    parts = [_headline(result), _estimate_table(result)]
    if len(names) > 1:
        rows = [
            [name, *("at bound" if math.isnan(c) else f"{c:+.4f}" for c in line[: i + 1])]
            for i, (name, line) in enumerate(zip(names, result.correlation, strict=True))
        ]
        parts.append(_table(["correlation", *names], rows))
    parts += [_noise_words(result), _assumption_table(result, names)]
    if result.findings:
        lines = "\n".join(f"  - {sentence}" for sentence in result.findings)
        parts.append(f"what this curve does not tell:\n{lines}")
    return "\n\n".join(part for part in parts if part)


def _headline(result: Identification) -> str:
    curve = result.curve
    low, high = (f"{f:g}" for f in curve.frequencies[[0, -1]])
    kind = "with phase" if curve.has_phase else "magnitude only"
    points = f"{curve.frequencies.size} points from {low} to {high} Hz"
    fitted = [e.parameter.key for e in result.estimates]
    voltage = f"{result.start.drive.voltage:g} V"
    if "drive.voltage" in fitted:
        voltage += " at the start"
    lines = [
        f"{curve.source}: {curve.kind}, {kind}, {points}",
        f"model: transfer matrix, scene {result.start.name}, {voltage}",
    ]
    texts = {row.key: row.text for row in parameter_rows(result.scene, {})}
    fixed = [
        f"{symbol} = {texts[key]}"
        for symbol, key in SYMBOLS.items()
        if key not in fitted and key.startswith("support.")
    ]
    if fixed and result.scene.support.kind == "spring":
        lines.append(f"held: {', '.join(fixed)} and all else of the scene (--fit NAME frees one)")
    return "\n".join(lines)


def _estimate_table(result: Identification) -> str:
    rows = []
    for e in result.estimates:
        unit = e.parameter.unit
        start = f"{e.parameter.start * unit.per_si:.10g}"
        value, low, high = (f"{v * unit.per_si:#.{_digits(e)}g}" for v in (e.value, *e.interval))
        low, high = ("open" if n in e.opened else t for n, t in (("low", low), ("high", high)))
        where = "" if not e.edge else f" ({'lower' if e.edge == 'low' else 'upper'} bound)"
        rows.append(
            [e.parameter.symbol, start, value + where, f"{low} .. {high}", unit.shown or unit.si]
        )
    return _table(["parameter", "start", "fitted", "95 % interval", "unit"], rows)


def _digits(e: FittedParameter) -> int:
    """Digits that show two of the interval's half width, 10 for exact data."""
    if not e.half_width < 1.0:
        return _FEWEST
    if e.half_width < _ROUNDING:
        return _MOST
    return min(max(2 - math.floor(math.log10(e.half_width)), _FEWEST), _MOST)


def _noise_words(result: Identification) -> str:
    freedom = f"{result.freedom} degrees of freedom"
    if np.ptp(result.curve.weight):
        freedom = f"weighted; {freedom}"
    if result.noise == "stated":
        return (
            f"misfit: chi2 per degree of freedom {result.level**2:.4g} against the stated "
            f"uncertainty ({freedom})"
        )
    if result.noise == "constant":
        size = engineering(result.level, result.curve.unit, 3)
        return f"misfit: {size} at every point, taken as constant noise ({freedom})"
    share = f"{100.0 * result.level:.3g} % of each value"
    return f"misfit: {share}, taken as relative noise ({freedom})"


def _assumption_table(result: Identification, names: list[str]) -> str:
    """Table of estimates' sensitivities to assumptions."""
    if all(e.opened for e in result.estimates):
        return ""

    def slopes(a: Assumption) -> list[float]:
        pairs = zip(result.estimates, a.slopes, strict=True)
        return [math.nan if e.opened else slope for e, slope in pairs]

    def words(slope: float) -> str:
        if math.isnan(slope):
            return ""
        return "0" if abs(slope) < _SLIGHT else f"{slope:+.2f} %"

    strong, slight = [], []
    for a in result.assumptions:
        if any(abs(slope) >= _SLIGHT for slope in slopes(a)):
            strong.append([a.row.key, a.row.text, *map(words, slopes(a))])
        else:
            slight.append(a.row.key)
    lines = []
    if strong:
        lines.append("if an assumed value is 1 % higher than assumed, the estimates change by")
        lines.append(_table(["assumed", "value", *names], strong))
    if slight:
        lines.append(f"by less than {_SLIGHT:g} % for {', '.join(slight)}")
    return "\n".join(lines)


def _table(heads: list[str], rows: list[list[str]]) -> str:
    """Columns as wide as they need, the first flush left, the others right."""
    rows = [row + [""] * (len(heads) - len(row)) for row in rows]
    widths = [max(map(len, column)) for column in zip(heads, *rows, strict=True)]
    lines = [
        "   ".join(
            cell.ljust(width) if i == 0 else cell.rjust(width)
            for i, (cell, width) in enumerate(zip(row, widths, strict=True))
        )
        for row in (heads, *rows)
    ]
    lines.insert(1, "─" * len(lines[0]))
    return "\n".join(line.rstrip() for line in lines)


def as_json(result: Identification) -> dict[str, Any]:
    """Plain values in SI units."""
    curve, stated = result.curve, result.noise == "stated"
    return {
        "scene": result.scene.name,
        "data": {
            "file": curve.source,
            "curve": curve.kind,
            "phase": curve.has_phase,
            "points": int(curve.frequencies.size),
            "frequency": [float(curve.frequencies[0]), float(curve.frequencies[-1])],
        },
        "parameters": [
            {
                "name": e.parameter.symbol,
                "key": e.parameter.key,
                "unit": e.parameter.unit.si,
                "start": e.parameter.start,
                "bounds": sorted((e.parameter.low, e.parameter.high)),
                "value": e.value,
                "interval": e.interval,
                "open": e.opened,
                "at_bound": e.edge or None,
            }
            for e in result.estimates
        ],
        "correlation": result.correlation,
        "singular_values": result.singular_values,
        "noise": {
            "kind": result.noise,
            "level": None if stated else result.level,
            "unit": curve.unit if result.noise == "constant" else "",
            "reduced_chi2": result.level**2 if stated else None,
            "degrees_of_freedom": result.freedom,
        },
        "assumed": [
            {
                "key": a.row.key,
                "value": value_of(result.scene, a.row.key),
                "source": a.row.source,
                "slopes": a.slopes,
            }
            for a in result.assumptions
        ],
        "findings": result.findings,
        "warnings": result.warnings,
    }


def checked_scene_name(name: str) -> Path:
    """Where a fitted scene goes; InputError if it is not a new TOML file."""
    path = Path(name)
    if path.suffix.lower() != ".toml":
        raise InputError(f"--write {quoted(name)} does not end in .toml; choose such a name")
    if path.exists():
        raise InputError(
            f"--write {quoted(name)} exists already; choose another file name or remove it first"
        )
    return path


def write_scene(result: Identification, origins: Mapping[str, str], path: Path) -> Path:
    """Write a scene with the fitted values.

    Raises InputError if the file cannot be written.
    """
    curve = result.curve
    estimates = {e.parameter.key: e for e in result.estimates}
    head = {
        "description": f"scene {result.scene.name}, "
        f"{', '.join(e.parameter.symbol for e in result.estimates)} fitted to "
        f"{scene_name(Path(curve.source).name)}",
        "frequency": f"{curve.frequencies[0]:.10g} Hz:{curve.frequencies[-1]:.10g} Hz:"
        f"{min(curve.frequencies.size, 400)}",
    }
    lines = [f"{key} = {json.dumps(text, ensure_ascii=False)}" for key, text in head.items()]
    group = ""
    rows = [r for r in parameter_rows(result.scene, {}) if r.key in {*origins, *estimates}]
    for row in sorted(rows, key=lambda r: "." in r.key):
        own, _, name = row.key.rpartition(".")
        if row.key in (*head, "name") or row.written == "derived":
            continue
        if own != group:
            lines += ["", f"[{own}]"]
            group = own
        if row.key in estimates:
            lines.append(_interval_comment(estimates[row.key]))
        value, text = value_of(result.scene, row.key), row.written
        if row.key in FILE_KEYS:
            text = file_from(path.parent, value, FILE_KEYS[row.key])
        lines.append(f"{name} = {_toml(value, text)}")
    return write_text(path, "\n".join(lines) + "\n")


def file_from(folder: Path, file: str, named: Callable[[str], bool]) -> str:
    """File relative to a folder; `named` recognises other values."""
    if named(file) or Path(file).is_absolute():
        return file
    return os.path.relpath(file, folder)


def _interval_comment(e: FittedParameter) -> str:
    low, high = (e.parameter.unit.show(float(f"{end:.{_digits(e)}g}")) for end in e.interval)
    opened = f", open: {' and '.join(e.opened)}" if e.opened else ""
    return f"# fitted, 95 % interval {low} to {high}{opened}"


def _toml(value: Any, text: str) -> str:
    if isinstance(value, tuple) and not isinstance(value, Profile):
        return json.dumps(list(value), ensure_ascii=False)
    plain = text == str(value) and not isinstance(value, str | Profile)
    return text if plain else json.dumps(text)


def write_plot(result: Identification, path: Path) -> Path:
    """Write the picture as SVG or PNG, by the file's suffix.

    Raises InputError if the file cannot be written.
    """
    figure = _figure(result)
    if path.suffix.lower() == ".svg":
        return write_text(path, svg(figure))
    with written_whole(path) as temporary:
        figure.savefig(temporary, format="png", dpi=150)
    return path


def _figure(result: Identification) -> Figure:
    """Magnitude and, if measured, phase, each above its residuals."""
    curve = result.curve
    columns = 2 if curve.has_phase else 1
    figure, axes = panels(
        1.0 + 5.0 * columns, 6.0, nrows=2, ncols=columns, sharex=True, squeeze=False,
        gridspec_kw={"height_ratios": [2.0, 1.0]},
    )  # fmt: skip
    _draw_curves(axes[0], result)
    size, left, band = np.abs(result.fitted), result.residuals, result.band
    level = {
        "relative": result.level / np.sqrt(curve.relative_weight),
        "constant": result.level / np.sqrt(curve.relative_weight) / size,
        "stated": np.ones(1) if curve.error is None else curve.error / size,
    }[result.noise]
    percent, degrees = 100.0, np.rad2deg(1.0)
    _draw_residuals(
        axes[1][0], curve.frequencies, percent * np.expm1(left.real), percent * band.real,
        percent * level,
    )  # fmt: skip
    axes[1][0].set_ylabel("data/fit − 1 (%)")
    if columns == 2:
        _draw_residuals(
            axes[1][1], curve.frequencies, degrees * left.imag, degrees * band.imag, degrees * level
        )
        axes[1][1].set_ylabel("phase, data − fit (°)")
    f = curve.frequencies
    for axis in axes.ravel():
        # as the measurement was spaced: each point then has its own place
        if np.median(f) < 0.25 * (f[0] + f[-1]):
            axis.set_xscale("log")
    for axis in axes[1]:
        axis.set_xlabel("frequency (Hz)")
    values = [
        f"{e.parameter.symbol} = {e.parameter.unit.show(float(f'{e.value:.4g}'))}"
        for e in result.estimates
    ]
    name = f"{Path(curve.source).name}, scene {result.scene.name}"
    title = "\n".join(
        fill(line, 70 if columns == 1 else 120) for line in (name, ",  ".join(values))
    )
    figure.suptitle(title.replace("$", r"\$"), fontsize=10)  # not a formula
    return figure


def _draw_curves(axes: Any, result: Identification) -> None:
    curve = result.curve
    low, high = float(curve.frequencies[0]), float(curve.frequencies[-1])
    spaced = (np.geomspace(low, high, _SMOOTH), np.linspace(low, high, _SMOOTH))
    f = np.unique(np.clip(np.concatenate(spaced), low, high))  # geomspace rounds its ends
    before, after = (
        curve_model(scene, curve.quantity.name, f, ())(np.zeros(0))
        for scene in (result.start, result.scene)
    )
    factor, unit = prefixed(float(np.abs(after).max()), curve.unit)
    many = curve.frequencies.size > _MANY
    axes[0].plot(f, factor * np.abs(before), label="start", **_START)
    axes[0].plot(
        curve.frequencies, factor * np.abs(curve.values), label="data", rasterized=many, **_DATA
    )
    axes[0].plot(f, factor * np.abs(after), label="fit", **_FIT)
    axes[0].set_yscale("log")
    axes[0].set_ylabel(f"{curve.kind} ({unit})")
    axes[0].legend(frameon=False, loc="best")
    if curve.has_phase:
        fitted = np.rad2deg(np.unwrap(np.angle(after)))
        # the data lie on the fit's branch: its phase plus what is left over
        at_data = np.interp(curve.frequencies, f, fitted)
        wrapped = np.rad2deg(np.angle(curve.values * np.exp(-1j * np.deg2rad(at_data))))
        start = np.rad2deg(np.angle(before * np.exp(-1j * np.deg2rad(fitted))))
        axes[1].plot(f, fitted + start, **_START)
        axes[1].plot(curve.frequencies, at_data + wrapped, rasterized=many, **_DATA)
        axes[1].plot(f, fitted, **_FIT)
        axes[1].set_ylabel("phase against the voltage (°)")


def _draw_residuals(axis: Any, f: Floats, left: Floats, band: Floats, level: Floats) -> None:
    axis.plot(f, left, rasterized=f.size > _MANY, **_DATA)
    axis.fill_between(
        f, -band, band, label="95 % band of the fit", color=ORANGE, alpha=0.35, linewidth=0.0
    )
    axis.axhline(0.0, **_FIT)
    for sign, label in ((-1.0, None), (1.0, "noise (1 σ)")):
        axis.plot(f, np.broadcast_to(sign * level, f.shape), color="#555555", linewidth=0.9,
                  linestyle=":", label=label)  # fmt: skip
    # constant noise dwarfs small values: show where most points are
    reach = max(4.0 * float(np.median(np.abs(left))), 1.3 * float(np.median(level)), 1e-9)
    axis.set_ylim(-1.6 * reach, 1.6 * reach)
    axis.legend(loc="upper left", ncols=2, fontsize="small", edgecolor="none", framealpha=0.85)
