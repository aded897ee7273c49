"""Evaluate quantities: models in, numbers with error bars out."""

from __future__ import annotations

import contextlib
import itertools
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any, NamedTuple

from tactgen.geometry.errors import CoarseGridError, InputError
from tactgen.geometry.store.store import (
    SUFFIX,
    Damaged,
    is_cached,
    read_entry,
    sealed,
    store_folder,
    write_entry,
)
from tactgen.validation.catalogue.models import MODELS, gives, stage_reads
from tactgen.validation.catalogue.quantities import NEEDS, QUANTITIES, Actuator
from tactgen.validation.engine.answers import plain, quantity_json
from tactgen.validation.engine.extremes import extreme
from tactgen.validation.engine.modelling import with_modelling
from tactgen.validation.engine.readout import read
from tactgen.validation.engine.warnings import answer_warnings, held_warnings, request_warnings
from tactgen.validation.models.classes import make_model, map_of, model_class, stage_code
from tactgen.validation.models.model import Model, Quantity, Stages
from tactgen.validation.scene.conditions import answer_head
from tactgen.validation.scene.inputs import stage_keys
from tactgen.validation.scene.scene import Scene, chosen_models, chosen_quantities


@dataclass(frozen=True)
class Step:
    """A stage that will run: its name, why, and the key of its inputs."""

    stage: str
    reason: str
    key: str


@dataclass(frozen=True)
class Plan:
    """Stages in the order in which they run, and those that do not."""

    run: tuple[Step, ...]
    models: tuple[str, ...]

    @cached_property
    def keys(self) -> dict[str, str]:
        """Stages that run, with the key of each."""
        return {step.stage: step.key for step in self.run}

    @property
    def skipped(self) -> dict[str, str]:
        """Stages that do not run, with the reason."""
        return {s: _why_not(s, self.models) for s in stage_reads() if s not in self.keys}


def asks_display(quantities: Iterable[str]) -> bool:
    """Whether one of the quantities is of the display."""
    return any(QUANTITIES[name].actuator == "display" for name in quantities)


def make_plan(scene: Scene, models: Sequence[str], quantities: Sequence[str]) -> Plan:
    """Derive the plan from the wanted quantities.

    Raises InputError if a model cannot take the scene, or a quantity has no model.
    """
    scene = scene.asking(models)
    check_models(models, quantities)
    check_scene(scene, models, quantities)
    reasons: dict[str, list[str]] = {}
    for model in models:
        for quantity in quantities:
            for stage in stages_for(scene, model, quantity) if gives(model, quantity) else ():
                reasons.setdefault(stage, []).append(quantity)
    stages = [stage for stage in stage_reads() if stage in reasons]
    first = f"{scene.map_model}.map"  # before what stands on the rod that it pulls
    if first in stages and any(MODELS[model].actuator == "bimorph" for model in models):
        stages = [first, *(stage for stage in stages if stage != first)]
    keys = stage_keys(stages, scene)
    run = tuple(Step(stage, "for " + _list(reasons[stage]), keys[stage]) for stage in stages)
    return Plan(run, tuple(models))


def check_scene(scene: Scene, models: Sequence[str], quantities: Sequence[str]) -> None:
    """Refuse a scene that one of the models cannot take, or of which quantities say nothing.

    Raises InputError with the remedy.
    """
    check_on_contact(scene, quantities)
    for model in models:
        model_class(model).check(scene)


def stages_for(scene: Scene, model: str, quantity: str) -> tuple[str, ...]:
    """Stages that a quantity by a model needs, and the map that pulls at the rod."""
    row, needs = MODELS[model], QUANTITIES[quantity].needs
    own = row.stages_for(QUANTITIES[quantity])
    pulled = scene.support.kind == "contact" and scene.coil.current != 0.0
    if needs[0] in ("small_signal", "machine_poles") or (
        pulled and row.actuator == "bimorph" and needs != ("load",)
    ):
        return (f"{scene.map_model}.map", *own)
    return own


