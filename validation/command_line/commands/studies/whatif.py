"""``tactgen whatif``: a scene at many values of any of its keys."""

from __future__ import annotations

import argparse
import json
import sys
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from tactgen.geometry.errors import InputError
from tactgen.geometry.units import quoted
from tactgen.validation.command_line.commands.common import Commands, warn
from tactgen.validation.command_line.streams import say

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from tactgen.validation.studies.whatif.aim.best import Verdict
    from tactgen.validation.studies.whatif.aim.expression import Aim
    from tactgen.validation.studies.whatif.asked.statement import Statement
    from tactgen.validation.studies.whatif.run import Study

#: Most warnings that are printed, and most samples that can be drawn.
_WARNINGS = 8
_MOST_SAMPLES = 1_000_000


def add(commands: Commands) -> None:
    """Declare the command."""
    parser = commands.add_parser(
        "whatif",
        help="a scene at many values of any of its keys, by any model; only what changed is solved",
        formatter_class=argparse.RawDescriptionHelpFormatter,
        epilog=_EPILOG,
    )
    parser.add_argument(
        "scene", nargs="?", help="file or built-in name (default paper, or that of --resume)"
    )
    parser.add_argument(
        "--vary", action="append", default=[], metavar="KEY[=VALUES]", help="an axis, see below"
    )
    parser.add_argument(
        "--set", action="append", default=[], metavar="KEY=VALUE", dest="overrides",
        help="change a scene key at all points",
    )  # fmt: skip
    parser.add_argument(
        "--zip", action="store_true", help="take the axes' values hand in hand, not in combination"
    )
    parser.add_argument("--sample", metavar="N", help="draw N samples of ranges and distributions")
    parser.add_argument("--seed", metavar="S", help="of the samples (default 1)")
    parser.add_argument("--model", action="append", metavar="NAME", help="may be repeated")
    parser.add_argument("--quantity", action="append", metavar="NAME", help="may be repeated")
    parser.add_argument(
        "--frequency", metavar="LIST|START:STOP:N[:log]", help="in Hz, for example 10:2000:200"
    )
    parser.add_argument(
        "--aim", action="append", default=[], metavar="AIM",
        help="which points are wanted, see below; may be repeated",
    )  # fmt: skip
    parser.add_argument("--plot", metavar="FILE.svg", help="draw it")
    parser.add_argument(
        "--out", metavar="STUDY", help="folder for study.nc, study.csv and study.html"
    )
    parser.add_argument("--jobs", metavar="N", help="processes (default: as many as pay)")
    parser.add_argument(
        "--resume", action="store_true", help="go on with the study in --out, or let it grow"
    )
    parser.add_argument("--retry", action="store_true", help="try points that failed again")
    parser.add_argument("--json", action="store_true", help="machine-readable result on stdout")
    parser.set_defaults(run=run)


_EPILOG = """\
axes:
  KEY=START:STOP:N[:log]     N values from START to STOP, each with its unit
  KEY=a,b,c                  these values (of a profile parted by semicolons)
with --sample N also:
  KEY=START:STOP[:log]       drawn from the range
  KEY                        drawn from the tolerance that the scene states, or else assumes;
                             without --vary, of all the keys of which the scene states one
  KEY=normal(MEAN,DEVIATION) and uniform(LOW,HIGH), lognormal(MEDIAN,SHARE), loguniform(LOW,HIGH);
                             a deviation may be a share of the mean, such as 5%

aims:
  "min_over(tip_displacement / threshold) >= 1"     how many points meet it, and which is farthest
  "maximise first(short_circuit_frequencies)"       the best points; of two goals the Pareto front
  known are + - * / ( ), min_over, max_over, mean_over, first, abs, sqrt, numbers with units,
  quantities (of complex ones the magnitude), and threshold, the detection threshold

example:
  tactgen whatif paper --vary bimorph.length=14mm:22mm:9 --vary load.kind=none,finger \\
      --quantity short_circuit_frequencies --model tmm --model solid --out lengths
"""


def run(options: argparse.Namespace) -> int:
    """Run the command and return its exit code."""
    from tactgen.geometry.files import writable_folder
    from tactgen.validation.command_line.progress import announcer
    from tactgen.validation.studies.whatif.aim.best import parse_aims, verdict
    from tactgen.validation.studies.whatif.asked.statement import write_statement
    from tactgen.validation.studies.whatif.run import run_study

    folder = Path(options.out) if options.out is not None else None
    processes = _whole(options.jobs, "--jobs", 1, 512, "2") if options.jobs else 0
    if options.plot and not options.plot.endswith(".svg"):
        raise InputError(
            f'--plot "{options.plot}" is not an SVG file; write for example --plot study.svg'
        )
    aims = parse_aims(options.aim)
    statement = _with_quantities(_statement(options, folder), aims)
    _ = statement.size  # axes that cannot be used are refused before anything is written
    if folder is not None:
        write_statement(writable_folder(folder), statement)
    with announcer() as announce:
        study = run_study(statement, processes, announce, retry=options.retry)
        if folder is not None:
            announce("writing")
            _write(folder, study, announce)
        if options.plot:
            announce("drawing")
            _draw(Path(options.plot), study)
    _show(options, study, verdict(study, aims) if aims else None)
    return 0


