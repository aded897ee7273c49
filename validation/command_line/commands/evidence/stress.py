"""``tactgen stress``: how far the numerics hold, far beyond any use."""

from __future__ import annotations

import argparse
from collections.abc import Callable, Collection, Sequence
from typing import TYPE_CHECKING, Any

from tactgen.validation.command_line.commands.common import Commands
from tactgen.validation.command_line.commands.evidence.part_runs import (
    add_part_command,
    run_and_show,
    say_seed,
    seed_of,
    seed_option,
)

if TYPE_CHECKING:
    from tactgen.validation.evidence.stress import Stress


def add(commands: Commands) -> None:
    """Declare the command."""
    words = "errors against exact answers, far beyond any use"
    parser = add_part_command(commands, "stress", words, "a coarser grid", _known, run)
    seed_option(parser, "scenes")


def _known() -> Collection[str]:
    from tactgen.validation.evidence.stress import PARTS

    return PARTS


def run(options: argparse.Namespace) -> int:
    """Run the command; the exit code is 1 if a family fails."""
    from tactgen.validation.evidence.stress import PARTS, print_stress, run_parts, write_stress

    seed = seed_of(options)

    def seeded(names: Sequence[str], quick: bool, announce: Callable[[str], None]) -> list[Stress]:
        say_seed(seed)
        return run_parts(names, quick, seed, announce)

    def verdicts(parts: list[Stress]) -> dict[str, Any]:
        found = {part.part: [row.verdict for row in part.rows] for part in parts}
        return {"seed": seed, "verdicts": found}

    parts = run_and_show(options, PARTS, seeded, print_stress, write_stress, verdicts)
    return int(any(row.verdict == "fails" for part in parts for row in part.rows))
