"""Axes that a scene states by its tolerances: from where values lie without more being said."""

from __future__ import annotations

import copy
from collections.abc import Sequence
from typing import Any

from tactgen.geometry.device.materials import Spread
from tactgen.geometry.errors import InputError
from tactgen.geometry.units import quoted
from tactgen.validation.scene.files import assign
from tactgen.validation.scene.parameter_list import ranges
from tactgen.validation.scene.scene import check_key, checked_scene
from tactgen.validation.studies.whatif.asked.scene_field import as_stated, scene_field


def with_tolerances(
    values: dict[str, Any], vary: Sequence[str], *, sampled: bool
) -> tuple[tuple[str, ...], list[str]]:
    """Return the axes with ranges written out where a key stands alone, and what was drawn from.

    Parameters
    ----------
    values : dict
        The scene's values as they are written.
    vary : sequence of str
        The axes as they are written; none, and every key with a stated tolerance is one.
    sampled : bool
        Whether values are drawn.

    Raises
    ------
    InputError
        If nothing is known of a key's range, or nothing is drawn.
    """
    alone = [text for text in vary if "=" not in text and text.strip()]
    if (vary and not alone) or not (vary or sampled):
        return tuple(vary), []
    for text in alone:
        check_key(text.strip())
    scene = checked_scene(values)
    known = {key: spread for key, spread in ranges(scene).items() if spread.low < spread.high}
    left: list[str] = []
    if not vary:
        stated = [key for key in scene.tolerances if key in known]
        refused = {key: _refusal(values, key, known[key]) for key in stated}
        alone = [key for key in stated if not refused[key]]
        left = [f"{key} is not drawn: {why}" for key, why in refused.items() if why]
        vary = alone
        if not alone:
            raise InputError(
                "--sample is given, but nothing is varied and the scene states no tolerance; write "
                'one, such as --set "bimorph.width=2.10 ± 0.05 mm", or --vary KEY'
            )
    drawn = {text: _known(text.strip(), known, sampled=sampled) for text in alone}
    return (
        tuple(_axis(text.strip(), drawn[text]) if text in drawn else text for text in vary),
        [_line(text.strip(), spread) for text, spread in drawn.items()] + left,
    )


def _refusal(values: dict[str, Any], key: str, spread: Spread) -> str:
    """Return why no scene has a key at an end of its range, such as a length with a profile."""
    for end in (spread.low, spread.high):
        moved = copy.deepcopy(values)
        assign(moved, key, as_stated(key, end))
        try:
            checked_scene(moved)
        except InputError as error:
            return str(error)
    return ""


def _known(key: str, known: dict[str, Spread], *, sampled: bool) -> Spread:
    if key not in known:
        raise InputError(
            f"--vary {quoted(key)} names no values, and the scene states no tolerance of it; write "
            f"--vary {key}=VALUES, or a tolerance in the scene"
        )
    if not sampled:
        raise InputError(
            f"--vary {quoted(key)} names no values; write --vary {key}=VALUES, or add --sample 16 "
            "to draw from its tolerance"
        )
    return known[key]


def _axis(key: str, spread: Spread) -> str:
    unit = scene_field(key).unit
    low, high = (f"{end!r} {unit}".strip() for end in (spread.low, spread.high))
    return f"{key}={low}:{high}"


def _line(key: str, spread: Spread) -> str:
    field = scene_field(key)
    low, high = field.show(spread.low), field.show(spread.high)
    return f"{key} is drawn from {low} to {high} ({spread.reason})"
