"""The plan of a study: which points are kept, interpolated, or solved, and what that costs."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from tactgen.geometry.errors import InputError
from tactgen.validation.catalogue.models import MODELS
from tactgen.validation.engine.answers import Answer
from tactgen.validation.engine.costs import stage_prospects, total
from tactgen.validation.engine.plan import check_models, make_plan
from tactgen.validation.scene.scene import checked_scene
from tactgen.validation.studies.whatif.by_surrogate import find_parts
from tactgen.validation.studies.whatif.questions import (
    Questions,
    recall,
    refuse_if_no_scene,
    scenes_nearby,
)
from tactgen.validation.studies.whatif.statement import Statement


@dataclass(frozen=True)
class PlannedModel:
    """What a model would do in a study."""

    model: str  #: Its name
    #: Points; of them such as make no scene; solutions that are kept, and those to be made
    points: int
    refused: int
    kept: int
    solved: int
    interpolated: tuple[str, ...]  #: Which points come from surrogates, in words
    #: At most what the solutions take, as their stages did when they last ran here
    seconds: float | None

    @property
    def sentences(self) -> tuple[str, ...]:
        """For the reader."""
        counts = [f"{self.model}: {self.points} point{'s' if self.points > 1 else ''}"]
        counts += [f"{self.refused} refused"] if self.refused else []
        counts += [f"{self.kept} answers kept from before"] if self.kept else []
        if self.solved:
            cost = "cost not recorded yet"
            if MODELS[self.model].quick:
                cost = "a fraction of a second each"
            elif self.seconds is not None:
                cost = f"at most about {self.seconds:.2g} s"
            counts.append(f"{self.solved} to be solved, {cost}")
        return (", ".join(counts), *(f"  {sentence}" for sentence in self.interpolated))


def plan_study(
    statement: Statement, announce: Callable[[str], None] = lambda _: None
) -> tuple[PlannedModel, ...]:
    """What each model of a study would do, without computing anything.

    Raises InputError if the axes cannot be used, no point of them makes a scene, or a quantity has
    no model.
    """
    check_models(statement.models, statement.quantities)
    points = tuple(statement.points())
    nearby = scenes_nearby(statement)
    found, refusals, covered = [], list[Answer](), 0
    for model in statement.models:
        questions = Questions(nearby, statement.quantities)
        parts = find_parts(model, statement.quantities, points, nearby[model])
        reasons, interpolated = [], set[int]()
        for part in parts:
            try:
                design = part.design(nearby[model])
            except InputError:  # then they are answered alone
                continue
            for point in design:
                questions.add(point, model)
            reasons.append(part.reason)
            interpolated |= set(part.numbers)
        covered += len(interpolated)
        rest = ((n, p, model) for n, p in enumerate(points) if n not in interpolated)
        questions.add_points(rest, announce)
        refused = [given for given in questions.at.values() if isinstance(given, Answer)]
        refusals += refused
        new = [n for n, q in questions.different.items() if recall(q) is None]
        seconds = None
        if new and not MODELS[model].quick:
            scene = checked_scene(questions.values[new[0]])
            wanted = questions.different[new[0]].quantities
            each = total(stage_prospects(make_plan(scene, (model,), wanted)))
            seconds = each * len(new) if each else None
        found.append(PlannedModel(
            model, len(points), len(refused), len(questions.different) - len(new), len(new),
            tuple(reasons), seconds,
        ))  # fmt: skip
    if not covered and len(refusals) == len(points) * len(statement.models):
        refuse_if_no_scene(len(points), refusals)
    return tuple(found)
