"""Points of one family, answered together by a model that has a faster way to many of them."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from tactgen.geometry.errors import InputError
from tactgen.validation.engine.families import Box, Family, answer_family, find_families
from tactgen.validation.engine.results import Quantity
from tactgen.validation.engine.solve import check_request
from tactgen.validation.engine.warnings import accuracy_warnings, deflection_warnings
from tactgen.validation.scene.scene import Scene, checked_scene
from tactgen.validation.studies.whatif.answers import Answer
from tactgen.validation.studies.whatif.workers import Job


def answers_by_family(
    jobs: Sequence[Job], announce: Callable[[str], None], box: Box | None = None
) -> dict[int, Answer]:
    """Return the answers to the jobs that are answered faster together, by their numbers.

    They are not kept one by one: the reduced basis is, and gives them again in milliseconds.
    With a `box`, the range of keys of which more will be asked, few jobs are enough.
    """
    found: dict[int, Answer] = {}
    groups: dict[tuple[str, tuple[str, ...]], list[Job]] = {}
    for job in jobs:
        groups.setdefault((job.asked.model, job.asked.quantities), []).append(job)
    for (model, quantities), group in groups.items():
        scenes = [checked_scene(job.values) for job in group]
        for family in find_families(model, scenes, quantities, box):
            found |= _answered(family, group, scenes, quantities, announce)
    return found


def _answered(
    family: Family,
    jobs: Sequence[Job],
    scenes: Sequence[Scene],
    quantities: tuple[str, ...],
    announce: Callable[[str], None],
) -> dict[int, Answer]:
    try:
        answers = answer_family(family, scenes, quantities, announce)
    except InputError as error:
        announce(f"{family.model}: one by one, since {error}")
        return {}
    found = {}
    for place, given in zip(family.numbers, answers, strict=True):
        try:
            warnings = _warnings(scenes[place], family.model, given)
        except InputError:  # said where the point is answered alone
            continue
        seconds = sum(quantity.seconds for quantity in given)
        found[jobs[place].number] = Answer("ok", "", given, warnings, seconds)
    return found


def _warnings(scene: Scene, model: str, given: tuple[Quantity, ...]) -> tuple[str, ...]:
    names = [quantity.name for quantity in given]
    _, warnings = check_request(scene, (model,), names)
    warnings += accuracy_warnings(scene, given)
    return warnings + deflection_warnings(scene, given)
