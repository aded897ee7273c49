"""``tactgen verify``, ``coverage``, ``stress`` and ``bench``: evidence in parts, and its files."""

from __future__ import annotations

import argparse
import secrets
from collections.abc import Callable, Collection, Sequence
from functools import partial
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

from tactgen.validation.command_line.commands.common import Commands
from tactgen.validation.command_line.streams import announcer, name_files, print_json, say
from tactgen.validation.command_line.study_options import MOST_SEED, whole_number

if TYPE_CHECKING:
    from tactgen.validation.evidence.verification import Extent, Verified

Part = TypeVar("Part")

#: Most devices for each part.
_MOST = 999_999_999


def _declare(
    commands: Commands, name: str, words: str, parts: str, run: Callable[[argparse.Namespace], int]
) -> argparse.ArgumentParser:
    """Parser of a command that runs parts, which "module.NAME" lists when help is asked for."""
    parser: argparse.ArgumentParser = commands.add_parser(name, help=words)
    module, _, name_of_parts = parts.partition(".")

    def listing() -> tuple[str, str]:
        home = import_module(f"tactgen.validation.evidence.{module}")
        return f"{words.capitalize()}.", f"parts: {', '.join(getattr(home, name_of_parts))}"

    parser.listing = listing  # type: ignore[attr-defined]
    only = "one of the parts below; may be repeated (default: all)"
    parser.add_argument("--only", action="append", metavar="PART", help=only)
    parser.add_argument(
        "--out", type=Path, metavar="DIR", help="also write tables and plots to this folder"
    )
    parser.add_argument("--json", action="store_true", help="machine-readable result on stdout")
    parser.set_defaults(run=run)
    return parser


def _run(
    options: argparse.Namespace,
    known: Collection[str],
    work: Callable[[Sequence[str], Callable[[str], None]], list[Part]],
    write: Callable[[list[Part], Path, Callable[[str], None]], Sequence[Path]],
    show: Callable[[list[Part]], None],
    record: Callable[[list[Part]], dict[str, Any]],
) -> list[Part]:
    """Run the chosen parts, write files, print tables or JSON, name the files; return the parts.

    Files come first: nobody may be there to read what is printed.
    """
    from tactgen.geometry.files import writable_folder
    from tactgen.validation.scene.files import choices

    names = choices(",".join(options.only or known), tuple(known), "part", "--only")
    if options.out is not None:
        writable_folder(options.out)
    with announcer() as announce:
        found = work(names, announce)
        files = write(found, options.out, announce) if options.out is not None else ()
    if options.json:
        print_json(record(found))
    else:
        show(found)
    name_files(files)
    return found


# ---- verify ----


def add_verify(commands: Commands) -> None:
    """Declare ``verify``."""
    words = "compare with known answers; --out writes the verification book"
    extent = _declare(
        commands, "verify", words, "verification.GROUPS", _verify
    ).add_mutually_exclusive_group()
    extent.add_argument(
        "--quick", action="store_true", help="compute only the first row of each case"
    )
    extent.add_argument("--heavy", action="store_true", help="also compute rows that take minutes")


def _verify(options: argparse.Namespace) -> int:
    """Run the command; the exit code is 1 if a check fails."""
    from tactgen.validation.evidence.verification import GROUPS, verify

    extent: Extent = "heavy" if options.heavy else "quick" if options.quick else "light"

    def book(rows: list[Verified], out: Path, announce: Callable[[str], None]) -> list[Path]:
        from tactgen.validation.book.book import write_book

        return [write_book(rows, out, announce)]

    rows = _run(
        options, GROUPS, lambda names, announce: verify(names, extent=extent, announce=announce),
        book, _print_checks, lambda rows: {"rows": [row.plain() for row in rows]},
    )  # fmt: skip
    return int(any(row.verdict == "fail" for row in rows))


def _print_checks(rows: list[Verified]) -> None:
    from tactgen.geometry.formats import engineering, percent
    from tactgen.validation.evidence.verification import VERDICTS

    print(f"{'id':9} {'verdict':10} {'computed':>14} {'deviation':>12}  requirement")
    for row in rows:
        check, found = row.check, row.outcome
        measured = "-" if found is None else engineering(found.measured, check.unit)
        deviation = "-" if found is None else percent(found.deviation)
        print(f"{check.id:9} {row.verdict:10} {measured:>14} {deviation:>12}  {check.requirement}")
        if row.bar is not None and row.verdict == "explained" and not check.band:
            covers = "covers" if row.covered_by else "does not cover"
            bar = engineering(row.bar.error, check.unit)
            print(f"{'':20} its bar of ± {bar} {covers} the reference")
        for words in (found.explanation, found.beside) if found else ():
            if words:
                print(f"{'':20} {words}")
    verdicts = [row.verdict for row in rows]
    print(", ".join(f"{verdicts.count(v)} {v}" for v in VERDICTS))


