"""Options that commands share: scene, what is asked, the axes of a study, seeds and parts."""

from __future__ import annotations

import argparse
import math
import secrets
from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

from tactgen.geometry.errors import InputError
from tactgen.geometry.units import quoted
from tactgen.validation.command_line.streams import name_files, print_json, say

if TYPE_CHECKING:
    from tactgen.geometry.units import Unit
    from tactgen.validation.models.comparison import Choice
    from tactgen.validation.scene.scene import Scene
    from tactgen.validation.studies.whatif.statement import Statement

#: Most samples that can be drawn.
_MOST_SAMPLES = 1_000_000
#: Largest seed that is drawn or taken.
MOST_SEED = 999_999_999

#: How axes are written.
AXES = """\
axes:
  KEY=START:STOP:N[:log]     N values from START to STOP, each with its unit
  KEY=a,b,c                  these values (of a profile parted by semicolons)
with --sample N also:
  KEY=START:STOP[:log]       drawn from the range
  KEY                        drawn from the tolerance that the scene states, or else assumes;
                             without --vary, of all the keys of which the scene states one
  KEY=normal(MEAN,DEVIATION) and uniform(LOW,HIGH), lognormal(MEDIAN,SHARE), loguniform(LOW,HIGH);
                             a deviation may be a share of the mean, such as 5%
"""


def axis_options(parser: argparse.ArgumentParser) -> None:
    """Add the axes, and how they are combined or drawn."""
    parser.add_argument(
        "--vary", action="append", default=[], metavar="KEY[=VALUES]", help="an axis, see below"
    )
    parser.add_argument(
        "--zip", action="store_true", help="take the axes' values hand in hand, not in combination"
    )
    parser.add_argument("--sample", metavar="N", help="draw N samples of ranges and distributions")
    parser.add_argument("--seed", metavar="S", help="of the samples (default 1)")


def stated(options: argparse.Namespace, before: Statement | None = None) -> Statement:
    """Return what the options ask; where they are silent, what a study asked before."""
    from tactgen.validation.scene.scene import scene_values
    from tactgen.validation.studies.whatif.request import (
        asks_accuracy,
        chosen,
        names_models,
        with_tolerances,
    )
    from tactgen.validation.studies.whatif.statement import Statement

    overrides = list(options.overrides)
    if options.frequency is not None:
        overrides.append(f"frequency={options.frequency}")
    if before is not None and options.scene is None and not overrides:
        values, base = before.values, before
    else:
        values, _ = scene_values(options.scene or "paper", overrides)
        base = before or Statement("", {}, (), (), ())
    # a scene that asks for all has chosen none: the headline ones, which cost a study the least
    named = {key: of for key, of in values.items() if key != "quantities" or "all" not in of}
    models, quantities = chosen(named, options.model, options.quantity, base)
    if before is not None and not before.by_accuracy:
        # a study that is gone on with grows: what it holds stays beside what is new
        models = tuple(dict.fromkeys((*before.models, *models)))
        quantities = tuple(dict.fromkeys((*before.quantities, *quantities)))
    samples = (
        whole_number(options.sample, "--sample", 1, _MOST_SAMPLES, "16")
        if options.sample is not None
        else base.samples
    )
    vary, drawn = with_tolerances(values, tuple(options.vary) or base.vary, sampled=samples > 0)
    for line in drawn:
        say(f"note: {line}")
    found = replace(
        base, scene=str(values["name"]), values=values, models=models, quantities=quantities,
        vary=vary, zipped=options.zip or base.zipped, samples=samples,
        seed=(
            whole_number(options.seed, "--seed", 0, MOST_SEED, "1")
            if options.seed is not None else base.seed
        ),
    )  # fmt: skip
    check_seed(options.seed, samples)
    free = not names_models(values, options.model, base)
    return replace(found, by_accuracy=free and asks_accuracy(found))


def check_seed(seed: str | None, samples: int) -> None:
    """Refuse a seed of samples that are not drawn."""
    if seed is not None and not samples:
        raise InputError(
            f"--seed {quoted(seed)} is of samples, and none are drawn; add --sample 16, or leave "
            "it out"
        )


