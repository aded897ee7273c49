"""The plan: which stages the wanted quantities need, and why all others are skipped."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from geometry.errors import InputError
from validation.catalogue.quantities import MAGNETIC_MODELS, MODELS, QUANTITIES, Need, gives
from validation.engine.stages import READS, stage_key
from validation.scene.scene import Scene


@dataclass(frozen=True)
class Step:
    """A stage that will run: its name, why, and the key of its inputs."""

    stage: str
    reason: str
    key: str


@dataclass(frozen=True)
class Skip:
    """A stage that will not run, and why."""

    stage: str
    reason: str


@dataclass(frozen=True)
class Plan:
    """Stages in the order in which they run, and those that do not."""

    run: tuple[Step, ...]
    skipped: tuple[Skip, ...]

    @property
    def keys(self) -> dict[str, str]:
        """Stages that run, with the key of each."""
        return {step.stage: step.key for step in self.run}


#: Stages that a kind of solution needs in a model, in order.
_STAGES: dict[str, dict[Need, tuple[str, ...]]] = {
    model: {
        "static": (f"{model}.static",),
        "modes_short": (f"{model}.modes",),
        "modes_open": (f"{model}.modes",),
        "harmonic": (f"{model}.ports",),
    }
    for model in ("lumped", "tmm", "beam")
}
_STAGES["solid"] = {
    "static": ("solid.mesh", "solid.assembly", "solid.static"),
    "modes_short": ("solid.mesh", "solid.assembly", "solid.modal", "solid.modes_short"),
    "modes_open": ("solid.mesh", "solid.assembly", "solid.modal", "solid.modes_open"),
    "harmonic": ("solid.mesh", "solid.assembly", "solid.ports"),
}
_STAGES |= {
    model: {
        "magnetic_point": (f"{model}.point",),
        "magnetic_map": (f"{model}.map", f"{model}.switching"),
    }
    for model in MAGNETIC_MODELS
}
_BECAUSE: dict[Need, str] = {
    "static": "a static value",
    "modes_short": "short-circuit modes",
    "modes_open": "open-circuit modes",
    "harmonic": "the response at given frequencies",
    "magnetic_point": "the magnetic circuit at one current and gap",
    "magnetic_map": "the magnetic circuit over the stroke",
}


def make_plan(scene: Scene, models: Sequence[str], quantities: Sequence[str]) -> Plan:
    """Derive the plan from what is wanted.

    Raises
    ------
    InputError
        If a model cannot take the scene, or a quantity has no model.
    """
    check_models(models, quantities)
    if "solid" in models:
        from validation.models.bimorph.meshes import check_meshable

        check_meshable(scene)
    reasons: dict[str, list[str]] = {}
    for model in models:
        for quantity in (q for q in quantities if gives(model, q)):
            info = QUANTITIES[quantity]
            for need in info.needs:
                for stage in _STAGES[model][need]:
                    reasons.setdefault(stage, []).append(quantity)
            if set(info.needs) & {"static", "harmonic"}:
                reasons.setdefault("terminations", []).append(quantity)
    run = tuple(
        Step(stage, "for " + _list(reasons[stage]), stage_key(stage, scene))
        for stage in READS
        if stage in reasons
    )
    skipped = tuple(Skip(stage, _why_not(stage, models)) for stage in READS if stage not in reasons)
    return Plan(run, skipped)


def check_models(models: Sequence[str], quantities: Sequence[str]) -> None:
    """Refuse a quantity that none of the models can compute.

    Raises
    ------
    InputError
        With the models that can.
    """
    for quantity in quantities:
        if not any(gives(model, quantity) for model in models):
            able = [model for model in MODELS if gives(model, quantity)]
            raise InputError(
                f'quantity "{quantity}" is computed by {", ".join(able)}, not by '
                f"{', '.join(models)}; add for example --model {able[1]}"
            )


def _list(names: list[str]) -> str:
    unique = list(dict.fromkeys(names))
    if len(unique) > 3:
        return f"{unique[0]}, {unique[1]} and {len(unique) - 2} more"
    return ", ".join(unique)


def _why_not(stage: str, models: Sequence[str]) -> str:
    model = stage.split(".", maxsplit=1)[0]
    if model in MODELS and model not in models:
        return f"model {model} is not asked for"
    needs = [need for need, stages in _STAGES.get(model, {}).items() if stage in stages]
    wanted = " or ".join(_BECAUSE[need] for need in needs) or "a terminated response"
    return f"no quantity that is wanted needs {wanted}"
