"""``tactgen plan``: what would run, what is skipped, and why."""

from __future__ import annotations

import argparse
import json
import sys

from tactgen.validation.command_line.commands.common import Commands, scene_options


def add(commands: Commands) -> None:
    """Declare the command."""
    parser = commands.add_parser("plan", help="show what would run, what is skipped, and why")
    scene_options(parser)
    parser.add_argument("--json", action="store_true", help="machine-readable plan on stdout")
    parser.set_defaults(run=run)


def run(options: argparse.Namespace) -> int:
    """Run the command and return its exit code."""
    from tactgen.validation.engine.plan import make_plan
    from tactgen.validation.engine.solve import plan_json
    from tactgen.validation.scene.scene import load_scene

    scene, _ = load_scene(options.scene, options.overrides)
    plan = make_plan(scene, scene.models, scene.quantities)
    if options.json:
        json.dump({"scene": scene.name, "plan": plan_json(plan)}, sys.stdout)
        print()
    else:
        from tactgen.validation.command_line.tables import print_plan

        print_plan(scene.name, plan)
    return 0
