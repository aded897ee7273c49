"""Points of one family, answered together by a model that has a faster way to many of them."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

from tactgen.geometry.errors import InputError
from tactgen.validation.engine.answers import Answer
from tactgen.validation.engine.families import Box, Family, answer_family, find_families
from tactgen.validation.engine.results import Quantity
from tactgen.validation.engine.solve import request_warnings
from tactgen.validation.engine.warnings import accuracy_warnings, deflection_warnings
from tactgen.validation.scene.scene import Scene
from tactgen.validation.studies.whatif.answers import Question


def answers_by_family(
    asked: Mapping[int, tuple[Question, Scene]],
    announce: Callable[[str], None],
    box: Box | None = None,
) -> dict[int, Answer]:
    """Return the answers to the questions that are answered faster together, by their numbers.

    They are not kept one by one: the reduced basis is, and gives them again in milliseconds.
    With a `box`, the range of keys of which more will be asked, few questions are enough.
    """
    found: dict[int, Answer] = {}
    groups: dict[tuple[str, tuple[str, ...]], list[int]] = {}
    for number, (question, _) in asked.items():
        groups.setdefault((question.model, question.quantities), []).append(number)
    for (model, quantities), numbers in groups.items():
        scenes = [asked[number][1] for number in numbers]
        for family in find_families(model, scenes, quantities, box):
            given = _answered(family, scenes, quantities, announce)
            found |= {numbers[place]: answer for place, answer in given.items()}
    return found


def _answered(
    family: Family,
    scenes: Sequence[Scene],
    quantities: tuple[str, ...],
    announce: Callable[[str], None],
) -> dict[int, Answer]:
    """Return the answers of a family by the places of their scenes."""
    try:
        answers = answer_family(family, scenes, quantities, announce)
    except InputError as error:
        announce(f"{family.model}: one by one, since {error}")
        return {}
    found = {}
    for place, given in zip(family.numbers, answers, strict=True):
        answer = answer_with_warnings(scenes[place], family.model, given)
        if answer is not None:
            found[place] = answer
    return found


def answer_with_warnings(
    scene: Scene, model: str, given: tuple[Quantity, ...], own: tuple[str, ...] = ()
) -> Answer | None:
    """Return an answer of a family's; None where what is asked is refused there.

    That is said where the point is answered alone.  `own` are the model's warnings.
    """
    names = [quantity.name for quantity in given]
    try:
        warnings = request_warnings(scene, (model,), names) + own
        warnings += accuracy_warnings(scene, given)
        warnings += deflection_warnings(scene, given)
    except InputError:
        return None
    return Answer("ok", "", given, warnings, sum(quantity.seconds for quantity in given))
