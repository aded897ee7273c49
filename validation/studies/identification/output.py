"""An identification as text, as JSON, and as a scene file."""

from __future__ import annotations

import io
import json
import math
import os
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from tactgen.geometry.device.profile import Profile
from tactgen.geometry.errors import InputError
from tactgen.geometry.files import write_text
from tactgen.geometry.units import quoted
from tactgen.validation.scene.files import scene_name
from tactgen.validation.scene.keys import SYMBOLS, value_of
from tactgen.validation.scene.parameter_list import parameter_rows
from tactgen.validation.scene.scene import FILE_KEYS
from tactgen.validation.studies.identification.estimates import FittedParameter, Identification
from tactgen.validation.studies.identification.fit_quality import Assumption
from tactgen.validation.view.formats import engineering

#: Assumptions that shift every estimate by less than this (in percent per percent) are counted.
_SLIGHT = 0.005
_WIDTH = 100
#: Digits of an estimate; an interval whose half width (of ln p) is below the last is rounding.
_FEWEST, _MOST, _ROUNDING = 3, 10, 1e-8


def as_text(found: Identification) -> str:
    """Return what people read: estimates, correlations, misfit, assumptions, findings."""
    parts = [_headline(found), _estimate_table(found)]
    if len(found.estimates) > 1:
        parts.append(_correlation_table(found))
    parts += [_noise_words(found), _assumption_table(found)]
    if found.findings:
        told = "\n".join(f"  - {sentence}" for sentence in found.findings)
        parts.append(f"what this curve does not tell:\n{told}")
    return "\n\n".join(part.strip("\n") for part in parts if part)


def _headline(found: Identification) -> str:
    curve = found.curve
    low, high = (f"{f:g}" for f in curve.frequencies[[0, -1]])
    kind = "with phase" if curve.has_phase else "magnitude only"
    points = f"{curve.frequencies.size} points from {low} to {high} Hz"
    fitted = [e.parameter.key for e in found.estimates]
    voltage = f"{found.start.drive.voltage:g} V"
    if "drive.voltage" in fitted:
        voltage += " at the start"
    lines = [
        f"{curve.source}: {curve.kind}, {kind}, {points}",
        f"model: transfer matrix, scene {found.start.name}, {voltage}",
    ]
    held = [
        f"{symbol} = {row.text}"
        for symbol, key in SYMBOLS.items()
        for row in parameter_rows(found.scene, {})
        if row.key == key and key not in fitted and key.startswith("support.")
    ]
    if held and found.scene.support.kind == "spring":
        lines.append(f"held: {', '.join(held)} and all else of the scene (--fit NAME frees one)")
    return "\n".join(lines)


def _estimate_table(found: Identification) -> str:
    rows = []
    for e in found.estimates:
        unit = e.parameter.unit
        digits = _digits(e)
        start = f"{e.parameter.start * unit.per_si:.10g}"
        value, low, high = (f"{v * unit.per_si:#.{digits}g}" for v in (e.value, *e.interval))
        low, high = ("open" if n in e.opened else t for n, t in (("low", low), ("high", high)))
        name = e.parameter.symbol
        where = "" if not e.edge else f" ({'lower' if e.edge == 'low' else 'upper'} bound)"
        rows.append([name, start, value + where, f"{low} .. {high}", unit.shown or unit.si])
    return _table(["parameter", "start", "fitted", "95 % interval", "unit"], rows)


def _digits(e: FittedParameter) -> int:
    """Return how many digits show two of the interval's half width, 10 for exact data."""
    half_width = e.half_width
    if not half_width < 1.0:
        return _FEWEST
    if half_width < _ROUNDING:
        return _MOST
    return min(max(2 - math.floor(math.log10(half_width)), _FEWEST), _MOST)


def _correlation_table(found: Identification) -> str:
    names = [e.parameter.symbol for e in found.estimates]
    rows = [
        [name, *("at bound" if math.isnan(c) else f"{c:+.4f}" for c in line[: i + 1])]
        for i, (name, line) in enumerate(zip(names, found.correlation, strict=True))
    ]
    return _table(
        ["correlation", *names], [row + [""] * (len(names) + 1 - len(row)) for row in rows]
    )


def _noise_words(found: Identification) -> str:
    freedom = f"{found.freedom} degrees of freedom"
    if np.ptp(found.curve.weight):
        freedom = f"weighted; {freedom}"
    if found.noise == "stated":
        return (
            f"misfit: chi2 per degree of freedom {found.level**2:.4g} against the stated "
            f"uncertainty ({freedom})"
        )
    if found.noise == "constant":
        size = engineering(found.level, found.curve.unit, 3)
        return f"misfit: {size} at every point, taken as constant noise ({freedom})"
    return f"misfit: {100.0 * found.level:.3g} % of each value, taken as relative noise ({freedom})"


def _assumption_table(found: Identification) -> str:
    names = [e.parameter.symbol for e in found.estimates]
    strong = [a for a in found.assumptions if _largest(_told(found, a)) >= _SLIGHT]
    slight = [a.row.key for a in found.assumptions if a not in strong]
    if all(e.opened for e in found.estimates):
        return ""
    text = ""
    if strong:
        rows = [[a.row.key, a.row.text, *(_slope(s) for s in _told(found, a))] for a in strong]
        text = "if an assumed value is 1 % higher than assumed, the estimates change by\n"
        text += _table(["assumed", "value", *names], rows).strip("\n")
    if slight:
        text += f"\nby less than {_SLIGHT:g} % for {', '.join(slight)}"
    return text


def _told(found: Identification, assumption: Assumption) -> tuple[float, ...]:
    """Return the slopes of those estimates that the curve determines, nan for others."""
    pairs = zip(found.estimates, assumption.slopes, strict=True)
    return tuple(math.nan if e.opened else slope for e, slope in pairs)


