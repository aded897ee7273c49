"""``tactgen backbone``: the response at several voltages, where the head rocks on its stop."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING, Any

from tactgen.geometry.errors import InputError
from tactgen.validation.command_line.commands.common import (
    Commands,
    check_svg,
    lateral_scene,
    low_high,
    scene_options,
    values_of,
    warn,
)
from tactgen.validation.command_line.streams import announcer, print_json

if TYPE_CHECKING:
    from tactgen.validation.models.backbone import Backbone
    from tactgen.validation.scene.scene import Scene

_EXAMPLE = "0.1:2:6"
#: Most voltages of one request.
_MOST = 100


def add(commands: Commands) -> None:
    """Declare the command."""
    parser = commands.add_parser(
        "backbone", help="response over the voltage, with a rod that rocks on its stop"
    )
    scene_options(parser)
    parser.add_argument(
        "--voltage", metavar="LIST|START:STOP:N[:log]",
        help=f"voltage amplitudes, for example {_EXAMPLE} (default: the scene's)",
    )  # fmt: skip
    parser.add_argument(
        "--frequency", metavar="LOW:HIGH", help="frequency band in Hz (default: the scene's)"
    )
    parser.add_argument(
        "--model", default="tmm", metavar="NAME",
        help="model of the bimorph: lumped, tmm (default), beam, solid or cad",
    )  # fmt: skip
    parser.add_argument("--plot", metavar="FILE.svg", help="write a plot")
    parser.add_argument("--json", action="store_true", help="machine-readable result on stdout")
    parser.set_defaults(run=run)


def run(options: argparse.Namespace) -> int:
    """Run the command and return its exit code."""
    from tactgen.geometry.units import VOLTAGE
    from tactgen.validation.models.backbone import backbone, check_one_field, held_head
    from tactgen.validation.scene.conditions import conditions
    from tactgen.validation.scene.warnings import scene_warnings

    scene, origins = lateral_scene(options.scene, options.overrides, "backbone")
    voltages = [abs(scene.drive.voltage)]
    if options.voltage:
        voltages = values_of(options.voltage, "--voltage", VOLTAGE, _EXAMPLE, _MOST)
    band = _band(options.frequency) if options.frequency else _scene_band(scene)
    check_svg(options.plot, "backbone.svg")
    check_one_field(scene, voltages)
    warn(scene_warnings(scene, origins))
    with announcer() as announce:
        announce("backbone")
        result = backbone(held_head(scene, options.model), voltages, band, announce)
        if options.plot:
            from tactgen.geometry.files import write_text
            from tactgen.validation.report.sections.large_motion import backbone_plot

            write_text(Path(options.plot), backbone_plot(result))
    warn(result.warnings)
    if options.json:
        print_json(_as_json(scene, options.model, result))
    else:
        print(conditions(scene))
        _print(scene, result)
    return 0


def _band(text: str) -> tuple[float, float]:
    from tactgen.validation.scene.files import parse_frequencies

    low, high = parse_frequencies(list(low_high(text, "--frequency", "100:1000")))
    if not 0.0 < low < high:
        raise InputError(
            f'--frequency "{text}" does not rise from above 0 Hz; write for example '
            "--frequency 100:1000"
        )
    return low, high


def _scene_band(scene: Scene) -> tuple[float, float]:
    positive = [f for f in scene.frequency if f > 0.0]
    if len(positive) < 2:
        raise InputError(
            f"scene {scene.name} states no band of frequencies above 0 Hz; write for example "
            "--frequency 100:1000"
        )
    return min(positive), max(positive)


def _print(scene: Scene, result: Backbone) -> None:
    place, support = result.head.place, result.head.support
    print(
        f"{scene.name}: head on its {place.kind} with {1e3 * place.contact_force:.4g} mN, small "
        f"rocking stiffness {support.rotational_stiffness:.4g} N m/rad"
    )
    print(f"{'voltage':>10} {'peak at':>12} {'+/-':>9} {'velocity':>12} {'+/-':>9} "
          f"{'tip':>11} {'M / N R':>8}  turns back at")  # fmt: skip
    for curve in result.curves:
        first = f"{curve.voltage:>8.4g} V"
        turns = ", ".join(f"{f:.5g} Hz" for f in curve.folds) or "-"
        for p in curve.peaks:
            print(f"{first:10} {p.frequency:>9.5g} Hz {p.frequency_bar:>9.2g} "
                  f"{1e3 * p.velocity:>7.4g} mm/s {1e3 * p.velocity_bar:>9.2g} "
                  f"{1e6 * p.displacement:>8.4g} µm {p.moment_share:>8.3f}  {turns}")  # fmt: skip
            first = turns = ""
        if not curve.peaks:
            print(f"{first} {'no peak in the band':>33}  {turns}")


def _as_json(scene: Scene, model: str, result: Backbone) -> dict[str, Any]:
    from tactgen.validation.engine.answers import plain
    from tactgen.validation.scene.conditions import answer_head

    return {
        **answer_head(scene),
        "model": model,
        "place": result.head.place,
        "small_rotational_stiffness": result.head.support.rotational_stiffness,
        "curves": [
            plain(curve) | {"displacement": [[w.real, w.imag] for w in curve.displacement.tolist()]}
            for curve in result.curves
        ],
        "warnings": result.warnings,
    }
