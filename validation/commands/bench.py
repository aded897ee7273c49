"""``tactgen bench``: what the models cost, and what accuracy comes with it."""

from __future__ import annotations

import argparse
import json
import sys
from pathlib import Path

from validation.commands.common import Commands

_PARTS = "tmm, magnetics, piezo or solver; may be repeated, all by default"


def add(commands: Commands) -> None:
    """Declare the command."""
    parser = commands.add_parser("bench", help="measure speed, memory and accuracy on one core")
    parser.add_argument("--only", action="append", metavar="PART", help=_PARTS)
    parser.add_argument("--quick", action="store_true", help="fewer points")
    parser.add_argument("--out", metavar="DIR", help="also write a table (CSV) and plots (SVG)")
    parser.add_argument("--json", action="store_true", help="machine-readable result on stdout")
    parser.set_defaults(run=run)


def run(options: argparse.Namespace) -> int:
    """Run the command; a slow machine is no error, so the exit code is 0."""
    from validation.bench import PARTS, run_parts
    from validation.bench.output import print_bench, write_bench
    from validation.files import writable_folder
    from validation.progress import announcer
    from validation.wording import choices

    known = tuple(PARTS)
    names = choices(",".join(options.only or known), known, "part", "--only")
    out = writable_folder(Path(options.out)) if options.out is not None else None
    with announcer() as announce:
        parts = run_parts(names, options.quick, announce)
    if options.json:
        from validation.plain_values import plain

        met = {part.part: [target.met for target in part.targets] for part in parts}
        json.dump({"parts": plain(parts), "met": met}, sys.stdout)
        print()
    else:
        print_bench(parts)
    if out is not None:
        for path in write_bench(parts, out):
            print(path, file=sys.stderr if options.json else sys.stdout)
    return 0
