"""Sensitivities of a scene's quantities by any model, each with an error bar."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from tactgen.geometry.errors import InputError
from tactgen.geometry.units import quoted
from tactgen.validation.catalogue.models import MODELS, gives, reading
from tactgen.validation.catalogue.quantities import QUANTITIES
from tactgen.validation.engine.derivatives import NEAREST, Changed, Derivatives, derivatives
from tactgen.validation.engine.inputs import idle, keys_read
from tactgen.validation.engine.plan import check_models
from tactgen.validation.engine.solve import check_request
from tactgen.validation.scene.files import assign
from tactgen.validation.scene.keys import value_of
from tactgen.validation.scene.scene import Scene, checked_scene, scene_keys, scene_values
from tactgen.validation.studies.uncertainty.table import (
    SensitivityColumn,
    is_differentiable,
    sensitivity_columns,
)
from tactgen.validation.studies.uncertainty.varied_keys import not_a_number

#: Groups and keys that say how a model is solved or judged, not what the device is.
_NUMERICAL = ("mesh", "accuracy", "modes", "frequency", "limits", "beam")
#: Where a key is tried before it is varied: the differences reach this far at least.
_TRIED = (NEAREST, -NEAREST)


def changed_scenes(name: str, overrides: Sequence[str]) -> Changed:
    """Return what gives the scene of a command line with another value (SI) at one key."""
    from tactgen.geometry.units import SI

    def changed(key: str, value: float) -> Scene:
        values, _ = scene_values(name, list(overrides))
        assign(values, key, SI(value))
        return checked_scene(values)

    return changed


def all_columns(
    scene: Scene,
    changed: Changed,
    keys: Sequence[str] | None = None,
    announce: Callable[[str], None] = lambda _: None,
) -> tuple[list[SensitivityColumn], list[str]]:
    """Return the scene's quantities by all of its models, and what each leaves out of the keys.

    Raises
    ------
    InputError
        As :func:`model_columns`; for a model that gives none of the quantities.
    """
    check_models(scene.models, scene.quantities)
    columns: list[SensitivityColumn] = []
    omitted: list[str] = []
    for model in scene.models:
        given = [name for name in scene.quantities if gives(model, name)]
        if not given:
            raise InputError(
                f"model {model} gives none of {', '.join(scene.quantities)}; leave it out, or add "
                "a --quantity that it gives"
            )
        exact = [name for name in given if model == "tmm" and _by_tmm(scene, name)]
        if exact:
            own = scene.model_copy(update={"quantities": tuple(exact)})
            columns += sensitivity_columns(own, keys)
        rest = tuple(name for name in given if name not in exact)
        if rest:
            own = scene.model_copy(update={"quantities": rest})
            found, sentence = model_columns(own, changed, model, keys, announce)
            columns += found
            omitted.append(sentence)
    return columns, omitted


def _by_tmm(scene: Scene, name: str) -> bool:
    """Return whether the transfer-matrix model's exact derivatives, or their refusal, serve.

    They know a contact as the springs that it is at rest, and not what these are made of.
    """
    row = QUANTITIES[name]
    return (is_differentiable(row) and scene.support.kind != "contact") or row.unit == "SI"


def model_columns(
    scene: Scene,
    changed: Changed,
    model: str,
    keys: Sequence[str] | None = None,
    announce: Callable[[str], None] = lambda _: None,
) -> tuple[list[SensitivityColumn], str]:
    """Return the scene's quantities by a model with their derivatives, and what is left out.

    Parameters
    ----------
    changed : callable
        See :func:`changed_scenes`.
    keys : sequence of str, optional
        Scene keys; by default all numbers that the model reads for these quantities.

    Raises
    ------
    InputError
        For a quantity or key without derivative, or a number that is zero.
    """
    names = [name for name in scene.quantities if gives(model, name)]
    for name in names:
        if QUANTITIES[name].unit == "SI":
            raise InputError(f"quantity {name} is a matrix and has no sensitivities here; ask for "
                             "what is read off it, such as tip_displacement")  # fmt: skip
    alone = scene.model_copy(update={"models": (model,), "quantities": tuple(names)})
    check_request(alone, (model,), names)
    if keys is None:
        chosen, omitted = _read_keys(alone, changed, model)
    else:
        chosen, omitted = _asked_keys(alone, changed, model, keys), ""
    found = derivatives(alone, changed, model, names, chosen, announce)
    return [column for each in found for column in _columns(alone, each)], omitted


def _read_keys(scene: Scene, changed: Changed, model: str) -> tuple[list[str], str]:
    """Return the keys that a model reads, and in words which of them cannot be varied."""
    able = [key for key in scene_keys() if not _refusal(scene, model, key)]
    stuck = [key for key in able if _kink(scene, changed, key)]
    chosen = [key for key in able if key not in stuck]
    if not stuck:
        return chosen, ""
    return chosen, (
        f"left out of the parameters by {model}, since next to their values the parts do not fit "
        f"together: {', '.join(stuck)}"
    )


def _asked_keys(scene: Scene, changed: Changed, model: str, keys: Sequence[str]) -> list[str]:
    chosen = list(dict.fromkeys(keys))
    for key in chosen:
        reason = _refusal(scene, model, key)
        if not reason and (kink := _kink(scene, changed, key)):
            reason = f"cannot be varied: {kink}; leave the key out"
        if reason:
            raise InputError(f"--key {quoted(key)} {reason}")
    return chosen


def _refusal(scene: Scene, model: str, key: str) -> str:
    """Return why a key has no sensitivity by a model, and the remedy, or nothing."""
    reason = not_a_number(scene, key)
    if reason:
        return reason
    if idle(scene, key):
        return "has no sensitivity: " + idle(scene, key)
    if key.partition(".")[0] in _NUMERICAL or not _reads(scene, model, key):
        return f"is not read by the model {model} for these quantities; leave the key out"
    if value_of(scene, key) == 0.0:
        return "is 0, and there is no percentage of 0; set another value, or leave the key out"
    return ""


def _reads(scene: Scene, model: str, key: str) -> bool:
    """Return whether a stage that the quantities need reads a key, or the reading of them."""
    row = MODELS[model]
    stages = {s for name in scene.quantities for s in row.stages_for(QUANTITIES[name])}
    entries = [entry for stage in stages for entry in row.stages[stage.partition(".")[2]]]
    return key in keys_read(scene, [*entries, *reading(model)])


def _kink(scene: Scene, changed: Changed, key: str) -> str:
    """Return why a scene next to this one makes no device, or nothing."""
    value = float(value_of(scene, key))
    try:
        for share in _TRIED:
            changed(key, value * (1.0 + share))
    except InputError as error:
        return f"next to its value {error}"
    return ""


def _columns(scene: Scene, found: Derivatives) -> list[SensitivityColumn]:
    """Return a column for each frequency, of other lists for the first value."""
    q = found.quantity
    size = np.abs(np.atleast_1d(q.value))
    which = range(size.size) if q.frequency is not None else range(1)
    columns = []
    for i in which:
        if size.size <= i or not np.isfinite(size[i]):
            continue
        if size[i] == 0.0:
            raise InputError(
                f"{q.name} is 0 by {q.model} in this scene, so no parameter changes it in relation "
                "to its size; choose another point, or another quantity"
            )

        def at(values: Any, place: int = i) -> Any:
            return np.atleast_1d(values)[place]

        value = at(q.value)
        slopes = {
            k: float((np.conj(value) * at(s)).real / size[i]) for k, s in found.slopes.items()
        }
        scales = {key: float(value_of(scene, key)) / size[i] for key in slopes}
        bars = {key: float(at(bar)) for key, bar in found.bars.items()}
        columns.append(
            SensitivityColumn(
                quantity=q.name,
                unit=q.unit,
                frequency=None if q.frequency is None else float(q.frequency[i]),
                value=float(size[i]),
                derivatives=slopes,
                logarithmic={key: slope * scales[key] for key, slope in slopes.items()},
                model=q.model,
                bars={key: bar * abs(scales[key]) for key, bar in bars.items()},
                method=found.method,
            )
        )
    return columns
