"""``tactgen solve``: compute quantities."""

from __future__ import annotations

import argparse
import json
import sys

from tactgen.validation.command_line.commands.common import (
    Commands,
    overrides_of,
    scene_options,
    warn,
)


def add(commands: Commands) -> None:
    """Declare the command."""
    parser = commands.add_parser(
        "solve",
        help="compute quantities",
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.listing = _listing
    scene_options(parser)
    parser.add_argument(
        "--model", action="append", metavar="NAME", help="one of the models below, or all"
    )
    parser.add_argument(
        "--quantity", action="append", metavar="NAME", help="one below; may be repeated"
    )
    parser.add_argument(
        "--frequency", metavar="LIST|START:STOP:N[:log]", help="in Hz, for example 10:2000:200"
    )
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
    from tactgen.validation.command_line.progress import announcer
    from tactgen.validation.engine.solve import as_json, check_request, solve
    from tactgen.validation.scene.idle_keys import scene_warnings
    from tactgen.validation.scene.scene import load_scene

    scene, origins = load_scene(options.scene, [*options.overrides, *_wanted(options)])
    warn(scene_warnings(scene, origins))
    plan, _ = check_request(scene, scene.models, scene.quantities)
    with announcer([step.stage for step in plan.run]) as announce:
        solution = solve(scene, announce=announce)
    warn(solution.warnings)
    if options.json:
        json.dump(as_json(solution), sys.stdout)
        print()
    elif options.quantity or "quantities" in origins:
        from tactgen.validation.command_line.tables import print_quantities

        print_quantities(solution)
    else:
        from tactgen.validation.command_line.overview import print_overview

        print_overview(solution)
    return 0


def _wanted(options: argparse.Namespace) -> list[str]:
    """Return the overrides that --frequency, --model and --quantity stand for."""
    return [
        *overrides_of("frequency", "frequency", options.frequency, "10:2000:200"),
        *overrides_of("model", "models", options.model, "tmm"),
        *overrides_of("quantity", "quantities", options.quantity, "all"),
    ]
