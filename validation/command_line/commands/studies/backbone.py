"""``tactgen backbone``: the response at several voltages, where the head rocks on its stop."""

from __future__ import annotations

import argparse
import math
from pathlib import Path
from typing import TYPE_CHECKING, Any

from tactgen.geometry.errors import InputError
from tactgen.validation.command_line.commands.common import (
    Commands,
    lateral_scene,
    scene_options,
    warn,
)
from tactgen.validation.command_line.streams import print_json

if TYPE_CHECKING:
    from tactgen.validation.models.amplitude.backbone import Backbone, Curve
    from tactgen.validation.scene.scene import Scene

_EXAMPLE = "--voltage 0.1:2:6"
#: Most voltages of one request.
_MOST = 100


def add(commands: Commands) -> None:
    """Declare the command."""
    parser = commands.add_parser(
        "backbone", help="response and resonance over amplitude, on a head that may rock"
    )
    scene_options(parser)
    parser.add_argument(
        "--voltage", metavar="LIST|START:STOP:N[:log]",
        help=f"amplitudes in V, for example {_EXAMPLE[10:]} (default: the scene's)",
    )  # fmt: skip
    parser.add_argument(
        "--frequency", metavar="LOW:HIGH", help="band in Hz (default: that of the scene)"
    )
    parser.add_argument(
        "--model", default="tmm", metavar="NAME",
        help="of the bimorph: lumped, tmm (default), beam, solid or cad",
    )  # fmt: skip
    parser.add_argument("--plot", metavar="FILE.svg", help="draw it")
    parser.add_argument("--json", action="store_true", help="machine-readable result on stdout")
    parser.set_defaults(run=run)


def run(options: argparse.Namespace) -> int:
    """Run the command and return its exit code."""
    from tactgen.validation.command_line.progress import announcer
    from tactgen.validation.engine.inputs import scene_warnings
    from tactgen.validation.models.amplitude.backbone import backbone
    from tactgen.validation.models.amplitude.held_head import held_head

    scene, origins = lateral_scene(options.scene, options.overrides, "backbone")
    voltages = _voltages(options.voltage) if options.voltage else [abs(scene.drive.voltage)]
    band = _band(options.frequency) if options.frequency else _scene_band(scene)
    if options.plot and not options.plot.endswith(".svg"):
        raise InputError(
            f'--plot "{options.plot}" is not an SVG file; write for example --plot backbone.svg'
        )
    warn(scene_warnings(scene, origins))
    with announcer() as announce:
        announce("backbone")
        found = backbone(held_head(scene, options.model), voltages, band, announce)
        if options.plot:
            _draw(Path(options.plot), found)
    warn(found.warnings)
    if options.json:
        print_json(_as_json(scene, options.model, found))
    else:
        _print(scene, found)
    return 0


def _voltages(text: str) -> list[float]:
    """Return the amplitudes that ``--voltage`` states (V)."""
    import numpy as np

    parts = [part.strip() for part in text.split(":")]
    if len(parts) == 1:
        return [_volt(part, text) for part in text.split(",")]
    spaced = np.geomspace if parts[-1] == "log" else np.linspace
    count = parts[2] if len(parts) > 2 else ""
    if (
        len(parts) > 4
        or (len(parts) == 4 and parts[3] not in ("log", "lin"))
        or not (count.isascii() and count.isdigit() and 2 <= int(count) <= _MOST)
    ):
        raise InputError(
            f'--voltage "{text}" is not START:STOP:N or START:STOP:N:log with N from 2 to {_MOST}; '
            f"write for example {_EXAMPLE}"
        )
    return [float(v) for v in spaced(_volt(parts[0], text), _volt(parts[1], text), int(count))]


def _volt(part: str, text: str) -> float:
    from tactgen.geometry.units import VOLTAGE

    try:
        value = VOLTAGE.parse(part.strip(), bare=True)
    except ValueError:
        value = math.nan
    low, high = VOLTAGE.limits or (0.0, math.inf)
    if not low <= value <= high:
        raise InputError(
            f'--voltage "{text}" has "{part.strip()}", which is no amplitude above 0 V; write for '
            f"example {_EXAMPLE}"
        )
    return value


def _band(text: str) -> tuple[float, float]:
    from tactgen.validation.scene.frequencies import parse_frequencies

    low, colon, high = (part.strip() for part in text.partition(":"))
    found = parse_frequencies([low, high]) if low and colon and high else (0.0, 0.0)
    if not 0.0 < found[0] < found[1]:
        raise InputError(
            f'--frequency "{text}" is not LOW:HIGH above 0 Hz; write for example '
            "--frequency 100:1000"
        )
    return found[0], found[1]


def _scene_band(scene: Scene) -> tuple[float, float]:
    positive = [f for f in scene.frequency if f > 0.0]
    if len(positive) < 2:
        raise InputError(
            f"scene {scene.name} states no band of frequencies above 0 Hz; write for example "
            "--frequency 100:1000"
        )
    return min(positive), max(positive)


def _draw(file: Path, found: Backbone) -> None:
    from tactgen.geometry.files import write_text
    from tactgen.validation.report.sections.large_motion import backbone_plot

    write_text(file, backbone_plot(found))


def _print(scene: Scene, found: Backbone) -> None:
    place, support = found.head.place, found.head.support
    print(
        f"{scene.name}: head on its {place.kind} with {1e3 * place.contact_force:.4g} mN, small "
        f"rocking stiffness {support.rotational_stiffness:.4g} N m/rad"
    )
    print(f"{'voltage':>10} {'peak at':>12} {'+/-':>9} {'velocity':>12} {'+/-':>9} "
          f"{'tip':>11} {'M / N R':>8}  turns back at")  # fmt: skip
    for curve in found.curves:
        turns = ", ".join(f"{f:.5g} Hz" for f in curve.folds) or "-"
        for number, p in enumerate(curve.peaks):
            first = f"{curve.voltage:>8.4g} V" if not number else " " * 10
            print(f"{first} {p.frequency:>9.5g} Hz {p.frequency_bar:>9.2g} "
                  f"{1e3 * p.velocity:>7.4g} mm/s {1e3 * p.velocity_bar:>9.2g} "
                  f"{1e6 * p.displacement:>8.4g} µm {p.moment_share:>8.3f}  "
                  f"{turns if not number else ''}")  # fmt: skip
        if not curve.peaks:
            print(f"{curve.voltage:>8.4g} V {'no peak in the band':>33}  {turns}")


def _as_json(scene: Scene, model: str, found: Backbone) -> dict[str, Any]:
    return {
        "scene": scene.name,
        "model": model,
        "place": found.head.place,
        "small_rotational_stiffness": found.head.support.rotational_stiffness,
        "curves": [_curve(curve) for curve in found.curves],
        "warnings": list(found.warnings),
    }


def _curve(curve: Curve) -> dict[str, Any]:
    from tactgen.validation.engine.answers import plain

    displacement = [[w.real, w.imag] for w in curve.displacement.tolist()]
    return plain(curve) | {"displacement": displacement}  # type: ignore[no-any-return]
