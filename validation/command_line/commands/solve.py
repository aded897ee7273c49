"""``tactgen solve``: compute quantities."""

from __future__ import annotations

import argparse
from dataclasses import replace

from tactgen.validation.command_line.commands.common import (
    Commands,
    asked_overrides,
    asking_options,
    scene_options,
    under_contract,
    warn,
)
from tactgen.validation.command_line.streams import announcer, print_json, say


def add(commands: Commands) -> None:
    """Declare the command."""
    parser = commands.add_parser(
        "solve", help="compute quantities", formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.listing = _listing
    scene_options(parser)
    asking_options(parser)
    parser.add_argument(
        "--amplitude", choices=("peak", "pp", "rms"), default="peak",
        help="state amplitudes as peak (default), pp (peak to peak) or rms",
    )  # fmt: skip
    parser.add_argument("--json", action="store_true", help="machine-readable result on stdout")
    parser.set_defaults(run=run)


def _listing() -> tuple[str, str]:
    from tactgen.validation.catalogue.models import MODELS
    from tactgen.validation.catalogue.quantities import QUANTITIES

    quantities = "\n".join(f"  {q.name:26} {q.meaning} ({q.unit})" for q in QUANTITIES.values())
    models = "\n".join(f"  {m.name:26} {m.description}" for m in MODELS.values())
    return "Compute quantities.", f"models:\n{models}\n\nquantities:\n{quantities}"


def run(options: argparse.Namespace) -> int:
    """Run the command and return its exit code."""
    from tactgen.validation.engine.answers import screen_lines, stated_as
    from tactgen.validation.engine.solve import as_json, check_request, solve
    from tactgen.validation.scene.conditions import conditions
    from tactgen.validation.scene.load import ON_COMMAND_LINE, load_scene
    from tactgen.validation.scene.warnings import scene_warnings

    scene, origins = load_scene(options.scene, [*options.overrides, *asked_overrides(options)])
    warn(scene_warnings(scene, origins))
    scene, choice = under_contract(scene, origins)
    checked = check_request(scene, scene.models, scene.quantities)
    with announcer() as announce:
        solution = solve(scene, announce=announce, checked=checked)
    for sentence in choice.sentences if choice is not None else ():
        say(sentence)
    warn(solution.warnings)
    stated = tuple(stated_as(q, options.amplitude) for q in solution.quantities)
    solution = replace(solution, quantities=stated)
    if options.json:
        print_json(as_json(solution))
        return 0
    print(conditions(solution.scene))
    if options.quantity or origins.get("quantities") == ON_COMMAND_LINE:
        print("\n".join(screen_lines(solution.quantities)))
    else:
        from tactgen.validation.command_line.overview import print_overview

        print_overview(solution)
    return 0
