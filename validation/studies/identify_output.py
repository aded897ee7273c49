"""An identification as text, as JSON, as a scene file and as a picture."""

from __future__ import annotations

import json
import math
import os
from collections.abc import Callable, Mapping
from itertools import zip_longest
from pathlib import Path
from textwrap import fill
from typing import TYPE_CHECKING, Any

import numpy as np

from tactgen.geometry.arrays import Floats
from tactgen.geometry.device.ceramic_constants import Constants
from tactgen.geometry.device.laminate import Laminate
from tactgen.geometry.device.profile import Profile
from tactgen.geometry.errors import InputError
from tactgen.geometry.files import write_text, written_whole
from tactgen.geometry.formats import engineering, prefixed, signed
from tactgen.geometry.units import quoted
from tactgen.validation.scene.conditions import answer_head, conditions
from tactgen.validation.scene.files import scene_name
from tactgen.validation.scene.keys import read_as
from tactgen.validation.scene.load import FILE_KEYS
from tactgen.validation.scene.parameter_list import parameter_rows
from tactgen.validation.scene.variation import value_of
from tactgen.validation.show.figures import BLUE, GREY, ORANGE, panels, svg
from tactgen.validation.studies.curve_fit import CurveModel
from tactgen.validation.studies.identify import FittedParameter, Identification

if TYPE_CHECKING:
    from matplotlib.figure import Figure

#: Assumptions that shift every estimate by less than this (in percent per percent) are listed.
_SLIGHT = 0.005
#: Digits of an estimate; an interval whose half width (of ln p) is below the last is rounding.
_FEWEST, _MOST, _ROUNDING = 3, 10, 1e-8

_DATA: dict[str, Any] = {
    "color": BLUE, "linestyle": "none", "marker": "o", "markersize": 3.0,
    "markerfacecolor": "none", "markeredgewidth": 0.8, "rasterized": True,
}  # fmt: skip
#: Points of the smooth curves.
_SMOOTH = 1000


def as_text(result: Identification) -> str:
    """Estimates, correlations, misfit, assumptions and findings for people."""
    curve, names = result.curve, [e.parameter.symbol for e in result.estimates]
    low, high = (f"{f:g}" for f in curve.frequencies[[0, -1]])
    kind = "with phase" if curve.has_phase else "magnitude only"
    fitted = {e.parameter.key for e in result.estimates}
    start = " at the start" if "drive.voltage" in fitted else ""
    head = (
        f"{curve.source}: {curve.kind}, {kind}, {curve.frequencies.size} points from {low} to "
        f"{high} Hz\nmodel: transfer matrix, scene {result.start.name}, "
        f"{result.start.drive.voltage:g} V{start}"
    )
    parts = [conditions(result.start), head, _estimate_table(result)]
    if len(names) > 1:
        rows = [
            [name, *("at bound" if math.isnan(c) else f"{c:+.4f}" for c in line[: i + 1])]
            for i, (name, line) in enumerate(zip(names, result.correlation, strict=True))
        ]
        parts.append(_table(["correlation", *names], rows))
    size = {
        "relative": f"{100.0 * result.level:.3g} % of each value, relative noise",
        "constant": f"{engineering(result.level, curve.unit, 3)} at every point, constant noise",
        "stated": f"chi2 per degree of freedom {result.level**2:.4g} by the stated uncertainty",
    }[result.noise]
    parts += [f"misfit: {size} ({result.freedom} degrees of freedom)", _assumption_table(result)]
    if result.findings:
        parts.append("\n  - ".join(["what this curve does not tell:", *result.findings]))
    return "\n\n".join(filter(None, parts))


def _estimate_table(result: Identification) -> str:
    rows = []
    for e in result.estimates:
        unit = e.parameter.unit
        start = f"{e.parameter.start * unit.per_si:.10g}"
        value, low, high = (f"{v * unit.per_si:#.{_digits(e)}g}" for v in (e.value, *e.interval))
        low, high = ("open" if n in e.opened else t for n, t in (("low", low), ("high", high)))
        where = {"": "", "low": " (lower bound)", "high": " (upper bound)"}[e.edge]
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


def _assumption_table(result: Identification) -> str:
    """Table of estimates' sensitivities to assumptions."""
    estimates = [(i, e.parameter.symbol) for i, e in enumerate(result.estimates) if not e.opened]
    rows, slight = [], []
    for a in result.assumptions if estimates else ():
        slopes = [a.slopes[i] for i, _ in estimates]
        if np.nanmax(np.abs([*slopes, 0.0])) < _SLIGHT:
            slight.append(a.row.key)
            continue
        rows.append([a.row.key, a.row.text, *(f"{signed(slope, 2)} %" for slope in slopes)])
    lines = []
    if rows:
        lines.append("if an assumed value is 1 % higher than assumed, the estimates change by")
        lines.append(_table(["assumed", "value", *(name for _, name in estimates)], rows))
    if slight:
        lines.append(f"by less than {_SLIGHT:g} % for {', '.join(slight)}")
    return "\n".join(lines)


