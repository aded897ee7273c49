"""``tactgen verify``: the suite's own checks against known answers, and the book of them."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

from tactgen.validation.command_line.commands.common import Commands
from tactgen.validation.command_line.streams import name_files, print_json

if TYPE_CHECKING:
    from tactgen.validation.evidence.verification import Extent, Verified


def add(commands: Commands) -> None:
    """Declare the command."""
    from tactgen.validation.evidence.verification import GROUPS

    parser = commands.add_parser("verify", help="the suite's own checks against known answers")
    only = f"{', '.join(GROUPS)}; may be repeated, all by default"
    parser.add_argument("--only", action="append", metavar="GROUP", help=only)
    extent = parser.add_mutually_exclusive_group()
    extent.add_argument("--quick", action="store_true", help="only the first row of each case")
    extent.add_argument("--heavy", action="store_true", help="also what takes minutes")
    parser.add_argument("--out", type=Path, metavar="DIR", help="write the verification book there")
    parser.add_argument("--json", action="store_true", help="machine-readable result on stdout")
    parser.set_defaults(run=run)


def run(options: argparse.Namespace) -> int:
    """Run the command; the exit code is 1 if a check fails."""
    from tactgen.geometry.files import writable_folder
    from tactgen.validation.command_line.streams import announcer
    from tactgen.validation.evidence.verification import GROUPS, verify
    from tactgen.validation.scene.files import choices

    groups = choices(",".join(options.only or GROUPS), tuple(GROUPS), "group", "--only")
    extent: Extent = "heavy" if options.heavy else "quick" if options.quick else "light"
    if options.out is not None:
        writable_folder(options.out)
    with announcer() as announce:
        found = verify(groups, extent=extent, announce=announce)
        if options.out is not None:
            from tactgen.validation.book.book import write_book

            name_files([write_book(found, options.out, announce)])
    if options.json:
        print_json({"rows": [row.plain() for row in found]})
    else:
        _print(found)
    return int(any(row.verdict == "fail" for row in found))


def _print(rows: list[Verified]) -> None:
    from tactgen.geometry.formats import engineering, percent
    from tactgen.validation.evidence.verification import VERDICTS

    print(f"{'id':9} {'verdict':10} {'measured':>14} {'deviation':>12}  requirement")
    for row in rows:
        check, found = row.check, row.outcome
        measured = "-" if found is None else engineering(found.measured, check.unit)
        deviation = "-" if found is None else percent(found.deviation)
        print(f"{check.id:9} {row.verdict:10} {measured:>14} {deviation:>12}  {check.requirement}")
        if row.verdict == "explained":
            print(f"{'':20} {check.explanation}")
    verdicts = [row.verdict for row in rows]
    print(", ".join(f"{verdicts.count(v)} {v}" for v in VERDICTS))
