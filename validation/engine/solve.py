"""Evaluate quantities: models in, numbers with error bars out."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from geometry.bimorph.ends import Ends
from tmm.ports.multiport import Multiport, in_series, respond, round_off
from tmm.ports.terminations import attach
from validation.catalogue.detection import DISPLAY_THRESHOLD
from validation.catalogue.quantities import LATERAL_MODELS, MAGNETIC_MODELS, QUANTITIES, gives
from validation.engine.limits import (
    accuracy_warnings,
    check_held,
    deflection_warnings,
    load_warnings,
    threshold_warnings,
)
from validation.engine.model import Model, Modes, Refined, make_model
from validation.engine.plan import Plan, Step, make_plan
from validation.engine.results import Quantity, quantity_json
from validation.engine.stages import Stages
from validation.models.reluctance.model import MagneticModel
from validation.models.reluctance.registry import make_magnetic_model, read_magnetic
from validation.models.reluctance.warnings import magnetic_warnings
from validation.scene.scene import Scene

Array = NDArray[Any]


@dataclass(frozen=True)
class Solution:
    """What a request gave: quantities, the plan that gave them, and warnings.

    `models` are those of the lateral actuator.
    """

    scene: Scene
    quantities: tuple[Quantity, ...]
    plan: Plan
    warnings: tuple[str, ...]
    models: dict[str, Model]
    magnetic_models: dict[str, MagneticModel]
    stages: Stages

    def get(self, name: str, model: str) -> Quantity:
        """Return one quantity of one model."""
        return next(q for q in self.quantities if (q.name, q.model) == (name, model))


def solve(
    scene: Scene,
    models: Sequence[str] | None = None,
    quantities: Sequence[str] | None = None,
    announce: Callable[[str], None] = lambda _: None,
    reuse: Solution | None = None,
) -> Solution:
    """Compute the wanted quantities with the wanted models (the scene's by default).

    Stages whose inputs are those of an earlier solution, `reuse`, are not run again: a
    new load, support spring or voltage needs no new field solution.

    Raises
    ------
    InputError
        If a loaded response is asked for only where the finger's load is not known, or the
        threshold voltage alone where the threshold is not.
    """
    models = tuple(models or scene.models)
    quantities = tuple(quantities or scene.quantities)
    check_held(scene, quantities)
    warnings = load_warnings(scene, quantities) + threshold_warnings(scene, quantities)
    plan = make_plan(scene, models, quantities)
    stages = Stages(plan.keys, announce)
    if reuse is not None:
        stages.adopt(reuse.stages)
    lateral = {n: make_model(n, scene, stages) for n in models if n in LATERAL_MODELS}
    magnetic = {n: make_magnetic_model(n, scene, stages) for n in models if n in MAGNETIC_MODELS}
    found = [
        evaluate_magnetic(name, magnetic[model])
        if model in magnetic
        else evaluate(name, lateral[model])
        for name in quantities
        for model in models
        if gives(model, name)
    ]
    warnings += magnetic_warnings(magnetic.values(), quantities)
    warnings += accuracy_warnings(scene, found)
    warnings += deflection_warnings(scene, found)
    return Solution(scene, tuple(found), plan, warnings, lateral, magnetic, stages)


def evaluate(name: str, model: Model) -> Quantity:
    """Return one of the lateral actuator's quantities with its numerical error bar."""
    info = QUANTITIES[name]
    classes = None
    if name in ("short_circuit_frequencies", "open_circuit_frequencies"):
        refined = model.modes(open_circuit=name.startswith("open"))
        count = model.scene.modes
        rounding = 1e-13 + _by_mode(refined)[:count]
        refined = replace(refined, rounding=0.0)
        value, bar, method = _judge(refined, lambda m: m.frequencies[:count], rounding)
        classes = refined.fine.classes[:count]
    elif name == "coupling_factor":
        value, bar, method = _coupling(model)
    elif "static" in info.needs:
        value, bar, method = _static(name, model)
    else:
        value, bar, method = _harmonic(name, model)
    return Quantity(
        name=name,
        model=model.name,
        value=value,
        unit=info.unit,
        uncertainty=bar,
        uncertainty_method=method,
        seconds=_cost(name, model),
        frequency=model.scene.frequency if info.by_frequency else None,
        classes=classes,
    )


def evaluate_magnetic(name: str, model: MagneticModel) -> Quantity:
    """Return one of the normal actuator's quantities with its numerical error bar."""
    found, method = read_magnetic(name, model)
    return Quantity(
        name=name,
        model=model.name,
        value=np.asarray(found.value),
        unit=QUANTITIES[name].unit,
        uncertainty=np.asarray(found.bar),
        uncertainty_method=method,
        seconds=_cost(name, model),
    )


def _cost(name: str, model: Model | MagneticModel) -> float:
    """Return the seconds of all stages this quantity needs, shared or not."""
    needed = make_plan(model.scene, (model.name,), (name,)).run
    return sum(model.stages.seconds.get(step.stage, 0.0) for step in needed)


def _judge(
    refined: Refined[Any], read: Callable[[Any], Array], rounding: Any
) -> tuple[Array, Array, str]:
    """Apply `read` to the fine and the coarser results; the bars add."""
    value = np.asarray(read(refined.fine))
    bar = np.abs(value) * (rounding + refined.rounding)
    for coarser, factor in refined.coarser:
        bar = bar + factor * np.abs(value - np.asarray(read(coarser)))
    return value, np.asarray(bar, dtype=float), refined.method


def _by_mode(refined: Refined[Modes]) -> Array:
    """Return the rounding error of each mode."""
    return np.broadcast_to(refined.rounding, refined.fine.frequencies.shape)


def _of_bending(refined: Refined[Modes]) -> float:
    """Return the rounding error of the first bending mode in x, nan if there is none."""
    bends = np.array(refined.fine.classes) == "bending_x"
    return float(_by_mode(refined)[bends][0]) if bends.any() else float("nan")


def _coupling(model: Model) -> tuple[Array, Array, str]:
    short, opened = model.modes(open_circuit=False), model.modes(open_circuit=True)
    pairs = Refined(
        (short.fine, opened.fine),
        tuple(
            ((s, o), max(of_short, of_open))
            for (s, of_short), (o, of_open) in zip(short.coarser, opened.coarser, strict=True)
        ),
        short.method,
    )

    def factor(pair: tuple[Modes, Modes]) -> Array:
        ratio = pair[0].first_bending / pair[1].first_bending
        return np.asarray(np.sqrt(max(1.0 - ratio**2, 0.0)))

    value, _, _ = _judge(pairs, factor, 0.0)
    # k² is the difference of nearly equal numbers: rounding grows by 1/k²
    rounding = 1e-13 + _of_bending(short) + _of_bending(opened)
    return _judge(pairs, factor, rounding / max(float(value) ** 2, 1e-12))


def _ends(model: Model) -> Ends:
    """Return what the scene attaches."""
    return model.stages.run("terminations", lambda: model.scene.ends)


def _wired(model: Model, port: Multiport) -> Multiport:
    return in_series(port) if model.scene.bimorph.wiring == "series" else port


def _static(name: str, model: Model) -> tuple[Array, Array, str]:
    scene = model.scene
    refined = model.static()
    ends = _ends(model).lossless

    def read(port: Multiport) -> Array:
        wired = _wired(model, port)
        if name == "capacitance_blocked":
            return np.asarray(wired["voltage", "voltage"][0].real)
        response = respond(attach(wired, ends), {"voltage": 1.0})
        if name == "capacitance_free":
            return np.asarray(response.effort["voltage"][0].real)
        return np.asarray(response.motion["w_tip"][0].real * scene.drive.voltage)

    return _judge(refined, read, round_off(attach(refined.fine, ends))[0])


def _harmonic(name: str, model: Model) -> tuple[Array, Array, str]:
    scene = model.scene
    refined = model.ports()
    ends = _ends(model)
    voltage = scene.drive.voltage
    jw = 2j * np.pi * model.frequencies

    def read(port: Multiport) -> Array:
        wired = _wired(model, port)
        if name == "dynamic_stiffness":
            return wired.stiffness
        attached = attach(wired, ends)
        if name == "blocked_force":
            return respond(attached, {"voltage": voltage, "w_tip": 0.0}).effort["w_tip"]
        per_volt = name in ("admittance", "threshold_voltage")
        response = respond(attached, {"voltage": 1.0 if per_volt else voltage})
        w_tip, charge = response.motion["w_tip"], response.effort["voltage"]
        if name == "threshold_voltage":
            size = np.abs(w_tip)  # no voltage moves a tip that does not respond
            size = np.where(size > 0.0, size, np.nan)
            return np.asarray(DISPLAY_THRESHOLD.at(port.frequencies) / size)
        return np.asarray(
            {
                "tip_displacement": w_tip,
                "tip_velocity": jw * w_tip,
                "tip_rotation": response.motion["psi_tip"],
                "input_current": jw * charge,
                "admittance": jw * charge,
            }[name]
        )

    rounding: Any = round_off(attach(refined.fine, ends))
    if name == "dynamic_stiffness":
        rounding = rounding[:, None, None]
    return _judge(refined, read, rounding)


def as_json(solution: Solution) -> dict[str, Any]:
    """Return the solution as plain JSON values; see quantity_json."""
    return {
        "scene": solution.scene.name,
        "quantities": [quantity_json(q) for q in solution.quantities],
        "plan": plan_json(solution.plan),
        "warnings": list(solution.warnings),
    }


def plan_json(plan: Plan) -> dict[str, Any]:
    """Return a plan as plain JSON values."""

    def entry(step: Step) -> dict[str, str]:
        return {"stage": step.stage, "reason": step.reason, "key": step.key}

    return {
        "run": [entry(step) for step in plan.run],
        "skipped": [{"stage": s.stage, "reason": s.reason} for s in plan.skipped],
    }
