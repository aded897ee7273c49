"""Which questions the points of a study ask: of points that differ in nothing that is read, one."""

from __future__ import annotations

from collections.abc import Callable, Container, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from tactgen.geometry.errors import InputError
from tactgen.validation.catalogue.models import MODELS, models_of
from tactgen.validation.engine.answers import Answer
from tactgen.validation.scene.files import choices
from tactgen.validation.scene.nearby import ScenesNearby
from tactgen.validation.scene.scene import Scene
from tactgen.validation.studies.whatif.answers import Question, question, reason
from tactgen.validation.studies.whatif.asked.scene_field import as_stated
from tactgen.validation.studies.whatif.asked.statement import Statement


@dataclass(frozen=True)
class Questions:
    """What is asked at points, by models.

    Attributes
    ----------
    at : dict of (int, str) to int or Answer
        By point and model the number of the question, or why it is refused.
    different : dict of int to Question
        By number.
    scenes : dict of int to Scene
        Of models that answer families.
    first : dict of int to dict
        The first point that asks each, as a scene states it.
    """

    at: dict[tuple[int, str], int | Answer] = field(default_factory=dict)
    different: dict[int, Question] = field(default_factory=dict)
    scenes: dict[int, Scene] = field(default_factory=dict)
    first: dict[int, dict[str, Any]] = field(default_factory=dict)


def scenes_nearby(statement: Statement) -> dict[str, ScenesNearby]:
    """Return by model the scenes that its points are asked at.

    Beside a model of the bimorph stand those of the normal actuator that the scene names: they
    say whose map pulls at the rod.
    """
    stated = statement.values.get("models")
    named = choices(stated, tuple(MODELS), "model", "models") if stated else ()
    maps = [name for name in models_of("reluctance") if name in named]
    asked = {
        model: [model, *maps] if MODELS[model].actuator == "bimorph" else [model]
        for model in statement.models
    }
    return {
        model: ScenesNearby({**statement.values, "models": models, "quantities": ["all"]})
        for model, models in asked.items()
    }


def questions(
    statement: Statement,
    points: Sequence[Mapping[str, Any]],
    nearby: Mapping[str, ScenesNearby],
    answered: Container[tuple[int, str]] = (),
    announce: Callable[[str], None] = lambda _: None,
) -> Questions:
    """Return what points ask but those, with models, that are answered already."""
    found = Questions()
    # points that differ in what a model does not read ask it the same
    place: dict[str, int] = {}
    for number, point in enumerate(points):
        if number % 100 == 0:
            announce(f"points checked: {number} of {len(points)}")
        models = [model for model in statement.models if (number, model) not in answered]
        stated = {key: as_stated(key, value) for key, value in point.items()} if models else {}
        for model in models:
            try:
                scene = nearby[model].scene(stated)
                asked = question(scene, model, statement.quantities)
            except InputError as error:
                found.at[number, model] = Answer("refused", reason(error))
                continue
            n = place.setdefault(repr((asked.model, asked.inputs)), len(place))
            found.at[number, model] = n
            if n not in found.different:
                found.different[n], found.first[n] = asked, stated
                if MODELS[model].families or MODELS[model].walks:
                    found.scenes[n] = scene
    return found
