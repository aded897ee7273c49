"""The command line: what other programs and people call.

Words and progress go to stderr, results to stdout; bad input ends with one sentence and
exit code 2.  Heavy libraries are imported by the commands that need them.
"""

from __future__ import annotations

import argparse
import json
import os
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import NoReturn

from geometry.errors import InputError


class _Parser(argparse.ArgumentParser):
    def error(self, message: str) -> NoReturn:
        """Report a usage error the way all bad input is reported."""
        raise InputError(f"{message}; see {self.prog} --help")


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line and return the exit code."""
    try:
        options = _parser().parse_args(arguments)
        code: int = options.run(options)
        sys.stdout.flush()
    except InputError as error:
        print(f"tactgen: {error}", file=sys.stderr)
        return 2
    except KeyboardInterrupt:
        print("tactgen: interrupted; nothing half-written was kept", file=sys.stderr)
        return 130
    except BrokenPipeError:
        # the reader has gone: say nothing, and keep Python from complaining at exit
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 141
    return code


def _parser() -> argparse.ArgumentParser:
    parser = _Parser(
        prog="tactgen",
        description="Verification suite for a tactile generator: a piezo bimorph on a "
        "reluctance actuator, by lumped, transfer-matrix, beam and solid models.",
    )
    parser.set_defaults(run=lambda _: parser.exit(0, parser.format_help()))
    commands = parser.add_subparsers(title="commands", metavar="COMMAND")

    report = commands.add_parser("report", help="write the verification report (HTML)")
    _scene_options(report)
    report.add_argument("--out", default="report", metavar="DIR", help="folder (default report)")
    report.add_argument(
        "--quick", action="store_true", help="coarser meshes and one mesh family: a minute less"
    )
    report.set_defaults(run=_report)

    solve = commands.add_parser("solve", help="compute quantities")
    _scene_options(solve)
    solve.add_argument(
        "--model", action="append", metavar="NAME", help="lumped, tmm, beam, solid or all"
    )
    solve.add_argument("--quantity", action="append", metavar="NAME", help="may be repeated")
    solve.add_argument(
        "--frequency", metavar="LIST|START:STOP:N[:log]", help="in Hz, for example 10:2000:200"
    )
    solve.add_argument("--json", action="store_true", help="machine-readable result on stdout")
    solve.set_defaults(run=_solve)

    plan = commands.add_parser("plan", help="show what would run, what is skipped, and why")
    _scene_options(plan)
    plan.add_argument("--json", action="store_true", help="machine-readable plan on stdout")
    plan.set_defaults(run=_plan)

    export = commands.add_parser("export", help="write CAD or mesh files")
    _scene_options(export)
    export.add_argument("--step", metavar="FILE", help="solids as STEP (mm)")
    export.add_argument("--glb", metavar="FILE", help="solids as binary glTF")
    export.add_argument("--mesh", metavar="FILE.vtu", help="the solid model's mesh (m)")
    export.set_defaults(run=_export)

    scenes = commands.add_parser("scenes", help="list the built-in scenes")
    scenes.set_defaults(run=_scenes)

    init = commands.add_parser("init", help="write a commented scene file to start from")
    init.add_argument("file", metavar="FILE.toml")
    init.set_defaults(run=_init)
    return parser


def _scene_options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("scene", nargs="?", default="paper", help="file or built-in name")
    parser.add_argument(
        "--set",
        action="append",
        default=[],
        metavar="KEY=VALUE",
        dest="overrides",
        help="change a scene key, for example bimorph.length=25mm",
    )


def _solve(options: argparse.Namespace) -> int:
    from validation.progress import announcer
    from validation.scene import load_scene
    from validation.solve import as_json, solve

    overrides = list(options.overrides)
    if options.frequency is not None:
        overrides.append(f"frequency={options.frequency}")
    for name, key in ((options.model, "models"), (options.quantity, "quantities")):
        if name:
            overrides.append(f"{key}={','.join(name)}")
    scene, _ = load_scene(options.scene, overrides)
    with announcer() as announce:
        solution = solve(scene, announce=announce)
    for warning in solution.warnings:
        print(f"tactgen: warning: {warning}", file=sys.stderr)
    if options.json:
        json.dump(as_json(solution), sys.stdout)
        print()
    else:
        from validation.tables import print_quantities

        print_quantities(solution)
    return 0


def _plan(options: argparse.Namespace) -> int:
    from validation.plan import make_plan
    from validation.scene import load_scene
    from validation.solve import plan_json

    scene, _ = load_scene(options.scene, options.overrides)
    plan = make_plan(scene, scene.models, scene.quantities)
    if options.json:
        json.dump({"scene": scene.name, "plan": plan_json(plan)}, sys.stdout)
        print()
    else:
        from validation.tables import print_plan

        print_plan(scene.name, plan)
    return 0


def _report(options: argparse.Namespace) -> int:
    from validation.progress import announcer
    from validation.report import write_report
    from validation.scene import load_scene

    scene, origins = load_scene(options.scene, options.overrides)
    with announcer() as announce:
        page = write_report(scene, origins, Path(options.out), options.quick, announce)
    print(page)
    return 0


def _export(options: argparse.Namespace) -> int:
    from validation.export import export
    from validation.progress import announcer
    from validation.scene import load_scene

    scene, _ = load_scene(options.scene, options.overrides)
    targets = {kind: getattr(options, kind) for kind in ("step", "glb", "mesh")}
    wanted = {kind: Path(file) for kind, file in targets.items() if file}
    if not wanted:
        raise InputError("export needs at least one of --step FILE, --glb FILE, --mesh FILE.vtu")
    with announcer() as announce:
        for path in export(scene, wanted, announce):
            print(path)
    return 0


def _scenes(_: argparse.Namespace) -> int:
    from validation.scene import built_in_scenes

    for name, description in built_in_scenes().items():
        print(f"{name:12} {description}")
    return 0


def _init(options: argparse.Namespace) -> int:
    from validation.scene_template import write_template

    print(write_template(Path(options.file)))
    return 0


if __name__ == "__main__":
    sys.exit(main())