def whole_number(text: str, option: str, least: int, most: int, example: str) -> int:
    """Return the whole number that an option gives; InputError if it is none in the range."""
    number = int(text) if text.strip().isdecimal() and len(text) < 12 else least - 1
    if not least <= number <= most:
        raise InputError(
            f"{option} {quoted(text)} is not a whole number from {least} to {most}; write for "
            f"example {option} {example}"
        )
    return number


def under_accuracy(statement: Statement) -> tuple[Statement, Choice | None]:
    """Return the statement with the models that its accuracy chooses, if no model is named."""
    if not statement.by_accuracy:
        return statement, None
    from tactgen.validation.command_line.progress import announcer
    from tactgen.validation.studies.whatif.request import under_contract

    with announcer() as announce:
        statement, choice = under_contract(statement, announce)
    for sentence in choice.sentences:
        say(sentence)
    return statement, choice


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


def low_high(text: str, option: str, example: str) -> tuple[str, str]:
    """Return the two ends of ``LOW:HIGH``."""
    low, colon, high = (part.strip() for part in text.partition(":"))
    if not (low and colon and high) or ":" in high:
        raise InputError(f'{option} "{text}" is not LOW:HIGH; write for example {option} {example}')
    return low, high


def values_of(
    text: str, option: str, unit: Unit, example: str, most: int, *, zero: bool = False
) -> list[float]:
    """Return the magnitudes (SI) of ``LIST`` or ``START:STOP:N[:log]``.

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


def under_contract(
    scene: Scene, origins: Mapping[str, str], announce: Callable[[str], None]
) -> tuple[Scene, Choice | None]:
    """Return the scene with the models that the accuracy asks for, and why.

    Unchanged, and None, where models are named or no accuracy is.

    Raises
    ------
    InputError
        If no model is known to meet the accuracy.
    """
    if "accuracy" not in origins or "models" in origins:
        return scene, None
    from tactgen.validation.models.comparison import choose

    choice = choose(scene, scene.quantities, announce)
    return scene.model_copy(update={"models": choice.models}), choice


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


Part = TypeVar("Part")

#: Runs the parts of these names.
Runner = Callable[[Sequence[str], bool, Callable[[str], None]], list[Part]]


def add_part_command(
    commands: Commands,
    name: str,
    words: str,
    quick: str,
    known: Callable[[], Collection[str]],
    run: Callable[[argparse.Namespace], int],
) -> Any:
    """Return the parser of a command that runs parts.

    `words` and `quick` are its help, with what is known.
    """
    parser = commands.add_parser(name, help=words)
    parser.listing = lambda: (f"{words.capitalize()}.", f"parts: {', '.join(known())}")
    only = "one of the parts below; may be repeated, all by default"
    parser.add_argument("--only", action="append", metavar="PART", help=only)
    parser.add_argument("--quick", action="store_true", help=quick)
    parser.add_argument("--out", metavar="DIR", help="also write tables (CSV) and plots (SVG)")
    parser.add_argument("--json", action="store_true", help="machine-readable result on stdout")
    parser.set_defaults(run=run)
    return parser


def run_and_show(
    options: argparse.Namespace,
    known: Collection[str],
    run_parts: Runner[Part],
    show: Callable[[list[Part]], None],
    write: Callable[[list[Part], Path], Sequence[Path]],
    verdicts: Callable[[list[Part]], dict[str, Any]],
) -> list[Part]:
    """Run the chosen parts, write files, print tables or JSON, name the files; return the parts.

    Files come first: nobody may be there to read what is printed.
    """
    from tactgen.geometry.files import writable_folder
    from tactgen.validation.command_line.progress import announcer
    from tactgen.validation.scene.files import choices

    names = choices(",".join(options.only or known), tuple(known), "part", "--only")
    out = writable_folder(Path(options.out)) if options.out is not None else None
    with announcer() as announce:
        parts = run_parts(names, options.quick, announce)
    files = write(parts, out) if out is not None else ()
    if options.json:
        print_json({"parts": parts, **verdicts(parts)})
    else:
        show(parts)
    name_files(files)
    return parts