def _table(heads: list[str], rows: list[list[str]]) -> str:
    """Columns as wide as they need, the first flush left, the others right."""
    lines = []
    widths = [max(map(len, column)) for column in zip_longest(heads, *rows, fillvalue="")]
    for row in (heads, *rows):
        first, *others = (*row, *[""] * (len(heads) - len(row)))
        right = "".join(f"   {cell:>{w}}" for cell, w in zip(others, widths[1:], strict=True))
        lines.append(f"{first:{widths[0]}}{right}".rstrip())
    return "\n".join([lines[0], "─" * (sum(widths) + 3 * len(widths) - 3), *lines[1:]])


def as_json(result: Identification) -> dict[str, Any]:
    """Plain values in SI units."""
    curve, stated = result.curve, result.noise == "stated"
    return {
        **answer_head(result.scene),
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
    rows = [
        r for r in parameter_rows(result.scene, {}) if r.key in {*origins, *map(read_as, estimates)}
    ]
    for row in sorted(rows, key=lambda r: "." in r.key):
        own, _, name = row.key.rpartition(".")
        if row.key in (*head, "name") or row.written == "derived":
            continue
        if own != group:
            lines += ["", f"[{own}]"]
            group = own
        lines += [
            _interval_comment(e, "" if key == row.key else f"{key} ")
            for key, e in estimates.items()
            if read_as(key) == row.key
        ]
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


def _interval_comment(e: FittedParameter, name: str) -> str:
    low, high = (e.parameter.unit.show(float(f"{end:.{_digits(e)}g}")) for end in e.interval)
    opened = f", open: {' and '.join(e.opened)}" if e.opened else ""
    return f"# {name}fitted, 95 % interval {low} to {high}{opened}"


def _toml(value: Any, text: str) -> str:
    if isinstance(value, tuple) and not isinstance(value, Profile | Laminate | Constants):
        return json.dumps(list(value), ensure_ascii=False)
    plain = text == str(value) and not isinstance(value, str | tuple)
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
    f = curve.frequencies
    columns = 2 if curve.has_phase else 1
    figure, axes = panels(
        1.0 + 5.0 * columns, 6.0, nrows=2, ncols=columns, sharex=True, squeeze=False,
        gridspec_kw={"height_ratios": [2.0, 1.0]},
    )  # fmt: skip
    dense = np.unique([*np.linspace(f[0], f[-1], _SMOOTH), *f])
    before, after = (
        CurveModel(scene, curve.quantity.name, dense, ())(np.zeros(0))
        for scene in (result.start, result.scene)
    )
    factor, unit = prefixed(float(np.abs(after).max()), curve.unit)
    magnitude = axes[0][0]
    magnitude.plot(dense, factor * np.abs(before), "--", color=GREY, label="start")
    magnitude.plot(f, factor * np.abs(curve.values), label="data", **_DATA)
    magnitude.plot(dense, factor * np.abs(after), color=ORANGE, label="fit")
    magnitude.set_yscale("log")
    magnitude.set_ylabel(f"{curve.kind} ({unit})")
    magnitude.legend(frameon=False)
    left, band = result.residuals, result.band
    percent, degrees = 100.0, np.rad2deg(1.0)
    _residuals(axes[1][0], f, percent * np.expm1(left.real), percent * band.real)
    axes[1][0].set_ylabel("data/fit − 1 (%)")
    if curve.has_phase:
        # data and start lie on the fit's branch
        fitted = degrees * np.unwrap(np.angle(after))
        axes[0][1].plot(dense, fitted + degrees * np.angle(before / after), "--", color=GREY)
        at_data = fitted[np.searchsorted(dense, f)]
        axes[0][1].plot(f, at_data + degrees * left.imag, **_DATA)
        axes[0][1].plot(dense, fitted, color=ORANGE)
        axes[0][1].set_ylabel("phase against the voltage (°)")
        _residuals(axes[1][1], f, degrees * left.imag, degrees * band.imag)
        axes[1][1].set_ylabel("phase, data − fit (°)")
    for axis in axes[1]:
        axis.set_xlabel("frequency (Hz)")
        if np.median(f) < 0.25 * (f[0] + f[-1]):  # as the measurement was spaced
            axis.set_xscale("log")
    values = [
        f"{e.parameter.symbol} = {e.parameter.unit.show(float(f'{e.value:.4g}'))}"
        for e in result.estimates
    ]
    name = f"{Path(curve.source).name}, scene {result.scene.name}"
    title = "\n".join(fill(line, 60 * columns) for line in (name, ",  ".join(values)))
    figure.suptitle(title.replace("$", r"\$"), fontsize=10)  # not a formula
    return figure


def _residuals(axis: Any, f: Floats, left: Floats, band: Floats) -> None:
    axis.plot(f, left, **_DATA)
    axis.fill_between(f, -band, band, label="95 % band of the fit", color=ORANGE, alpha=0.35)
    axis.axhline(0.0, color=ORANGE)
    # constant noise dwarfs small values: show where most points are
    reach = max(6.0 * float(np.median(np.abs(left))), 1e-9)
    axis.set_ylim(-reach, reach)
    axis.legend(loc="upper left", fontsize="small")
