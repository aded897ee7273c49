"""``tactgen plan``: stages that would run or are skipped, why, and for how long."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING, Any

from tactgen.geometry.errors import InputError
from tactgen.validation.command_line.commands.common import (
    Commands,
    asked_overrides,
    asking_options,
    scene_options,
    under_contract,
)
from tactgen.validation.command_line.streams import announcer, print_json
from tactgen.validation.command_line.study_options import (
    AXES,
    axis_options,
    check_seed,
    stated,
    under_accuracy,
)

if TYPE_CHECKING:
    from tactgen.validation.engine.solve import Plan, Prospect


def add(commands: Commands) -> None:
    """Declare the command."""
    parser = commands.add_parser(
        "plan",
        help="show the stages that would run, are cached or are skipped, and why",
        formatter_class=argparse.RawDescriptionHelpFormatter,
        epilog=AXES,
    )
    scene_options(parser)
    asking_options(parser)
    axis_options(parser)
    parser.add_argument("--json", action="store_true", help="machine-readable plan on stdout")
    parser.set_defaults(run=run)


def run(options: argparse.Namespace) -> int:
    """Run the command and return its exit code."""
    if options.vary or options.sample is not None:
        return _of_study(options)
    if options.zip:
        raise InputError("--zip combines axes, and none is stated; add --vary, or remove it")
    check_seed(options.seed, samples=0)
    from tactgen.validation.engine.solve import make_plan, plan_json, stage_prospects
    from tactgen.validation.scene.load import load_scene

    scene, origins = load_scene(options.scene, [*options.overrides, *asked_overrides(options)])
    scene, choice = under_contract(scene, origins)
    plan = make_plan(scene, scene.models, scene.quantities)
    prospects = stage_prospects(plan)
    if options.json:
        shown: dict[str, Any] = plan_json(plan)
        for entry in shown["run"]:
            prospect = prospects[entry["stage"]]
            entry |= {"kept": prospect.kept, "seconds": prospect.seconds}
        found: dict[str, Any] = {"scene": scene.name, "plan": shown}
        if choice is not None:
            found["ladders"] = choice.ladders
        print_json(found)
    else:
        for sentence in choice.sentences if choice is not None else ():
            print(sentence)
        _print_plan(scene.name, plan, prospects)
    return 0


def _print_plan(scene: str, plan: Plan, prospects: dict[str, Prospect]) -> None:
    """Print the stages that run, with their last cost, and the skipped ones with reasons."""
    from tactgen.validation.engine.solve import total

    print(f"scene {scene}")
    print("runs:")
    for step in plan.run:
        found = prospects[step.stage]
        cost = "kept" if found.kept else f"{found.seconds:.2g} s" if found.seconds else ""
        print(f"  {step.stage:23} {cost:>7}  {step.reason}  [{step.key}]")
    print(f"  about {total(prospects):.2g} s in all, as far as costs are recorded")
    print("skipped:")
    for stage, reason in plan.skipped.items():
        print(f"  {stage:23} {reason}")


def _of_study(options: argparse.Namespace) -> int:
    """Print each model's planned points: cached, interpolated or solved."""
    from tactgen.validation.studies.whatif.study import plan_study

    statement, choice = under_accuracy(stated(options))
    with announcer() as announce:
        models = plan_study(statement, announce)
    if options.json:
        found: dict[str, Any] = {"scene": statement.scene, "study": models}
        if choice is not None:
            found["ladders"] = choice.ladders
        print_json(found)
    else:
        over = ", ".join(statement.columns)
        points = f"{statement.size} point{'s' if statement.size > 1 else ''}"
        print(f"study of {statement.scene}: {points} over {over}")
        for model in models:
            print("\n".join(model.sentences))
    return 0