# ---- coverage and stress, which draw at random ----


def add_coverage(commands: Commands) -> None:
    """Declare ``coverage``."""
    words = "check numerical errors on random devices"
    parser = _declare(commands, "coverage", words, "coverage.PARTS", partial(_judge, "coverage"))
    parser.add_argument("--devices", metavar="N", help="number of devices for each part")
    _add_seed(parser, "devices")


def add_stress(commands: Commands) -> None:
    """Declare ``stress``."""
    words = "run all models to their extremes, and commands under faults"
    parser = _declare(commands, "stress", words, "stress.PARTS", partial(_judge, "stress"))
    parser.add_argument("--quick", action="store_true", help="compute on a coarser grid")
    _add_seed(parser, "scenes")


def _add_seed(parser: argparse.ArgumentParser, same: str) -> None:
    parser.add_argument("--seed", metavar="N", help=f"seed of an earlier run, for the same {same}")


def _judge(command: str, options: argparse.Namespace) -> int:
    """Run the command; the exit code is 1 if a row fails, not if its bars are wide."""
    from tactgen.validation.evidence.judgement import loaded, run_parts, table, write

    seed, devices = secrets.randbelow(MOST_SEED + 1), None
    if options.seed is not None:
        seed = whole_number(options.seed, "--seed", 0, MOST_SEED, "1")
    if getattr(options, "devices", None) is not None:
        devices = whole_number(options.devices, "--devices", 1, _MOST, "20")
    quick = getattr(options, "quick", False)

    def work(names: Sequence[str], announce: Callable[[str], None]) -> list[Any]:
        say(f"note: seed {seed}; a run that was stopped goes on with --seed {seed}")
        return run_parts(command, names, seed, announce, devices=devices, quick=quick)

    def files(parts: list[Any], out: Path, _: Callable[[str], None]) -> list[Path]:
        written = write(command, parts, out)
        if command == "stress" and any(part.name == "tmm" for part in parts):
            from tactgen.validation.evidence.error_maps import write_maps

            written += write_maps(out, quick=quick)
        return written

    def record(parts: list[Any]) -> dict[str, Any]:
        return {
            "seed": seed, "rows": {part.name: part.rows for part in parts},
            "answers": {part.name: part.answers for part in parts},
        }  # fmt: skip

    rule = loaded(f"{command}.RULE")
    parts = _run(
        options, loaded(f"{command}.PARTS"), work, files,
        lambda parts: print(table(parts, rule)), record,
    )  # fmt: skip
    return int(not all(part.holds for part in parts))


def add_calibrate(commands: Commands) -> None:
    """Declare ``calibrate``."""
    words = "fit the modelling errors of the quick models anew, on random devices"
    parser = _declare(commands, "calibrate", words, "calibration.PARTS", _calibrate)
    parser.add_argument(
        "--install", action="store_true", help="use the new fits in this installation from now on"
    )


def _calibrate(options: argparse.Namespace) -> int:
    """Run the command."""
    from tactgen.validation.evidence.calibration import PARTS, install, run, table, write

    found = _run(
        options, PARTS, run, lambda parts, out, _: write(parts, out),
        lambda parts: print(table(parts)), dict,
    )  # fmt: skip
    if options.install:
        name_files(install(found))
    return 0


# ---- bench ----


def add_bench(commands: Commands) -> None:
    """Declare ``bench``."""
    words = "measure run time and memory against error on one core"
    parser = _declare(commands, "bench", words, "bench.PARTS", _bench)
    parser.add_argument("--quick", action="store_true", help="compute fewer points")


def _bench(options: argparse.Namespace) -> int:
    """Run the command; a slow machine is no error, so the exit code is 0."""
    from tactgen.validation.evidence.bench import PARTS, print_bench, run_parts, write_bench

    def work(names: Sequence[str], announce: Callable[[str], None]) -> list[Any]:
        return run_parts(names, options.quick, announce)

    def record(parts: list[Any]) -> dict[str, Any]:
        return {"parts": parts, "met": {p.part: [t.met for t in p.targets] for p in parts}}

    _run(options, PARTS, work, lambda parts, out, _: write_bench(parts, out), print_bench, record)
    return 0
