"""Runs in parts, with a table and files, as of ``tactgen bench`` and ``stress``."""

from __future__ import annotations

import argparse
import secrets
from collections.abc import Callable, Collection, Sequence
from pathlib import Path
from typing import Any, TypeVar

from tactgen.validation.command_line.commands.common import Commands
from tactgen.validation.command_line.streams import name_files, print_json, say
from tactgen.validation.command_line.study_options import MOST_SEED, whole_number

Part = TypeVar("Part")

#: Runs the parts of these names.
Runner = Callable[[Sequence[str], bool, Callable[[str], None]], list[Part]]


def add_part_command(
    commands: Commands,
    name: str,
    words: str,
    quick: str,
    known: Callable[[], Collection[str]],
    run: Callable[[argparse.Namespace], int],
) -> Any:
    """Parser of a command that runs parts.

    `words` and `quick` are its help, with what is known.
    """
    parser = commands.add_parser(name, help=words)
    parser.listing = lambda: (f"{words.capitalize()}.", f"parts: {', '.join(known())}")
    only = "one of the parts below; may be repeated, all by default"
    parser.add_argument("--only", action="append", metavar="PART", help=only)
    parser.add_argument("--quick", action="store_true", help=quick)
    parser.add_argument("--out", metavar="DIR", help="also write tables (CSV) and plots (SVG)")
    parser.add_argument("--json", action="store_true", help="machine-readable result on stdout")
    parser.set_defaults(run=run)
    return parser


def run_and_show(
    options: argparse.Namespace,
    known: Collection[str],
    run_parts: Runner[Part],
    show: Callable[[list[Part]], None],
    write: Callable[[list[Part], Path], Sequence[Path]],
    verdicts: Callable[[list[Part]], dict[str, Any]],
) -> list[Part]:
    """Run the chosen parts, write files, print tables or JSON, name the files; return the parts.

    Files come first: nobody may be there to read what is printed.
    """
    from tactgen.geometry.files import writable_folder
    from tactgen.validation.command_line.streams import announcer
    from tactgen.validation.scene.files import choices

    names = choices(",".join(options.only or known), tuple(known), "part", "--only")
    out = writable_folder(Path(options.out)) if options.out is not None else None
    with announcer() as announce:
        parts = run_parts(names, options.quick, announce)
    files = write(parts, out) if out is not None else ()
    if options.json:
        print_json({"parts": parts, **verdicts(parts)})
    else:
        show(parts)
    name_files(files)
    return parts


def seed_option(parser: argparse.ArgumentParser, same: str) -> None:
    """Declare the option; `same` says what it draws again."""
    parser.add_argument("--seed", metavar="N", help=f"of an earlier run, to draw the same {same}")


def seed_of(options: argparse.Namespace) -> int:
    """Seed of a run.

    Raises InputError if what is given is no seed.
    """
    if options.seed is None:
        return secrets.randbelow(MOST_SEED + 1)
    return whole_number(options.seed, "--seed", 0, MOST_SEED, "1")


def say_seed(seed: int) -> None:
    """Say how a run is gone on with."""
    say(f"note: seed {seed}; a run that was stopped goes on with --seed {seed}")