def check_models(models: Sequence[str], quantities: Sequence[str]) -> None:
    """Refuse a quantity that none of the models can compute.

    Raises InputError with the models that can.
    """
    for quantity in quantities:
        able = [model for model in MODELS if gives(model, quantity)]
        if not set(able) & set(models):
            # the cheapest that takes no shortcut
            enough = next((model for model in able if not MODELS[model].shortcut), able[0])
            raise InputError(
                f'quantity "{quantity}" is computed by {", ".join(able)}, not by '
                f"{', '.join(models)}; write for example --set models={','.join([*models, enough])}"
            )


def check_on_contact(scene: Scene, quantities: Sequence[str]) -> None:
    """Refuse the machine, or the display, of a bimorph that does not stand on its rod's contact.

    And a display whose parts run into each other.

    Raises InputError with the remedy.
    """
    for name in quantities:
        actuator = QUANTITIES[name].actuator
        if actuator in ("generator", "display") and scene.support.kind != "contact":
            raise InputError(
                f'{name} is of the machine on its rod, of which support.kind = "'
                f'{scene.support.kind}" says nothing; set support.kind=contact'
            )
        if actuator == "display":
            from tactgen.geometry.display.clearances import check_display

            check_display(scene.device, scene.display)


def _list(names: list[str]) -> str:
    unique = list(dict.fromkeys(names))
    if len(unique) > 3:
        return f"{unique[0]}, {unique[1]} and {len(unique) - 2} more"
    return ", ".join(unique)


def _why_not(stage: str, models: Sequence[str]) -> str:
    model, _, own = stage.partition(".")
    if model not in models:
        return f"model {model} is not among the models"
    needs = [NEEDS[n][1] for n, stages in MODELS[model].gives.items() if own in stages]
    return f"no quantity that is wanted needs {' or '.join(needs)}"


#: Stages that take less (s) are not worth a line in a file.
_LEAST = 0.02
#: Change of a cost (as a share) that is worth writing it down again.
_CHANGED = 0.25


def recorded() -> dict[str, float]:
    """Seconds that stages took when they last ran, by name; of none that never did."""
    try:
        found: dict[str, float] = read_entry(_costs())
    except (FileNotFoundError, Damaged):
        return {}
    return found


def record(seconds: Mapping[str, float]) -> None:
    """Record the cost of the stages that ran now, where possible.

    Of two processes that write at once one wins: it is an estimate.
    """
    worth = {stage: cost for stage, cost in seconds.items() if cost >= _LEAST}
    before = recorded() if worth else {}
    if any(abs(cost - before.get(stage, 0.0)) > _CHANGED * cost for stage, cost in worth.items()):
        with contextlib.suppress(OSError, InputError):
            write_entry(_costs(), sealed(_costs(), before | worth))


def _costs() -> Path:
    return store_folder() / f"costs{SUFFIX}"


class Prospect(NamedTuple):
    """One stage of a plan: whether its result is kept, and the seconds recorded, if any are."""

    kept: bool
    seconds: float | None


def stage_prospects(plan: Plan) -> dict[str, Prospect]:
    """Prospects of a plan's stages, by name.

    Costs are those of the last run on this machine, of whatever scene: an order of magnitude.
    """
    costs, codes = recorded(), {stage: stage_code(stage) for stage in plan.keys}
    return {
        stage: Prospect(
            bool(code) and is_cached(stage, (plan.keys[stage],), code), costs.get(stage)
        )
        for stage, code in codes.items()
    }


def total(prospects: dict[str, Prospect]) -> float:
    """Seconds of all that is not kept and of which a cost is recorded."""
    return sum(p.seconds for p in prospects.values() if not p.kept and p.seconds is not None)


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

    def by_model(self, name: str) -> dict[str, Quantity]:
        """One quantity of all models that were asked for and give it."""
        return {q.model: q for q in self.quantities if q.name == name}

    def models_of(self, actuator: Actuator) -> dict[str, Model]:
        """Models of an actuator, in the order asked for."""
        return {n: model for n, model in self.models.items() if MODELS[n].actuator == actuator}


