"""``tactgen coverage``: whether the error bars hold on random devices."""

from __future__ import annotations

import argparse
import secrets
from pathlib import Path

from tactgen.validation.command_line.commands.common import Commands
from tactgen.validation.command_line.json_output import print_json

#: Largest seed and number of devices that are taken, so that a seed that is drawn can be given.
_MOST = 999_999_999


def add(commands: Commands) -> None:
    """Declare the command."""
    from tactgen.validation.checks.coverage import PARTS

    words = "do the error bars hold on random devices?"
    parser = commands.add_parser("coverage", help=words)
    parser.listing = lambda: (f"{words.capitalize()}", f"parts: {', '.join(PARTS)}")
    only = "one of the parts below; may be repeated, all by default"
    parser.add_argument("--only", action="append", metavar="PART", help=only)
    parser.add_argument("--devices", metavar="N", help="devices for each part; by default its own")
    parser.add_argument("--seed", metavar="N", help="of an earlier run, to draw the same devices")
    parser.add_argument("--out", type=Path, metavar="DIR", help="write CSVs and calibration curves")
    parser.add_argument("--json", action="store_true", help="machine-readable result on stdout")
    parser.set_defaults(run=run)


def run(options: argparse.Namespace) -> int:
    """Run the command; the exit code is 1 if a part's bars are too narrow, not if they are wide."""
    from tactgen.geometry.files import writable_folder
    from tactgen.validation.checks.coverage import PARTS
    from tactgen.validation.checks.coverage.output import table, write
    from tactgen.validation.checks.coverage.run import run_parts
    from tactgen.validation.command_line.progress import announcer
    from tactgen.validation.command_line.streams import name_files, say
    from tactgen.validation.scene.wording import choices

    names = choices(",".join(options.only or PARTS), tuple(PARTS), "part", "--only")
    devices = None if options.devices is None else _whole("--devices", options.devices, 1)
    seed = secrets.randbelow(_MOST + 1)
    if options.seed is not None:
        seed = _whole("--seed", options.seed, 0)
    if options.out is not None:
        writable_folder(options.out)
    say(f"note: seed {seed}; a run that was stopped goes on with --seed {seed}")
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


def _whole(name: str, text: str, least: int) -> int:
    from tactgen.geometry.errors import InputError

    if not text.isascii() or not text.isdigit() or len(text) > 9 or int(text) < least:
        raise InputError(f"{name} must be a whole number from {least} to {_MOST}, not {text!r}")
    return int(text)
