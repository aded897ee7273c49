"""``--seed``: what ``tactgen coverage`` and ``tactgen stress`` draw, anew unless it is given."""

from __future__ import annotations

import argparse
import secrets

from tactgen.validation.command_line.streams import say
from tactgen.validation.command_line.study_options import MOST_SEED, whole_number


def seed_option(parser: argparse.ArgumentParser, same: str) -> None:
    """Declare the option; `same` says what it draws again."""
    parser.add_argument("--seed", metavar="N", help=f"of an earlier run, to draw the same {same}")


def seed_of(options: argparse.Namespace) -> int:
    """Return the seed of a run.

    Raises
    ------
    InputError
        If what is given is no seed.
    """
    if options.seed is None:
        return secrets.randbelow(MOST_SEED + 1)
    return whole_number(options.seed, "--seed", 0, MOST_SEED, "1")


def say_seed(seed: int) -> None:
    """Say how a run is gone on with."""
    say(f"note: seed {seed}; a run that was stopped goes on with --seed {seed}")
