"""``tactgen bench``: run time against error."""

from __future__ import annotations

import argparse
from collections.abc import Collection

from tactgen.validation.command_line.commands.common import Commands
from tactgen.validation.command_line.commands.evidence.part_runs import (
    add_part_command,
    run_and_show,
)


def add(commands: Commands) -> None:
    """Declare the command."""
    words = "measure speed, memory and accuracy on one core"
    add_part_command(commands, "bench", words, "fewer points", _known, run)


def _known() -> Collection[str]:
    from tactgen.validation.evidence.bench import PARTS

    return PARTS


def run(options: argparse.Namespace) -> int:
    """Run the command; a slow machine is no error, so the exit code is 0."""
    from tactgen.validation.evidence.bench import PARTS, print_bench, run_parts, write_bench

    run_and_show(
        options, PARTS, run_parts, print_bench, write_bench,
        lambda parts: {"met": {p.part: [target.met for target in p.targets] for p in parts}},
    )  # fmt: skip
    return 0