def _slope(slope: float) -> str:
    if math.isnan(slope):
        return ""
    return "0" if abs(slope) < _SLIGHT else f"{slope:+.2f} %"


def _largest(slopes: tuple[float, ...]) -> float:
    return max((abs(s) for s in slopes if not math.isnan(s)), default=0.0)


def _table(heads: list[str], rows: list[list[str]]) -> str:
    from rich import box
    from rich.console import Console
    from rich.table import Table

    table = Table(box=box.SIMPLE_HEAD, pad_edge=False, show_edge=False)
    for i, head in enumerate(heads):
        table.add_column(head, justify="left" if i == 0 else "right", no_wrap=True)
    for row in rows:
        table.add_row(*row)
    buffer = io.StringIO()
    Console(file=buffer, width=_WIDTH + 12 * len(heads), markup=False).print(table)
    return "\n".join(line.rstrip() for line in buffer.getvalue().splitlines())


def as_json(found: Identification) -> dict[str, Any]:
    """Return the identification as plain JSON values in SI units; unknown numbers are null."""
    curve = found.curve
    return {
        "scene": found.scene.name,
        "data": {
            "file": curve.source,
            "curve": curve.kind,
            "phase": curve.has_phase,
            "points": int(curve.frequencies.size),
            "frequency": [float(curve.frequencies[0]), float(curve.frequencies[-1])],
        },
        "parameters": [_estimate_json(e) for e in found.estimates],
        "correlation": [[_number(c) for c in line] for line in found.correlation],
        "singular_values": [_number(v) for v in found.singular_values],
        "noise": {
            "kind": found.noise,
            "level": found.level if found.noise != "stated" else None,
            "unit": curve.unit if found.noise == "constant" else "",
            "reduced_chi2": found.level**2 if found.noise == "stated" else None,
            "degrees_of_freedom": found.freedom,
        },
        "assumed": [
            {
                "key": a.row.key,
                "value": value_of(found.scene, a.row.key),
                "source": a.row.source,
                "slopes": [_number(s) for s in a.slopes],
            }
            for a in found.assumptions
        ],
        "findings": list(found.findings),
        "warnings": list(found.warnings),
    }


def _estimate_json(e: FittedParameter) -> dict[str, Any]:
    p = e.parameter
    return {
        "name": p.symbol,
        "key": p.key,
        "unit": p.unit.si,
        "start": p.start,
        "bounds": sorted((p.low, p.high)),
        "value": e.value,
        "interval": [_number(end) for end in e.interval],
        "open": list(e.opened),
        "at_bound": e.edge or None,
    }


def _number(value: float) -> float | None:
    return float(value) if np.isfinite(value) else None


def checked_scene_name(name: str) -> Path:
    """Return where a fitted scene goes.

    Raises
    ------
    InputError
        If it is not a new TOML file.
    """
    path = Path(name)
    if path.suffix.lower() != ".toml":
        raise InputError(f"--write {quoted(name)} does not end in .toml; choose such a name")
    if path.exists():
        raise InputError(
            f"--write {quoted(name)} exists already; choose another file name or remove it first"
        )
    return path


def write_scene(found: Identification, origins: Mapping[str, str], path: Path) -> Path:
    """Write a scene that holds what the starting scene set, and the fitted values.

    Raises
    ------
    InputError
        If the file cannot be written.
    """
    return write_text(path, scene_text(found, origins, path.parent))


def scene_text(found: Identification, origins: Mapping[str, str], folder: Path) -> str:
    """Return the fitted scene as TOML for a file in `folder`, from which its paths start."""
    curve = found.curve
    estimates = {e.parameter.key: e for e in found.estimates}
    told = {
        "description": f"scene {found.scene.name}, "
        f"{', '.join(e.parameter.symbol for e in found.estimates)} fitted to "
        f"{scene_name(Path(curve.source).name)}",
        "frequency": f"{curve.frequencies[0]:.10g} Hz:{curve.frequencies[-1]:.10g} Hz:"
        f"{min(curve.frequencies.size, 400)}",
    }
    lines = [f"{key} = {json.dumps(text, ensure_ascii=False)}" for key, text in told.items()]
    group = ""
    rows = [r for r in parameter_rows(found.scene, {}) if r.key in {*origins, *estimates}]
    for row in sorted(rows, key=lambda r: "." in r.key):
        head, _, name = row.key.rpartition(".")
        if row.key in (*told, "name") or row.written == "derived":
            continue
        if head != group:
            lines += ["", f"[{head}]"]
            group = head
        if row.key in estimates:
            lines.append(_interval_comment(estimates[row.key]))
        value, text = value_of(found.scene, row.key), row.written
        if row.key in FILE_KEYS:
            text = file_from(folder, value, FILE_KEYS[row.key])
        lines.append(f"{name} = {_toml(value, text)}")
    return "\n".join(lines) + "\n"


def file_from(folder: Path, file: str, named: Callable[[str], bool]) -> str:
    """Return a file as a scene in `folder` names it, relative to that; `named` tells no files."""
    if named(file) or Path(file).is_absolute():
        return file
    return os.path.relpath(file, folder)


def _interval_comment(e: FittedParameter) -> str:
    low, high = (e.parameter.unit.show(float(f"{end:.{_digits(e)}g}")) for end in e.interval)
    opened = f", open: {' and '.join(e.opened)}" if e.opened else ""
    return f"# fitted, 95 % interval {low} to {high}{opened}"


def _toml(value: Any, text: str) -> str:
    if isinstance(value, str | Profile):
        return json.dumps(text)
    if isinstance(value, tuple):
        return json.dumps(list(value), ensure_ascii=False)
    return text if text == str(value) else json.dumps(text)