def solve(
    scene: Scene,
    models: str | Sequence[str] | None = None,
    quantities: str | Sequence[str] | None = None,
    announce: Callable[[str], None] = lambda _: None,
    reuse: Solution | None = None,
    checked: tuple[Plan, tuple[str, ...]] | None = None,
    *,
    modelling: bool = True,
) -> Solution:
    """Compute the wanted quantities with the wanted models (the scene's by default).

    Names are given one by one in a list, or as one text such as "tmm", "tmm,solid" or "all".

    Stages whose inputs are those of an earlier solution, `reuse`, are not run again: a
    new load, support spring or voltage needs no new field solution.  Of the very same scene its
    quantities are taken as they are.  `checked` is what :func:`check_request` gave, if it ran.
    Without `modelling` the quantities have no modelling errors.

    A quantity whose field no grid resolves is left out, with a warning.

    Raises InputError if a loaded response is asked for only where the finger's load is not known,
    or the threshold voltage alone where the threshold is not, or no quantity is left.
    """
    names = chosen_models(models or scene.models)
    quantities = chosen_quantities(quantities or scene.quantities, names)
    scene = scene.asking(names)
    awaited = scene.awaits_map
    plan, warnings = checked or check_request(scene, names, quantities)
    stages = Stages(plan.keys, announce)
    if reuse is not None:
        stages.adopt(reuse.stages)
    if f"{scene.map_model}.map" in plan.keys and scene.support.kind == "contact":
        map_of(scene, stages)
    if awaited:
        map_of(scene)
        warnings += (*held_warnings(scene, names, quantities),)
    made = {name: make_model(name, scene, stages) for name in names}
    same = reuse.quantities if reuse is not None and reuse.scene == scene else ()
    known = {(quantity.name, quantity.model): quantity for quantity in same}
    found: list[Quantity] = []
    refused: dict[str, list[str]] = {}
    for name, model in itertools.product(quantities, names):
        if gives(model, name):
            try:
                found.append(known.get((name, model)) or evaluate(name, made[model]))
            except CoarseGridError as error:
                refused.setdefault(f"{model}: {error}", []).append(name)
    if not found:
        raise CoarseGridError(next(iter(refused)))
    warnings += tuple(f"no {', '.join(few)} by {why}" for why, few in refused.items())
    if modelling:
        found = [*with_modelling(scene, found, made)]
    warnings += answer_warnings(scene, made, found)
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


def evaluate(name: str, model: Model) -> Quantity:
    """Quantity by a model, with its numerical error bar and the cost of all stages it needs."""
    row, scene = QUANTITIES[name], model.scene
    found, seconds = read(row, model), model.stages.seconds
    return Quantity(
        name=name,
        model=model.name,
        value=found.value,
        unit=row.unit,
        error=found.error,
        method=found.method,
        seconds=sum(seconds.get(s, 0.0) for s in stages_for(scene, model.name, name)),
        frequency=scene.frequency if row.by_frequency else None,
        classes=found.classes,
        extreme=extreme(row, model),
    )


def as_json(solution: Solution) -> dict[str, Any]:
    """Solution as plain JSON values; see quantity_json."""
    return {
        **answer_head(solution.scene),
        "not_stated": list(solution.scene.not_stated),
        "quantities": [quantity_json(q) for q in solution.quantities],
        "plan": plan_json(solution.plan),
        "warnings": list(solution.warnings),
    }


def plan_json(plan: Plan) -> dict[str, Any]:
    """Plan as plain JSON values."""
    skipped = [{"stage": stage, "reason": reason} for stage, reason in plan.skipped.items()]
    return {"run": [plain(step) for step in plan.run], "skipped": skipped}
