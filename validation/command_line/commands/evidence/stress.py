"""``tactgen stress``: how far the numerics hold, far beyond any use."""

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
    words = "errors against exact answers, far beyond any use"
    add_part_command(commands, "stress", words, "a coarser grid", _known, run)


def _known() -> Collection[str]:
    from tactgen.validation.checks.stress import PARTS

    return PARTS


def run(options: argparse.Namespace) -> int:
    """Run the command; the exit code is 1 if a family fails."""
    from tactgen.validation.checks.stress import PARTS, run_parts
    from tactgen.validation.checks.stress.output import print_stress, write_stress

    parts = run_and_show(
        options, PARTS, run_parts, print_stress, write_stress,
        lambda parts: {"verdicts": {p.part: [row.verdict for row in p.rows] for p in parts}},
    )  # fmt: skip
    return int(any(row.verdict == "fails" for part in parts for row in part.rows))
