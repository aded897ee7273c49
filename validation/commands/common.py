"""What the commands share: the scene's options, and warnings on stderr."""

from __future__ import annotations

import argparse
import contextlib
import sys
from collections.abc import Iterable
from typing import Any

#: What argparse hands out for adding commands (its type is private).
Commands = Any


def scene_options(parser: argparse.ArgumentParser, default: str = "paper") -> None:
    """Add the scene and its overrides."""
    parser.add_argument(
        "scene", nargs="?", default=default, help=f"file or built-in name (default {default})"
    )
    parser.add_argument(
        "--set",
        action="append",
        default=[],
        metavar="KEY=VALUE",
        dest="overrides",
        help="change a scene key, for example bimorph.length=25mm",
    )


def say(text: str) -> None:
    """Print one line to stderr, if that can be written."""
    from validation.wording import one_line

    with contextlib.suppress(OSError):
        print(f"tactgen: {one_line(text)}", file=sys.stderr)


def warn(warnings: Iterable[str]) -> None:
    """Print warnings to stderr."""
    for warning in warnings:
        say(f"warning: {warning}")
