"""``tactgen whatif``: a scene at many values of any of its keys."""

from __future__ import annotations

import argparse
import sys
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from tactgen.geometry.errors import InputError
from tactgen.validation.command_line.commands.common import (
    Commands,
    asking_options,
    check_svg,
    scene_options,
    warn,
)
from tactgen.validation.command_line.streams import announcer, print_json
from tactgen.validation.command_line.study_options import (
    AXES,
    axis_options,
    stated,
    under_accuracy,
    whole_number,
)

if TYPE_CHECKING:
    from collections.abc import Sequence

    from tactgen.validation.engine.comparison import Choice
    from tactgen.validation.studies.whatif.aim_evaluation import Verdict
    from tactgen.validation.studies.whatif.definition import Statement
    from tactgen.validation.studies.whatif.study import Study

#: Most warnings that are printed.
_WARNINGS = 8


def add(commands: Commands) -> None:
    """Declare the command."""
    parser = commands.add_parser(
        "whatif",
        help="study of a scene over any of its keys, by any model",
        formatter_class=argparse.RawDescriptionHelpFormatter,
        epilog=_EPILOG,
    )
    scene_options(parser, default=None)
    asking_options(parser)
    axis_options(parser)
    parser.add_argument(
        "--aim", action="append", default=[], metavar="AIM",
        help="condition or goal, see below; may be repeated",
    )  # fmt: skip
    parser.add_argument("--plot", metavar="FILE.svg", help="write a plot")
    parser.add_argument(
        "--out", metavar="STUDY", help="output folder for study.csv, study.nc and study.html"
    )
    parser.add_argument("--jobs", metavar="N", help="number of processes (default: automatic)")
    parser.add_argument(
        "--scheduler", metavar="ADDRESS",
        help="use the workers of a Dask cluster, for example tcp://127.0.0.1:8786",
    )  # fmt: skip
    parser.add_argument(
        "--resume", action="store_true", help="continue or extend the study in --out"
    )
    parser.add_argument("--retry", action="store_true", help="compute failed points again")
    parser.add_argument("--json", action="store_true", help="machine-readable result on stdout")
    parser.set_defaults(run=run)


_EPILOG = (
    AXES
    + """\

aims:
  "min_over(tip_displacement / threshold) >= 1"     a condition
  "maximise first(short_circuit_frequencies)"       a goal; two goals give the Pareto front
  An aim contains quantities (complex ones by their magnitude), threshold (the detection
  threshold), numbers with units, + - * / ( ), min_over, max_over, mean_over, first, abs, sqrt.

example:
  tactgen whatif paper --vary bimorph.length=14mm:22mm:9 --vary load.kind=none,finger \\
      --quantity short_circuit_frequencies --model tmm --model solid --out lengths
"""
)


def run(options: argparse.Namespace) -> int:
    """Run the command and return its exit code."""
    from tactgen.geometry.files import writable_folder, write_text
    from tactgen.validation.studies.whatif.aim_evaluation import (
        named_quantities,
        parse_aims,
        verdicts,
    )
    from tactgen.validation.studies.whatif.definition import write_statement
    from tactgen.validation.studies.whatif.pictures import study_picture
    from tactgen.validation.studies.whatif.study import run_study

    folder = Path(options.out) if options.out is not None else None
    processes = whole_number(options.jobs, "--jobs", 1, 512, "2") if options.jobs else 0
    scheduler = _scheduler(options)
    check_svg(options.plot, "study.svg")
    aims = parse_aims(options.aim)
    statement = _with_quantities(_statement(options, folder), named_quantities(aims))
    _ = statement.size  # axes that cannot be used are refused before anything is written
    statement, choice = under_accuracy(statement)
    if folder is not None:
        write_statement(writable_folder(folder), statement)
    with announcer() as announce:
        study = run_study(statement, processes, announce, retry=options.retry, scheduler=scheduler)
        found = verdicts(study, aims) if aims else None
        if folder is not None:
            announce("writing")
            _write(folder, study, found)
        if options.plot:
            announce("drawing")
            write_text(Path(options.plot), study_picture(study))
    _show(options, study, found, choice)
    return 0


