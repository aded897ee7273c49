"""The axes of a study as options, and the study that they state: of whatif and plan."""

from __future__ import annotations

import argparse
from dataclasses import replace
from typing import TYPE_CHECKING

from tactgen.geometry.errors import InputError
from tactgen.geometry.units import quoted
from tactgen.validation.command_line.streams import announcer, say

if TYPE_CHECKING:
    from tactgen.validation.engine.comparison import Choice
    from tactgen.validation.studies.whatif.definition import Statement

#: Most samples that can be drawn.
_MOST_SAMPLES = 1_000_000
#: Largest seed that is drawn or taken.
MOST_SEED = 999_999_999

#: How axes are written.
AXES = """\
axes:
  KEY=START:STOP:N[:log]     N values from START to STOP, each with its unit
  KEY=a,b,c                  these values (profiles are separated by semicolons)
with --sample N also:
  KEY=START:STOP[:log]       uniform in the range
  KEY                        uniform in the tolerance of the key; without --vary, all keys
                             that have a tolerance in the scene
  KEY=normal(MEAN,DEVIATION) and lognormal(MEDIAN,SHARE); the deviation can be a share of
                             the mean, for example 5%
"""


def axis_options(parser: argparse.ArgumentParser) -> None:
    """Add the axes, and how they are combined or drawn."""
    parser.add_argument(
        "--vary",
        action="append",
        default=[],
        metavar="KEY[=VALUES]",
        help="axis, see below; may be repeated",
    )
    parser.add_argument("--zip", action="store_true", help="combine the axes value by value")
    parser.add_argument("--sample", metavar="N", help="take N samples of ranges and distributions")
    parser.add_argument("--seed", metavar="S", help="seed of the samples (default 1)")


def stated(options: argparse.Namespace, before: Statement | None = None) -> Statement:
    """Study definition from the options, or else from an earlier study."""
    from tactgen.validation.scene.load import scene_values
    from tactgen.validation.studies.whatif.defaults import chosen, with_tolerances
    from tactgen.validation.studies.whatif.definition import Statement

    overrides = list(options.overrides)
    if options.frequency is not None:
        overrides.append(f"frequency={options.frequency}")
    if before is not None and options.scene is None and not overrides:
        values, base = before.values, before
    else:
        values, _ = scene_values(options.scene or "paper", overrides)
        base = before or Statement()
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
    stands = options.model or values.get("models") or (base.models and not base.by_accuracy)
    asked = "accuracy" in values or any(axis.key == "accuracy" for axis in found.axes)
    return replace(found, by_accuracy=not stands and asked)


def check_seed(seed: str | None, samples: int) -> None:
    """Refuse a seed of samples that are not drawn."""
    if seed is not None and not samples:
        raise InputError(
            f"--seed {quoted(seed)} needs random samples; add --sample 16, or remove --seed"
        )


def whole_number(text: str, option: str, least: int, most: int, example: str) -> int:
    """Whole number that an option gives; InputError if it is none in the range."""
    number = int(text) if text.strip().isdecimal() and len(text) < 12 else least - 1
    if not least <= number <= most:
        raise InputError(
            f"{option} {quoted(text)} is not a whole number from {least} to {most}; write for "
            f"example {option} {example}"
        )
    return number


def under_accuracy(statement: Statement) -> tuple[Statement, Choice | None]:
    """Statement with the models that its accuracy chooses, if no model is named."""
    if not statement.by_accuracy:
        return statement, None
    from tactgen.validation.studies.whatif.defaults import under_contract

    with announcer() as announce:
        statement, choice = under_contract(statement, announce)
    for sentence in choice.sentences:
        say(sentence)
    return statement, choice
