"""Evaluate quantities: models in, numbers with error bars out."""

from __future__ import annotations

import importlib
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any

from tactgen.validation.catalogue.detection import threshold_of
from tactgen.validation.catalogue.models import MAPS, MODELS, gives
from tactgen.validation.catalogue.quantities import QUANTITIES
from tactgen.validation.catalogue.row import Actuator
from tactgen.validation.engine.answers import quantity_json
from tactgen.validation.engine.model import Model, make_model
from tactgen.validation.engine.plan import Plan, Step, make_plan, record, stages_for
from tactgen.validation.engine.readout import read
from tactgen.validation.engine.results import Quantity
from tactgen.validation.engine.stages import Stages
from tactgen.validation.engine.warnings import (
    accuracy_warnings,
    check_held,
    deflection_warnings,
    field_warnings,
    held_warnings,
    level_warnings,
    load_warnings,
    slenderness_warnings,
    stress_warnings,
)
from tactgen.validation.scene.scene import Scene


@dataclass(frozen=True)
class Solution:
    """Solution of a request: quantities, plan and warnings."""

    scene: Scene
    quantities: tuple[Quantity, ...]
    plan: Plan
    warnings: tuple[str, ...]
    models: dict[str, Model]
    stages: Stages

    def get(self, name: str, model: str) -> Quantity:
        """One quantity of one model."""
        return self.by_model(name)[model]

    def beside(self, quantities: tuple[Quantity, ...], stages: Stages) -> Solution:
        """Solution with another process's results of the same scene."""
        both = replace(self.stages, keys=self.stages.keys | stages.keys)
        both.adopt(stages)
        return replace(self, quantities=self.quantities + quantities, stages=both)

    def by_model(self, name: str) -> dict[str, Quantity]:
        """One quantity of all models that were asked for and give it."""
        return {q.model: q for q in self.quantities if q.name == name}

    def models_of(self, actuator: Actuator) -> dict[str, Model]:
        """Models of an actuator, in the order asked for."""
        return {n: model for n, model in self.models.items() if MODELS[n].actuator == actuator}


def solve(
    scene: Scene,
    models: Sequence[str] | None = None,
    quantities: Sequence[str] | None = None,
    announce: Callable[[str], None] = lambda _: None,
    reuse: Solution | None = None,
) -> Solution:
    """Compute the wanted quantities with the wanted models (the scene's by default).

    Stages whose inputs are those of an earlier solution, `reuse`, are not run again: a
    new load, support spring or voltage needs no new field solution.  Of the very same scene its
    quantities are taken as they are.

    Raises InputError if a loaded response is asked for only where the finger's load is not known,
    or the threshold voltage alone where the threshold is not.
    """
    names = tuple(models or scene.models)
    quantities = tuple(quantities or scene.quantities)
    scene = scene.asking(names)
    awaited = scene.awaits_map
    plan, warnings = check_request(scene, names, quantities)
    stages = Stages(plan.keys, announce)
    if reuse is not None:
        stages.adopt(reuse.stages)
    if f"{scene.map_model}.map" in plan.keys:
        importlib.import_module(MAPS).map_of(scene, stages)
    if awaited:
        warnings += _of_held(scene, names, quantities)
    made = {name: make_model(name, scene, stages) for name in names}
    same = reuse.quantities if reuse is not None and reuse.scene == scene else ()
    known = {(quantity.name, quantity.model): quantity for quantity in same}
    found = [
        known.get((name, model)) or evaluate(name, made[model])
        for name in quantities
        for model in names
        if gives(model, name)
    ]
    for model in made.values():
        warnings += model.warnings(quantities)
    warnings += accuracy_warnings(scene, found)
    warnings += deflection_warnings(scene, found)
    warnings += stress_warnings(scene, made, quantities, found)
    record({stage: stages.seconds[stage] for stage in stages.computed})
    # models of one theory say the same
    return Solution(scene, tuple(found), plan, tuple(dict.fromkeys(warnings)), made, stages)


def check_request(
    scene: Scene, models: Sequence[str], quantities: Sequence[str]
) -> tuple[Plan, tuple[str, ...]]:
    """Plan of a request and its warnings, before anything is computed.

    Raises InputError if it cannot be answered, as :func:`solve`.
    """
    warnings = request_warnings(scene, models, quantities)
    return make_plan(scene, models, quantities), warnings


def request_warnings(
    scene: Scene, models: Sequence[str], quantities: Sequence[str]
) -> tuple[str, ...]:
    """Warnings about a request before anything is computed.

    Raises InputError if it cannot be answered, whichever the models.
    """
    scene = scene.asking(models)
    held = () if scene.awaits_map else _of_held(scene, models, quantities)
    warnings = load_warnings(scene, quantities) + level_warnings(scene, quantities)
    warnings += held + field_warnings(scene, quantities)
    warnings += slenderness_warnings(scene, models)
    return warnings


def _of_held(scene: Scene, models: Sequence[str], quantities: Sequence[str]) -> tuple[str, ...]:
    """Check the bimorph's support, and return warnings."""
    check_held(scene, quantities)
    return held_warnings(scene, models)


def evaluate(name: str, model: Model) -> Quantity:
    """Quantity by a model, with its numerical error bar."""
    row = QUANTITIES[name].at_threshold(threshold_of(model.scene.threshold))
    judged = read(row, model)
    return Quantity(
        name=name,
        model=model.name,
        value=judged.value,
        unit=row.unit,
        error=judged.error,
        method=judged.method,
        seconds=_cost(name, model),
        frequency=model.scene.frequency if row.by_frequency else None,
        classes=judged.classes,
    )


def _cost(name: str, model: Model) -> float:
    """Seconds of all stages this quantity needs, shared or not."""
    needed = stages_for(model.scene, model.name, name)
    return sum(model.stages.seconds.get(stage, 0.0) for stage in needed)


def as_json(solution: Solution) -> dict[str, Any]:
    """Solution as plain JSON values; see quantity_json."""
    return {
        "scene": solution.scene.name,
        "quantities": [quantity_json(q) for q in solution.quantities],
        "plan": plan_json(solution.plan),
        "warnings": list(solution.warnings),
    }


def plan_json(plan: Plan) -> dict[str, Any]:
    """Plan as plain JSON values."""

    def entry(step: Step) -> dict[str, str]:
        return {"stage": step.stage, "reason": step.reason, "key": step.key}

    return {
        "run": [entry(step) for step in plan.run],
        "skipped": [{"stage": s.stage, "reason": s.reason} for s in plan.skipped],
    }
