"""Options and warnings shared by all commands."""

from __future__ import annotations

import argparse
import math
from collections.abc import Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

from tactgen.geometry.errors import InputError
from tactgen.validation.command_line.streams import announcer, say

if TYPE_CHECKING:
    from tactgen.geometry.units import Unit
    from tactgen.validation.engine.comparison import Choice
    from tactgen.validation.scene.scene import Scene

#: What argparse hands out for adding commands (its type is private).
Commands = Any


#: The scene where none is named.
PAPER = "paper"


def scene_options(parser: argparse.ArgumentParser, default: str | None = PAPER) -> None:
    """Add the scene and its overrides."""
    parser.add_argument(
        "scene", nargs="?", default=default,
        help=f"scene file or built-in scene (default {default or PAPER})",
    )  # fmt: skip
    parser.add_argument(
        "--set",
        action="append",
        default=[],
        metavar="KEY=VALUE",
        dest="overrides",
        help="set a scene key, for example bimorph.length=25mm",
    )


def asking_options(parser: argparse.ArgumentParser) -> None:
    """Add the models, quantities and frequencies asked for."""
    parser.add_argument(
        "--model", action="append", metavar="NAME", help="model, or all; may be repeated"
    )
    parser.add_argument(
        "--quantity", action="append", metavar="NAME", help="quantity, or all; may be repeated"
    )
    parser.add_argument(
        "--frequency",
        metavar="LIST|START:STOP:N[:log]",
        help="frequencies in Hz, for example 10:2000:200",
    )


def asked_overrides(options: argparse.Namespace) -> list[str]:
    """Overrides that --frequency, --model and --quantity stand for."""
    return [
        *overrides_of("frequency", "frequency", options.frequency, "10:2000:200"),
        *overrides_of("model", "models", options.model, "tmm"),
        *overrides_of("quantity", "quantities", options.quantity, "all"),
    ]


def overrides_of(option: str, key: str, given: str | list[str] | None, example: str) -> list[str]:
    """Override that ``--option`` stands for, none if it was not given.

    Raises InputError if it was given without a value.
    """
    if given is None:
        return []
    text = given if isinstance(given, str) else ",".join(given)
    if not text.strip():
        raise InputError(f"--{option} is empty; write for example --{option} {example}")
    return [f"{key}={text}"]


def settle(scene: Scene) -> None:
    """Solve the field that where the rod rests follows from, if the scene asks for one."""
    if scene.awaits_map:
        from tactgen.validation.models.classes import map_of

        map_of(scene)


def lateral_scene(
    name: str, overrides: Sequence[str], command: str
) -> tuple[Scene, dict[str, str]]:
    """Load the scene of a command that is about the lateral actuator, and where values come from.

    Raises InputError as :func:`validation.scene.load.load_scene`; or if no model of the lateral
    actuator is asked for.
    """
    from tactgen.validation.catalogue.models import models_of
    from tactgen.validation.scene.load import load_scene

    scene, origins = load_scene(name, list(overrides))
    if not set(scene.models) & set(models_of("bimorph")):
        raise InputError(
            f"models = {', '.join(scene.models)} in scene {scene.name} are all of the normal "
            f"actuator, and {command} is about the lateral one; take the scene paper or --set "
            "models=tmm"
        )
    voltage_driven(scene, command)
    settle(scene)
    return scene, origins


def voltage_driven(scene: Scene, command: str) -> None:
    """Refuse a scene whose excitation a command does not know.

    Raises InputError if anything but a voltage at the electrodes drives the scene.
    """
    from tactgen.validation.scene.conditions import beyond_voltage

    if beyond := beyond_voltage(scene):
        raise InputError(
            f"{beyond} is not known to {command}, which drives the electrodes by drive.voltage "
            "alone; leave it out, or use solve, whatif, compare or sensitivity"
        )


def warn(warnings: Iterable[str]) -> None:
    """Print warnings to stderr."""
    for warning in warnings:
        say(f"warning: {warning}")


def check_svg(plot: str | None, example: str) -> None:
    """Refuse a plot that is no SVG file."""
    if plot and not plot.endswith(".svg"):
        raise InputError(f'--plot "{plot}" is not an SVG file; write for example --plot {example}')


def low_high(text: str, option: str, example: str) -> tuple[str, str]:
    """Two ends of ``LOW:HIGH``."""
    low, colon, high = (part.strip() for part in text.partition(":"))
    if not (low and colon and high) or ":" in high:
        raise InputError(f'{option} "{text}" is not LOW:HIGH; write for example {option} {example}')
    return low, high


def values_of(
    text: str, option: str, unit: Unit, example: str, most: int, *, zero: bool = False
) -> list[float]:
    """Magnitudes (SI) of ``LIST`` or ``START:STOP:N[:log]``.

    Bare numbers are SI; with `zero` only 0 may be bare, and is a value.
    """
    import numpy as np

    def one(part: str) -> float:
        try:
            value = unit.parse(part, bare=not zero or part == "0")
        except ValueError:
            value = math.nan
        low, high = unit.limits or (0.0, math.inf)
        if not (low <= value <= high or (zero and 0.0 <= value <= high)):
            kind = "of 0 or more with its unit" if zero else "above 0"
            raise InputError(
                f'{option} "{text}" has "{part}", which is no {unit.kind} {kind}; write for '
                f"example {option} {example}"
            )
        return value

    parts = [part.strip() for part in text.split(":")]
    if len(parts) == 1:
        return [one(part.strip()) for part in text.split(",")]
    count, spacing = parts[2] if len(parts) > 2 else "", parts[3] if len(parts) > 3 else "lin"
    whole = count.isascii() and count.isdigit() and 2 <= int(count) <= most
    if not whole or spacing not in ("lin", "log") or len(parts) > 4:
        raise InputError(
            f'{option} "{text}" is not START:STOP:N or START:STOP:N:log with N from 2 to {most}; '
            f"write for example {option} {example}"
        )
    spaced = np.geomspace if spacing == "log" else np.linspace
    values: list[float] = spaced(one(parts[0]), one(parts[1]), int(count)).tolist()
    return values


def under_contract(scene: Scene, origins: Mapping[str, str]) -> tuple[Scene, Choice | None]:
    """Scene with the models that the accuracy asks for, and why.

    Unchanged, and None, where models are named or no accuracy is.

    Raises InputError if no model is known to meet the accuracy.
    """
    if "accuracy" not in origins or "models" in origins:
        return scene, None
    from tactgen.validation.engine.comparison import choose

    with announcer() as announce:
        choice = choose((scene,), scene.quantities, announce)
    return scene.model_copy(update={"models": choice.models}), choice
