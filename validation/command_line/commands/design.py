"""``tactgen design``: the length for the paper's aim, or any keys for aims of one's own."""

from __future__ import annotations

import argparse
import math
from pathlib import Path
from typing import TYPE_CHECKING

from tactgen.geometry.errors import InputError
from tactgen.geometry.synonyms import nearest
from tactgen.validation.command_line.commands.common import (
    Commands,
    check_svg,
    lateral_scene,
    low_high,
    scene_options,
    warn,
)
from tactgen.validation.command_line.streams import announcer, print_json

if TYPE_CHECKING:
    from tactgen.validation.scene.scene import Scene
    from tactgen.validation.studies.length_design import Aim


def add(commands: Commands) -> None:
    """Declare the command."""
    parser = commands.add_parser(
        "design",
        help="find the best length, or the best values of any keys, for given aims",
        formatter_class=argparse.RawDescriptionHelpFormatter,
        epilog=_EPILOG,
    )
    scene_options(parser)
    parser.add_argument(
        "--aim", action="append", metavar="AIM",
        help="shortest (default): shortest length that meets the margin; margin: length of the "
        "largest margin; with --vary: see below, may be repeated",
    )  # fmt: skip
    parser.add_argument(
        "--vary", action="append", default=[], metavar="KEY=LOW:HIGH[:log]",
        help="key and range to search; may be repeated",
    )  # fmt: skip
    parser.add_argument("--model", action="append", metavar="NAME", help="model, with --vary")
    parser.add_argument(
        "--margin", metavar="FACTOR",
        help="minimum ratio of deflection to detection threshold (default 1)",
    )  # fmt: skip
    parser.add_argument(
        "--band", metavar="LOW:HIGH",
        help="frequency band in Hz (default: that of the threshold, 10:1000)",
    )  # fmt: skip
    parser.add_argument(
        "--lengths", metavar="LOW:HIGH", help="range of lengths (default 20mm:40mm, the paper's)"
    )
    parser.add_argument("--plot", metavar="FILE.svg", help="write a plot")
    parser.add_argument("--json", action="store_true", help="machine-readable result on stdout")
    parser.set_defaults(run=run)


_EPILOG = """\
with --vary:
  "first(short_circuit_frequencies) >= 400 Hz"     a condition
  "maximise static_tip_displacement"               the goal; without one the least change is found
  known are + - * / ( ), min_over, max_over, mean_over, first, abs, sqrt, numbers with units,
  quantities (of complex ones the magnitude), scene keys such as bimorph.length, and threshold, the
  detection threshold

example:
  tactgen design paper --vary bimorph.length=14mm:22mm --vary bimorph.piezo_thickness=0.2mm:0.3mm \\
      --model solid --aim "maximise static_tip_displacement" \\
      --aim "first(short_circuit_frequencies) >= 400 Hz"
"""


def run(options: argparse.Namespace) -> int:
    """Run the command and return its exit code."""
    if options.vary:
        return _search(options)
    return _length_design(options)


def _search(options: argparse.Namespace) -> int:
    """Search the values of any keys."""
    from tactgen.validation.scene.load import scene_values
    from tactgen.validation.studies.whatif.aim_evaluation import named_quantities, parse_aims
    from tactgen.validation.studies.whatif.defaults import chosen
    from tactgen.validation.studies.whatif.definition import Statement
    from tactgen.validation.studies.whatif.optimisation import as_values, search, sentences

    for option in ("margin", "band", "lengths", "plot"):
        if getattr(options, option):
            raise InputError(
                f"--{option} is of the length that --aim shortest or margin finds; remove it, "
                "or --vary"
            )
    if not options.aim:
        raise InputError(
            '--vary needs an aim; write for example --aim "maximise static_tip_displacement"'
        )
    aims = parse_aims(options.aim)
    values, _ = scene_values(options.scene, options.overrides)
    # without --model the quick one, whichever models the scene lists for tables
    models, quantities = chosen({}, options.model, named_quantities(aims), Statement())
    statement = Statement(
        str(values["name"]), values, tuple(options.vary), models, quantities, samples=1
    )
    with announcer() as announce:
        found = search(statement, aims, announce)
    if options.json:
        print_json(as_values(found))
    else:
        print("\n".join(sentences(found)))
    return 0


def _length_design(options: argparse.Namespace) -> int:
    """Find the length for the paper's aim."""
    import numpy as np

    from tactgen.geometry.files import write_text
    from tactgen.validation.catalogue.quantities import TIP_DISPLACEMENT
    from tactgen.validation.engine.warnings import field_warnings
    from tactgen.validation.scene.warnings import scene_warnings
    from tactgen.validation.studies import length_design_output as output
    from tactgen.validation.studies.length_design import CURVES, dependences, design
    from tactgen.validation.studies.length_map import length_map

    scene, origins = lateral_scene(options.scene, options.overrides, "design")
    aim = _aim(scene, options)
    check_svg(options.plot, "length.svg")
    warn(scene_warnings(scene, origins))
    with announcer() as announce:
        announce("length design")
        result = design(scene, aim)
        study = length_map(scene, np.linspace(*aim.lengths, CURVES), aim.band)
        announce("what the length depends on")
        rows = dependences(result, origins)
        if options.plot:
            write_text(Path(options.plot), output.length_plot(study, result))
    warn((*field_warnings(scene, (TIP_DISPLACEMENT.name,)), *result.warnings))
    if options.json:
        print_json(output.as_json(study, result, rows))
    else:
        print("\n".join(output.lines(study, result, rows)))
    return 0


def _aim(scene: Scene, options: argparse.Namespace) -> Aim:
    from tactgen.validation.catalogue.detection import threshold_of
    from tactgen.validation.scene.files import parse_frequencies
    from tactgen.validation.studies.length_design import Aim, AimKind, stated_band
    from tactgen.validation.studies.whatif.axes import scene_field

    kinds: dict[str, AimKind] = {"shortest": "shortest", "margin": "margin"}
    aims = options.aim or ["shortest"]
    unknown = [aim for aim in aims if aim not in kinds]
    if unknown:
        raise InputError(
            f'--aim "{unknown[0]}" is neither shortest nor margin{nearest(unknown[0], kinds)}, '
            "which are of the length; for an aim of your own name what may change, for example "
            "--vary bimorph.length=14mm:22mm"
        )
    if len(aims) > 1:
        raise InputError(
            f"--aim is given {len(aims)} times, and a length is found for one; leave the others out"
        )
    if options.model:
        raise InputError("--model goes with --vary; the length for --aim shortest is found by tmm")
    try:
        margin = float(options.margin or "1")
    except ValueError:
        margin = math.nan
    if not math.isfinite(margin):
        raise InputError(
            f'--margin "{options.margin}" is not a number; write for example --margin 1.5'
        )
    threshold = threshold_of(scene.threshold)
    band = stated_band(threshold)
    if options.band is not None:
        low, high = low_high(options.band, "--band", "10:1000")
        first, last = parse_frequencies([low, high], f'--band = "{options.band}"')
        band = first, last
    ends = low_high(options.lengths or "20mm:40mm", "--lengths", "20mm:40mm")
    short, long = (scene_field("bimorph.length").read(end, "--lengths") for end in ends)
    return Aim(kinds[aims[0]], margin, band, (short, long), threshold)
