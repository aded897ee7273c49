"""``tactgen stress``: how far the numerics hold, far beyond any use."""

from __future__ import annotations

import argparse
import json
import sys
from pathlib import Path

from validation.commands.common import Commands

_PARTS = "tmm or magnetics; may be repeated, both by default"


def add(commands: Commands) -> None:
    """Declare the command."""
    parser = commands.add_parser("stress", help="errors against exact answers, far beyond any use")
    parser.add_argument("--only", action="append", metavar="PART", help=_PARTS)
    parser.add_argument("--quick", action="store_true", help="a coarser grid")
    parser.add_argument("--out", metavar="DIR", help="also write tables (CSV) and plots (SVG)")
    parser.add_argument("--json", action="store_true", help="machine-readable result on stdout")
    parser.set_defaults(run=run)


def run(options: argparse.Namespace) -> int:
    """Run the command; the exit code is 1 if a family fails."""
    from validation.files import writable_folder
    from validation.progress import announcer
    from validation.stress import PARTS, run_parts
    from validation.stress.output import print_stress, write_stress
    from validation.wording import choices

    known = tuple(PARTS)
    names = choices(",".join(options.only or known), known, "part", "--only")
    out = writable_folder(Path(options.out)) if options.out is not None else None
    with announcer() as announce:
        parts = run_parts(names, options.quick, announce)
    if options.json:
        from validation.plain_values import plain

        verdicts = {part.part: [row.verdict for row in part.rows] for part in parts}
        json.dump({"parts": plain(parts), "verdicts": verdicts}, sys.stdout)
        print()
    else:
        print_stress(parts)
    if out is not None:
        for path in write_stress(parts, out):
            print(path, file=sys.stderr if options.json else sys.stdout)
    return int(any(row.verdict == "fails" for part in parts for row in part.rows))
