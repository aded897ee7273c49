"""What the commands share: the scene's options, and warnings on stderr."""

from __future__ import annotations

import argparse
from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING, Any

from tactgen.validation.command_line.streams import say

if TYPE_CHECKING:
    from tactgen.validation.scene.scene import Scene

#: What argparse hands out for adding commands (its type is private).
Commands = Any


#: The scene where none is named.
PAPER = "paper"


def scene_options(parser: argparse.ArgumentParser, default: str | None = PAPER) -> None:
    """Add the scene and its overrides."""
    parser.add_argument(
        "scene", nargs="?", default=default,
        help=f"file or built-in name (default {default or PAPER})",
    )  # fmt: skip
    parser.add_argument(
        "--set",
        action="append",
        default=[],
        metavar="KEY=VALUE",
        dest="overrides",
        help="change a scene key, for example bimorph.length=25mm",
    )


def asking_options(parser: argparse.ArgumentParser) -> None:
    """Add the models, quantities and frequencies asked for."""
    parser.add_argument(
        "--model", action="append", metavar="NAME", help="one of the models, or all"
    )
    parser.add_argument(
        "--quantity", action="append", metavar="NAME", help="one of the quantities; may be repeated"
    )
    parser.add_argument(
        "--frequency", metavar="LIST|START:STOP:N[:log]", help="in Hz, for example 10:2000:200"
    )


def asked_overrides(options: argparse.Namespace) -> list[str]:
    """Return the overrides that --frequency, --model and --quantity stand for."""
    return [
        *overrides_of("frequency", "frequency", options.frequency, "10:2000:200"),
        *overrides_of("model", "models", options.model, "tmm"),
        *overrides_of("quantity", "quantities", options.quantity, "all"),
    ]


def overrides_of(option: str, key: str, given: str | list[str] | None, example: str) -> list[str]:
    """Return the override that ``--option`` stands for, none if it was not given.

    Raises
    ------
    InputError
        If it was given without a value.
    """
    from tactgen.geometry.errors import InputError

    if given is None:
        return []
    text = given if isinstance(given, str) else ",".join(given)
    if not text.strip():
        raise InputError(f"--{option} is empty; write for example --{option} {example}")
    return [f"{key}={text}"]


def lateral_scene(
    name: str, overrides: Sequence[str], command: str
) -> tuple[Scene, dict[str, str]]:
    """Load the scene of a command that is about the lateral actuator, and where values come from.

    Raises
    ------
    InputError
        As :func:`validation.scene.scene.load_scene`; or if no model of the lateral actuator is
        asked for.
    """
    from tactgen.geometry.errors import InputError
    from tactgen.validation.catalogue.models import models_of
    from tactgen.validation.scene.scene import load_scene

    scene, origins = load_scene(name, list(overrides))
    if not set(scene.models) & set(models_of("bimorph")):
        raise InputError(
            f"models = {', '.join(scene.models)} in scene {scene.name} are all of the normal "
            f"actuator, and {command} is about the lateral one; take the scene paper or --set "
            "models=tmm"
        )
    return scene, origins


def warn(warnings: Iterable[str]) -> None:
    """Print warnings to stderr."""
    for warning in warnings:
        say(f"warning: {warning}")
