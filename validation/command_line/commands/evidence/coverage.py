"""``tactgen coverage``: whether the error bars hold on random devices."""

from __future__ import annotations

import argparse
from pathlib import Path

from tactgen.validation.command_line.commands.common import Commands
from tactgen.validation.command_line.commands.evidence.part_runs import (
    say_seed,
    seed_of,
    seed_option,
)
from tactgen.validation.command_line.streams import print_json
from tactgen.validation.command_line.study_options import whole_number

#: Most devices for each part.
_MOST = 999_999_999


def add(commands: Commands) -> None:
    """Declare the command."""
    from tactgen.validation.evidence.coverage import PARTS

    words = "do the error bars hold on random devices?"
    parser = commands.add_parser("coverage", help=words)
    parser.listing = lambda: (f"{words.capitalize()}", f"parts: {', '.join(PARTS)}")
    only = "one of the parts below; may be repeated, all by default"
    parser.add_argument("--only", action="append", metavar="PART", help=only)
    parser.add_argument("--devices", metavar="N", help="devices for each part; by default its own")
    seed_option(parser, "devices")
    parser.add_argument("--out", type=Path, metavar="DIR", help="write CSVs and calibration curves")
    parser.add_argument("--json", action="store_true", help="machine-readable result on stdout")
    parser.set_defaults(run=run)


def run(options: argparse.Namespace) -> int:
    """Run the command; the exit code is 1 if a part's bars are too narrow, not if they are wide."""
    from tactgen.geometry.files import writable_folder
    from tactgen.validation.command_line.streams import announcer, name_files
    from tactgen.validation.evidence.coverage import PARTS, run_parts, table, write
    from tactgen.validation.scene.files import choices

    names = choices(",".join(options.only or PARTS), tuple(PARTS), "part", "--only")
    devices = None
    if options.devices is not None:
        devices = whole_number(options.devices, "--devices", 1, _MOST, "20")
    seed = seed_of(options)
    if options.out is not None:
        writable_folder(options.out)
    say_seed(seed)
    with announcer() as announce:
        parts = run_parts(names, devices, seed, announce)
    # files come first: nobody may be there to read what is printed
    files = write(parts, options.out) if options.out is not None else ()
    if options.json:
        rows = {part.name: part.rows for part in parts}
        print_json({"seed": seed, "rows": rows, "answers": parts})
    else:
        print(table(parts))
    name_files(files)
    return int(not all(part.holds for part in parts))