def _scheduler(options: argparse.Namespace) -> str:
    from tactgen.validation.studies.whatif.executor import check_address

    if options.scheduler is None:
        return ""
    if options.jobs is not None:
        raise InputError(
            "--jobs counts processes of this machine, and --scheduler names a cluster that solves "
            "in its place; remove one of them"
        )
    return check_address(options.scheduler)


def _with_quantities(statement: Statement, wanted: Sequence[str]) -> Statement:
    """Study definition with the aims' quantities added."""
    from tactgen.validation.catalogue.models import gives

    missing = tuple(name for name in wanted if name not in statement.quantities)
    for name in missing:
        if not (statement.by_accuracy or any(gives(model, name) for model in statement.models)):
            raise InputError(
                f"the aim names {name}, which {', '.join(statement.models)} do not give; add a "
                "--model that does"
            )
    return replace(statement, quantities=statement.quantities + missing)


def _statement(options: argparse.Namespace, folder: Path | None) -> Statement:
    """Study definition from the options, or else from the earlier study."""
    from tactgen.validation.studies.whatif.definition import FILE, read_statement

    if options.resume and folder is None:
        raise InputError("--resume needs the study to go on with; add --out STUDY")
    if folder is not None and (folder / FILE).exists() and not options.resume:
        raise InputError(
            f"{folder} holds a study already; add --resume to go on with it or to let it grow, "
            "since its points are kept, or choose another folder with --out"
        )
    before = None
    fresh = options.scene or options.overrides or options.frequency or options.vary
    if options.resume and folder is not None and ((folder / FILE).exists() or not fresh):
        before = read_statement(folder)
    return stated(options, before)


def _write(folder: Path, study: Study, found: Sequence[Verdict] | None) -> None:
    from tactgen.validation.studies.whatif import output_files as output
    from tactgen.validation.studies.whatif.netcdf_file import write_netcdf
    from tactgen.validation.studies.whatif.page import write_page

    output.write_tidy(folder, study)
    if study.statement.samples:
        output.write_statistics(folder, study, output.sample_statistics(study))
    write_netcdf(folder, study)
    if any(answer.status == "ok" for _, _, answer in study.rows):
        write_page(folder, study, found)


def _show(
    options: argparse.Namespace,
    study: Study,
    found: Sequence[Verdict] | None,
    choice: Choice | None,
) -> None:
    from tactgen.validation.studies.whatif import output_files as output
    from tactgen.validation.studies.whatif.aim_evaluation import as_values, sentences

    warnings = *study.without_effect, *study.warnings
    statistics = output.sample_statistics(study)
    warn(warnings[:_WARNINGS])
    if len(warnings) > _WARNINGS:
        warn([f"{len(warnings) - _WARNINGS} more kinds of warnings"
              + (f", see {options.out}/study.csv" if options.out else "")])  # fmt: skip
    if options.json:
        aims = {} if found is None else {"aims": [as_values(study, each) for each in found]}
        ladders = {"ladders": choice.ladders} if choice else {}
        print_json({**output.as_json(study), "statistics": statistics, **aims, **ladders})
    else:
        rest = f"{options.out}/study.csv has all" if options.out else "--out STUDY writes all"
        said = [] if found is None else sentences(study, found)
        table = output.table_lines(study, rest)
        lines = [*table, *output.statistics_lines(study, statistics), *said]
        print("\n".join(filter(None, [study.statement.conditions, *lines])))
    counts = study.counts
    where = f", written to {options.out}" if options.out else ""
    size = len(study.points)
    by = f" by {many} models" if (many := len(study.statement.models)) > 1 else ""
    between = f", {counts['interpolated']} interpolated" if counts["interpolated"] else ""
    print(
        f"{size} point{'s' if size > 1 else ''}{by}: {counts['computed']} answers computed"
        f"{between}, {counts['recalled']} kept "
        f"from before, {counts['failed']} failed, {counts['refused']} refused{where}",
        file=sys.stderr,
    )
