"""``tactgen compare``: two scenes or two studies side by side."""

from __future__ import annotations

import argparse
from pathlib import Path

from tactgen.validation.command_line.commands.common import Commands, asking_options, overrides_of
from tactgen.validation.command_line.streams import announcer, name_files, print_json


def add(commands: Commands) -> None:
    """Declare the command."""
    parser = commands.add_parser(
        "compare", help="compare two scenes or studies: inputs and all results"
    )
    parser.add_argument("first", metavar="A", help="scene file, built-in scene or study folder")
    parser.add_argument("second", metavar="B", help="second one of the same kind")
    parser.add_argument(
        "--set", action="append", default=[], metavar="KEY=VALUE", dest="overrides",
        help="set a scene key in both",
    )  # fmt: skip
    asking_options(parser)
    parser.add_argument("--out", metavar="DIR", help="also write compare.html with plots")
    parser.add_argument("--json", action="store_true", help="machine-readable result on stdout")
    parser.set_defaults(run=run)


def run(options: argparse.Namespace) -> int:
    """Run the command; a difference is no error, so the exit code is 0."""
    from tactgen.geometry.files import writable_folder
    from tactgen.validation.studies.whatif import compare

    out = writable_folder(Path(options.out)) if options.out is not None else None
    frequency = overrides_of("frequency", "frequency", options.frequency, "10:2000:200")
    overrides = [*options.overrides, *frequency]
    with announcer() as announce:
        sides = compare.read_sides(
            (options.first, options.second), overrides, options.model, options.quantity, announce
        )
        found = compare.Comparison(*sides)
        if out is not None:
            announce("drawing")
            page = compare.write_page(out, found)
    if options.json:
        print_json(compare.as_values(found))
    else:
        print("\n".join(compare.lines(found)))
    if out is not None:
        name_files([page])
    return 0
