"""Defaults of a study: models, quantities, ranges.

Models and quantities that are not named, ranges from the tolerances that a scene states, and the
cheapest models known to meet an accuracy.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any

from tactgen.geometry.device.materials import Spread
from tactgen.geometry.errors import InputError
from tactgen.geometry.units import quoted
from tactgen.validation.catalogue.models import MODELS, all_given, gives
from tactgen.validation.catalogue.quantities import OF_CIRCUIT, QUANTITIES, quantities_of
from tactgen.validation.engine.comparison import Choice, choose
from tactgen.validation.scene.files import choices
from tactgen.validation.scene.keys import check_key
from tactgen.validation.scene.load import checked_scene
from tactgen.validation.scene.parameter_list import ranges
from tactgen.validation.scene.scene import Scene
from tactgen.validation.scene.variation import ScenesNearby
from tactgen.validation.studies.whatif.axes import as_stated, scene_field
from tactgen.validation.studies.whatif.definition import Statement

#: Quick, and exact within their theories: of what the first gives it, of the rest the second.
_USUAL = ("tmm", "network")


def chosen(
    values: dict[str, Any],
    models: Sequence[str] | None,
    quantities: Sequence[str] | None,
    before: Statement,
) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """Models and quantities by name.

    As the options say; else as the study says that is gone on with, or the scene; else the
    headline quantities of the lateral actuator and those of its circuit, by the quick model that is
    exact within its theory.

    Raises InputError for an unknown name, or models that give none of the quantities.
    """
    earlier = () if before.by_accuracy else before.models
    stated_models = models or earlier or values.get("models")
    stated_quantities = quantities or before.quantities or values.get("quantities")
    by_name = _names(stated_models, tuple(MODELS), "model", "models") if stated_models else ()
    if stated_quantities:
        wanted = _names(stated_quantities, tuple(QUANTITIES), "quantity", "quantities")
        if wanted == tuple(QUANTITIES):
            wanted = all_given(by_name or _USUAL)
        elif by_name:
            wanted = tuple(q for q in wanted if any(gives(m, q) for m in by_name)) or wanted
    else:
        actuators = {MODELS[m].actuator for m in by_name} or {"bimorph"}
        wanted = tuple(
            q for actuator in ("bimorph", "reluctance") if actuator in actuators
            for q in quantities_of(actuator) if QUANTITIES[q].headline
        )  # fmt: skip
        if "bimorph" in actuators:
            wanted += OF_CIRCUIT.get(str(values.get("circuit", {}).get("kind")), ())
    if not by_name:
        by_name = tuple(dict.fromkeys(m for q in wanted for m in _USUAL if gives(m, q)))
    idle = [m for m in by_name if not any(gives(m, q) for q in wanted)]
    if idle:
        raise InputError(
            f"model {idle[0]} gives none of {', '.join(wanted)}; remove it, or ask for "
            f"something that it gives, such as {all_given((idle[0],))[0]}"
        )
    return by_name, wanted


def _names(stated: Any, known: tuple[str, ...], kind: str, key: str) -> tuple[str, ...]:
    return choices(",".join(stated) if not isinstance(stated, str) else stated, known, kind, key)


def with_tolerances(
    values: dict[str, Any], vary: Sequence[str], *, sampled: bool
) -> tuple[tuple[str, ...], list[str]]:
    """Axes with ranges written out where a key stands alone, and their sources.

    Scene and axes are as they are written; of no axis, every key with a stated tolerance is one.
    `sampled` tells whether values are drawn.

    Raises InputError if nothing is known of a key's range, or nothing is drawn.
    """
    alone = [text.strip() for text in vary if "=" not in text and text.strip()]
    if (vary and not alone) or not (vary or sampled):
        return tuple(vary), []
    for key in alone:
        check_key(key)
    scene, notes = checked_scene(values), []
    known = {key: spread for key, spread in ranges(scene).items() if spread.low < spread.high}
    if not vary:
        for key in (key for key in scene.tolerances if key in known):
            if refused := _refusal(values, key, known[key]):
                notes.append(f"{key} is not drawn: {refused}")
            else:
                alone.append(key)
        if not alone:
            nothing = (
                "nothing is varied and the scene states no tolerance; write one, such as --set "
                '"bimorph.width=2.10 ± 0.05 mm", or --vary KEY'
            )
            raise InputError(f"--sample is given, but {notes[0] if notes else nothing}")
        vary = alone
    drawn = {}
    for key in alone:
        if not sampled:
            raise InputError(
                f"--vary {quoted(key)} names no values; write --vary {key}=VALUES, or add --sample "
                "16 to draw from its tolerance"
            )
        if key not in known:
            raise InputError(
                f"--vary {quoted(key)} names no values, and the scene states no tolerance of it; "
                f"write --vary {key}=VALUES, or a tolerance in the scene"
            )
        spread, field = known[key], scene_field(key)
        low, high = (f"{end!r} {field.unit}".strip() for end in (spread.low, spread.high))
        drawn[key] = f"{key}={low}:{high}"
        low, high = field.show(spread.low), field.show(spread.high)
        notes.append(f"{key} is drawn from {low} to {high} ({spread.reason})")
    return tuple(drawn.get(text.strip(), text) for text in vary), notes


def _refusal(values: dict[str, Any], key: str, spread: Spread) -> str:
    """Reason why a key cannot reach the ends of its range, or ""."""
    for end in (spread.low, spread.high):
        try:
            ScenesNearby(values).scene(as_stated({key: end}))
        except InputError as error:
            return str(error)
    return ""


def under_contract(
    statement: Statement, announce: Callable[[str], None] = lambda _: None
) -> tuple[Statement, Choice]:
    """Statement with the models that the accuracy asks for, and why these.

    The models are judged at :func:`judged_points`, once for the whole study.

    Raises InputError if no model is known to meet the accuracy there, or none of these points makes
    a scene.
    """
    scenes: list[Scene] = []
    refused = ""
    for point in judged_points(statement):
        try:
            scenes.append(checked_scene(statement.scene_at(point)))
        except InputError as error:
            refused = refused or str(error)
    if not scenes:
        raise InputError(f"no point at the study's edges makes a scene: {refused}")
    choice = choose(scenes, statement.quantities, announce)
    return replace(statement, models=choice.models), choice


def judged_points(statement: Statement) -> list[dict[str, Any]]:
    """Points at which models are judged: the middle, and from it the end of each axis.

    Of an axis of choices every one, of what is drawn the least and the largest of the samples.
    What a model leaves out grows or falls along an axis, so that it is largest at an end.
    """
    middle = {dimension: size // 2 for dimension, size in statement.shape.items()}
    places = [middle]
    for dimension, values in statement.columns.values():
        if any(isinstance(value, str) for value in values):
            ends = list(range(len(values)))
        else:
            ends = [values.index(min(values)), values.index(max(values))]
        places += [{**middle, dimension: end} for end in ends]
    different = {tuple(place.values()): place for place in places}
    return [statement.point(place) for place in different.values()]
