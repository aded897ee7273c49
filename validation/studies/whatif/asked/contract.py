"""``accuracy`` without a model in a study: the cheapest models known to meet it at its edges."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

from tactgen.geometry.errors import InputError
from tactgen.validation.models.comparison import Choice, choose_for
from tactgen.validation.scene.scene import Scene, checked_scene
from tactgen.validation.studies.whatif.asked.statement import Statement


def asks_accuracy(statement: Statement) -> bool:
    """Return whether an accuracy is stated, in the scene or as an axis."""
    return "accuracy" in statement.values or any(a.key == "accuracy" for a in statement.axes)


def under_contract(
    statement: Statement, announce: Callable[[str], None] = lambda _: None
) -> tuple[Statement, Choice]:
    """Return the statement with the models that the accuracy asks for, and why these.

    The models are judged at :func:`judged_points`, once for the whole study.

    Raises
    ------
    InputError
        If no model is known to meet the accuracy there, or none of these points makes a scene.
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
    choice = choose_for(scenes, statement.quantities, announce)
    return replace(statement, models=choice.models), choice


def judged_points(statement: Statement) -> list[dict[str, Any]]:
    """Return the points at which models are judged: the middle, and from it the end of each axis.

    Of an axis of choices every one, of what is drawn the least and the largest of the samples.
    What a model leaves out grows or falls along an axis, so that it is largest at an end.
    """
    shape = statement.shape
    middle = {dimension: size // 2 for dimension, size in shape.items()}
    places = [middle]
    for dimension, values in statement.columns.values():
        if any(isinstance(value, str) for value in values):
            ends = list(range(len(values)))
        else:
            ends = [min(range(len(values)), key=values.__getitem__),
                    max(range(len(values)), key=values.__getitem__)]  # fmt: skip
        places += [{**middle, dimension: end} for end in ends]
    different = {tuple(place.values()): place for place in places}
    return [
        {key: values[place[dimension]] for key, (dimension, values) in statement.columns.items()}
        for place in different.values()
    ]
