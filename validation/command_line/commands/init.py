"""``tactgen init``: write a commented scene file to start from."""

from __future__ import annotations

import argparse
from pathlib import Path

from tactgen.validation.command_line.commands.common import Commands


def add(commands: Commands) -> None:
    """Declare the command."""
    parser = commands.add_parser("init", help="write a commented scene file to start from")
    parser.add_argument("file", metavar="FILE.toml")
    parser.set_defaults(run=run)


def run(options: argparse.Namespace) -> int:
    """Run the command and return its exit code."""
    from tactgen.validation.scene.parameter_list import write_template

    print(write_template(Path(options.file)))
    return 0
