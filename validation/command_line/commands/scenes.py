"""``tactgen scenes``: list the built-in scenes."""

from __future__ import annotations

import argparse

from tactgen.validation.command_line.commands.common import Commands


def add(commands: Commands) -> None:
    """Declare the command."""
    parser = commands.add_parser("scenes", help="list the built-in scenes")
    parser.set_defaults(run=run)


def run(_: argparse.Namespace) -> int:
    """Run the command and return its exit code."""
    from tactgen.validation.scene.files import built_in_scenes

    for name, description in built_in_scenes().items():
        print(f"{name:12} {description}")
    return 0
