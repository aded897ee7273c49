"""The command line: what other programs and people call.

Words and progress go to stderr, results to stdout; bad input ends with one sentence and
exit code 2.  Heavy libraries are imported by the commands that need them.
"""

from __future__ import annotations

import argparse
import contextlib
import json
import os
import sys
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path
from typing import NoReturn

from geometry.errors import InputError


class _Parser(argparse.ArgumentParser):
    def error(self, message: str) -> NoReturn:
        """Report a usage error the way all bad input is reported."""
        raise InputError(f"{message}; see {self.prog} --help")


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line and return the exit code."""
    scene, code = "", 0
    if sys.stderr is None:  # closed: words and progress go nowhere, not to stdout
        sys.stderr = Path(os.devnull).open("w", encoding="utf-8")  # noqa: SIM115
    try:
        if sys.stdout is None:
            raise InputError("standard output is closed; leave it open or send it to a file")
        with contextlib.suppress(SystemExit):  # --help
            options = _parser().parse_args(arguments)
            scene = getattr(options, "scene", "")
            code = options.run(options)
        sys.stdout.flush()
    except KeyboardInterrupt:
        _say("interrupted; nothing half-written was kept")
        return 130
    except BrokenPipeError:
        _drop_output()
        return 141
    except Exception as error:
        text = _explained(error, scene)
        if text is None:
            raise
        _say(text)
        return 2
    return code


def _explained(error: Exception, scene: str) -> str | None:
    """Return the sentence for an error that a user can act on, None for a mistake of ours."""
    if isinstance(error, InputError):
        return str(error)
    if isinstance(error, OSError):
        reason = (error.strerror or str(error)).lower()
        if error.filename is not None:
            return f"{error.filename} cannot be used ({reason}); make room or choose another place"
        _drop_output()
        return f"standard output cannot be written ({reason}); send it somewhere else"
    # by name: importing the solvers costs more than most answers
    names = {kind.__name__ for kind in type(error).__mro__}
    if names & {"LinAlgError", "SolverError", "ArpackError", "ArithmeticError", "MemoryError"}:
        reason = str(error) or type(error).__name__
        return (
            f'scene "{scene}" cannot be solved ({reason}); bring the values that it sets closer to '
            "those of the built-in scene paper, or ask for another model with --model"
        )
    return None


def _say(text: str) -> None:
    """Print one line to stderr, if that can be written."""
    from validation.wording import one_line

    with contextlib.suppress(OSError):
        print(f"tactgen: {one_line(text)}", file=sys.stderr)


def _drop_output() -> None:
    """Send what is left of stdout nowhere, so that Python does not complain at exit."""
    with contextlib.suppress(OSError, ValueError, AttributeError):
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


def _parser() -> argparse.ArgumentParser:
    parser = _Parser(
        prog="tactgen",
        description="Verification suite for a tactile generator: a piezo bimorph on a "
        "reluctance actuator, by lumped, transfer-matrix, beam and solid models.",
    )
    parser.set_defaults(run=lambda _: _help(parser))
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


def _help(parser: argparse.ArgumentParser) -> int:
    print(parser.format_help(), end="")
    return 0


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
    from validation.scene import load_scene, scene_warnings
    from validation.solve import as_json, solve

    scene, origins = load_scene(options.scene, [*options.overrides, *_wanted(options)])
    _warn(scene_warnings(scene, origins))
    with announcer() as announce:
        solution = solve(scene, announce=announce)
    _warn(solution.warnings)
    if options.json:
        json.dump(as_json(solution), sys.stdout)
        print()
    else:
        from validation.tables import print_quantities

        print_quantities(solution)
    return 0


def _wanted(options: argparse.Namespace) -> Iterator[str]:
    """Yield the overrides that --frequency, --model and --quantity stand for."""
    stated = (
        ("frequency", "frequency", options.frequency, "10:2000:200"),
        ("model", "models", options.model, "tmm"),
        ("quantity", "quantities", options.quantity, "tip_velocity"),
    )
    for name, key, given, example in stated:
        if given is None:
            continue
        text = given if isinstance(given, str) else ",".join(given)
        if not text.strip():
            raise InputError(f"--{name} is empty; write for example --{name} {example}")
        yield f"{key}={text}"


def _warn(warnings: Iterable[str]) -> None:
    for warning in warnings:
        _say(f"warning: {warning}")


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
    from validation.scene import load_scene, scene_warnings

    scene, origins = load_scene(options.scene, options.overrides)
    _warn(scene_warnings(scene, origins))
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
    from validation.scene_file import built_in_scenes

    for name, description in built_in_scenes().items():
        print(f"{name:12} {description}")
    return 0


def _init(options: argparse.Namespace) -> int:
    from validation.scene_template import write_template

    print(write_template(Path(options.file)))
    return 0


if __name__ == "__main__":
    sys.exit(main())