def _with_quantities(statement: Statement, aims: Sequence[Aim]) -> Statement:
    """Return the statement with what the aims name added to its quantities."""
    from tactgen.validation.catalogue.models import gives

    wanted = dict.fromkeys(name for aim in aims for name in aim.quantities)
    missing = tuple(name for name in wanted if name not in statement.quantities)
    for name in missing:
        if not any(gives(model, name) for model in statement.models):
            raise InputError(
                f"the aim names {name}, which {', '.join(statement.models)} do not give; add a "
                "--model that does"
            )
    return replace(statement, quantities=statement.quantities + missing)


def _draw(file: Path, study: Study) -> None:
    from tactgen.geometry.files import write_text
    from tactgen.validation.studies.whatif.shown.pictures import study_picture

    write_text(file, study_picture(study))


def _statement(options: argparse.Namespace, folder: Path | None) -> Statement:
    """Return what the options ask; where they are silent, what the study asked before."""
    from tactgen.validation.studies.whatif.asked.statement import FILE, read_statement

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
    return _stated(options, before)


def _stated(options: argparse.Namespace, before: Statement | None) -> Statement:
    from tactgen.validation.scene.scene import scene_values
    from tactgen.validation.studies.whatif.asked.choice import chosen
    from tactgen.validation.studies.whatif.asked.statement import Statement
    from tactgen.validation.studies.whatif.asked.tolerance_axes import with_tolerances

    overrides = list(options.overrides)
    if options.frequency is not None:
        overrides.append(f"frequency={options.frequency}")
    if before is not None and options.scene is None and not overrides:
        values, base = before.values, before
    else:
        values, _ = scene_values(options.scene or "paper", overrides)
        base = before or Statement("", {}, (), (), ())
    models, quantities = chosen(values, options.model, options.quantity, base)
    samples = (
        _whole(options.sample, "--sample", 1, _MOST_SAMPLES, "16")
        if options.sample is not None
        else base.samples
    )
    vary, drawn = with_tolerances(values, tuple(options.vary) or base.vary, sampled=samples > 0)
    for line in drawn:
        say(f"note: {line}")
    return replace(
        base, scene=str(values["name"]), values=values, models=models, quantities=quantities,
        vary=vary, zipped=options.zip or base.zipped, samples=samples,
        seed=(
            _whole(options.seed, "--seed", 0, 2**31, "1")
            if options.seed is not None else base.seed
        ),
    )  # fmt: skip


def _whole(text: str, option: str, least: int, most: int, example: str) -> int:
    number = int(text) if text.strip().isdecimal() and len(text) < 12 else least - 1
    if not least <= number <= most:
        raise InputError(
            f"{option} {quoted(text)} is not a whole number from {least} to {most}; write for "
            f"example {option} {example}"
        )
    return number


def _write(folder: Path, study: Study, announce: Callable[[str], None]) -> None:
    from tactgen.validation.studies.whatif.shown.netcdf import write_netcdf
    from tactgen.validation.studies.whatif.shown.page import write_page
    from tactgen.validation.studies.whatif.shown.tidy import write_tidy

    write_tidy(folder, study)
    write_netcdf(folder, study)
    if any(answer.status == "ok" for _, _, answer in study.rows):
        write_page(folder, study, announce)


def _show(options: argparse.Namespace, study: Study, found: Verdict | None) -> None:
    from tactgen.validation.studies.whatif.aim.wording import as_values, sentences
    from tactgen.validation.studies.whatif.shown.summary import table_lines

    warnings = study.warnings
    warn(warnings[:_WARNINGS])
    if len(warnings) > _WARNINGS:
        warn([f"{len(warnings) - _WARNINGS} more kinds of warnings"
              + (f", see {options.out}/study.csv" if options.out else "")])  # fmt: skip
    if options.json:
        aims = {"aims": as_values(study, found)} if found else {}
        json.dump({**_as_json(study), **aims}, sys.stdout, allow_nan=False)
        print()
    else:
        print("\n".join([*table_lines(study), *(sentences(study, found) if found else ())]))
    counts = study.counts
    where = f", written to {options.out}" if options.out else ""
    together = f" ({counts.together} from a reduced basis)" if counts.together else ""
    print(
        f"{len(study.points)} points: {counts.computed} answers computed{together}, "
        f"{counts.recalled} kept "
        f"from before, {counts.failed} failed, {counts.refused} refused{where}",
        file=sys.stderr,
    )


def _as_json(study: Study) -> dict[str, Any]:
    """Return the study as plain JSON values, SI units."""
    from tactgen.validation.command_line.plain_values import plain
    from tactgen.validation.engine.results import quantity_json

    stated = study.statement
    return {
        "scene": stated.scene,
        "axes": [
            {"key": a.key, "unit": a.unit, "dimension": stated.columns[a.key][0],
             "values": plain(list(stated.columns[a.key][1]))}
            for a in stated.axes
        ],
        "points": [
            {"at": point, "model": model, "status": answer.status, "reason": answer.reason,
             "seconds": answer.seconds, "quantities": [quantity_json(q) for q in answer.quantities],
             "warnings": list(answer.warnings)}
            for point, model, answer in study.rows
        ],
        "counts": plain(study.counts),
    }  # fmt: skip
