"""Sensitivities of a scene's quantities to its keys, by any model, each with an error.

By the transfer-matrix model from exact derivatives; by others as `engine.derivatives` gives them.
Complex quantities by their magnitude.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from tactgen.geometry.device.profile import Profile
from tactgen.geometry.errors import InputError
from tactgen.geometry.formats import engineering
from tactgen.geometry.names import nearest
from tactgen.geometry.units import SI, quoted
from tactgen.tmm.beam import sensitivities as tmm
from tactgen.tmm.beam.parametric import Actuator, check_keys, parameter_keys
from tactgen.tmm.ports.readout import ModalReadout, Readout
from tactgen.validation.catalogue.detection import threshold_of
from tactgen.validation.catalogue.models import MODELS, gives, reading
from tactgen.validation.catalogue.quantities import QUANTITIES, QuantityRow
from tactgen.validation.engine.derivatives import NEAREST, Changed, derivatives
from tactgen.validation.engine.solve import check_models, check_request
from tactgen.validation.engine.warnings import check_held
from tactgen.validation.scene.files import assign
from tactgen.validation.scene.inputs import idle, keys_read
from tactgen.validation.scene.scene import Scene, checked_scene, scene_keys, scene_values
from tactgen.validation.scene.variation import SYMBOLS, value_of
from tactgen.validation.studies.length_map import actuator

#: Groups that no one-dimensional model of the lateral actuator reads, and those that say what the
#: springs of a contact are.
_ELSEWHERE = ("coil", "sleeve", "spring", "steel", "mesh", "limits")
_CONTACT = ("contact", "guide")
#: Groups and keys that say how a model is solved or compared, not what the device is.
_NUMERICAL = ("mesh", "accuracy", "modes", "frequency", "limits", "beam")
#: Columns that a table for people has at most, if a quantity's frequencies can be thinned.
_SHOWN = 8
#: Relative error of the transfer-matrix model's derivatives, of the largest of a column:
#: rounding where an entry of the ports' matrix is next to a pole or zero.
_EXACT = 2e-9
_METHOD = "exact derivatives by Cauchy's integral; the bar is the rounding next to a pole"


@dataclass(frozen=True)
class SensitivityColumn:
    """One number with its derivatives; complex quantities by their magnitude.

    Attributes
    ----------
    logarithmic, bars : dict of str to float
        d ln q / d ln p by scene key, and its error.
    """

    quantity: str
    unit: str
    frequency: float | None  #: In Hz, for quantities that depend on it
    value: float
    derivatives: dict[str, float]  #: dq/dp in SI units by scene key
    logarithmic: dict[str, float]
    model: str
    bars: dict[str, float]
    method: str  #: How derivatives and errors come about

    @property
    def label(self) -> str:
        """Heading for people, a word per line."""
        name = self.quantity.replace("_", "\n")
        if self.frequency is not None:
            return f"{name}\n{self.frequency:g} Hz"
        return name.replace("frequencies", "frequency 1")

    @property
    def text(self) -> str:
        """The value with its unit."""
        return engineering(self.value, self.unit)


def changed_scenes(name: str, overrides: Sequence[str]) -> Changed:
    """Function that gives a command line's scene with another value (SI) at one key."""

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
    """Sensitivities by all models of a scene, and the keys left out.

    Parameters
    ----------
    changed : callable
        See :func:`changed_scenes`.
    keys : sequence of str, optional
        Scene keys; by default all numbers that a model reads for these quantities.

    Raises InputError for a quantity or key without derivative, a number that is zero, or a model
    that gives none of the quantities.
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
        rest = [name for name in given if name not in exact]
        if rest:
            by_model, sentence = _model_columns(scene, changed, model, rest, keys, announce)
            columns += by_model
            omitted.append(sentence)
    return columns, omitted


def _by_tmm(scene: Scene, name: str) -> bool:
    """Whether the transfer-matrix model's exact derivatives, or their refusal, serve.

    They know a contact as the springs that it is at rest, and not what these are made of.
    """
    row = QUANTITIES[name]
    return (_differentiable(row) and scene.support.kind != "contact") or row.unit == "SI"


def _differentiable(row: QuantityRow) -> bool:
    return isinstance(row.read, Readout | ModalReadout)


def sensitivity_columns(scene: Scene, keys: Sequence[str] | None = None) -> list[SensitivityColumn]:
    """Scene's quantities by the transfer-matrix model, a column for each frequency.

    The threshold voltage has columns only where the threshold is stated.

    Raises InputError as :func:`all_columns`.
    """
    threshold = threshold_of(scene.threshold)
    rows = [QUANTITIES[name].at_threshold(threshold) for name in scene.quantities]
    for row in rows:
        if not _differentiable(row):
            able = ", ".join(name for name, other in QUANTITIES.items() if _differentiable(other))
            raise InputError(
                f"quantity {row.name} is a matrix and has no sensitivities here; use one of {able}"
            )
    check_held(scene, scene.quantities)
    device = actuator(scene)
    chosen = list(parameter_keys(device) if keys is None else dict.fromkeys(keys))
    for key in chosen if keys is not None else ():
        _check_key(key, _refusal(scene, key, device=device))
    return [column for row in rows for column in _tmm_columns(scene, device, row, chosen)]


def _tmm_columns(
    scene: Scene, device: Actuator, row: QuantityRow, keys: Sequence[str]
) -> list[SensitivityColumn]:
    if row.has_level and scene.piezo.d31 == 0.0:
        raise InputError(
            f"{row.name} has no value with piezo.d31 = 0, for no voltage moves the tip; give "
            "piezo.d31 a value"
        )
    assert isinstance(row.read, Readout | ModalReadout)
    at = np.asarray(scene.frequency) if row.by_frequency else None
    value = tmm.values(device, row.read, at)
    if (value == 0.0).any():
        raise InputError(
            f"{row.name} is 0 in this scene, so no parameter changes it in relation to its "
            "size; give drive.voltage and piezo.d31 a value, or ask at another frequency"
        )
    slopes = tmm.derivatives(device, row.read, keys, at)
    columns = []
    for i in np.flatnonzero(np.isfinite(value)):
        f = None if at is None else float(at[i])
        by_key = {key: s[i] for key, s in slopes.items()}
        column = _column(scene, row, "tmm", f, value[i], by_key, {}, _METHOD)
        error = _EXACT * max(map(abs, column.logarithmic.values()), default=0.0)
        column.bars.update(dict.fromkeys(by_key, error))
        columns.append(column)
    return columns


def _model_columns(
    scene: Scene,
    changed: Changed,
    model: str,
    names: Sequence[str],
    keys: Sequence[str] | None,
    announce: Callable[[str], None],
) -> tuple[list[SensitivityColumn], str]:
    """Sensitivities by a model, and the keys left out."""
    for name in names:
        if QUANTITIES[name].unit == "SI":
            raise InputError(f"quantity {name} is a matrix and has no sensitivities here; ask for "
                             "what is read off it, such as tip_displacement")  # fmt: skip
    alone = scene.model_copy(update={"models": (model,), "quantities": tuple(names)})
    check_request(alone, (model,), names)
    chosen, omitted = readable_keys(alone, changed, model, keys)
    columns = []
    for result in derivatives(alone, changed, model, names, chosen, announce):
        q = result.quantity
        values = np.atleast_1d(q.value)
        # of lists other than over frequency the first value
        for i in range(values.size if q.frequency is not None else min(values.size, 1)):
            if not np.isfinite(values[i]):
                continue
            if values[i] == 0.0:
                raise InputError(
                    f"{q.name} is 0 by {q.model} in this scene, so no parameter changes it in "
                    "relation to its size; choose another point, or another quantity"
                )
            f = None if q.frequency is None else float(q.frequency[i])
            slopes, bars = (
                {key: np.atleast_1d(s)[i] for key, s in by_key.items()}
                for by_key in (result.slopes, result.bars)
            )
            row = QUANTITIES[q.name]
            columns.append(_column(alone, row, model, f, values[i], slopes, bars, result.method))
    return columns, omitted


def _column(
    scene: Scene,
    row: QuantityRow,
    model: str,
    frequency: float | None,
    value: Any,
    slopes: Mapping[str, Any],
    bars: Mapping[str, Any],
    method: str,
) -> SensitivityColumn:
    """One number of a quantity, by its magnitude, with derivatives (SI) and their errors by key."""
    size = float(abs(value))
    real = {key: float((np.conj(value) * slope).real / size) for key, slope in slopes.items()}
    scales = {key: float(value_of(scene, key)) / size for key in slopes}
    return SensitivityColumn(
        quantity=row.name,
        unit=row.unit,
        frequency=frequency,
        value=size,
        derivatives=real,
        logarithmic={key: slope * scales[key] for key, slope in real.items()},
        model=model,
        bars={key: float(bar) * abs(scales[key]) for key, bar in bars.items()},
        method=method,
    )


def readable_keys(
    scene: Scene, changed: Changed, model: str, keys: Sequence[str] | None = None
) -> tuple[list[str], str]:
    """Keys that a model reads, or those given, and in words which cannot be varied.

    Raises InputError for a given key that cannot be varied.
    """
    if keys is not None:
        chosen = list(dict.fromkeys(keys))
        for key in chosen:
            reason = _refusal(scene, key, model=model)
            if not reason and (misfit := _misfit(scene, changed, key)):
                reason = f"cannot be varied: {misfit}; leave the key out"
            _check_key(key, reason)
        return chosen, ""
    able = [key for key in scene_keys() if not _refusal(scene, key, model=model)]
    stuck = [key for key in able if _misfit(scene, changed, key)]
    sentence = (
        f"left out of the parameters by {model}, since next to their values the parts do not fit "
        f"together: {', '.join(stuck)}"
    )
    return [key for key in able if key not in stuck], sentence if stuck else ""


def _check_key(key: str, reason: str) -> None:
    if reason:
        raise InputError(f"--key {quoted(key)} {reason}")


def _refusal(scene: Scene, key: str, *, model: str = "tmm", device: Actuator | None = None) -> str:
    """Reason why a key has no sensitivity, and the remedy, or ""."""
    out = "leave the key out"
    known = key in scene_keys()
    if device and known and ("." not in key or key.partition(".")[0] in _ELSEWHERE):
        return f"is no parameter of the transfer-matrix model; {out}"
    if not known:
        symbol = f' (did you mean "{SYMBOLS[key]}"?)' if key in SYMBOLS else ""
        close = symbol or nearest(key, scene_keys())
        return f"is not a scene key{close}; tactgen init FILE.toml writes a scene with every key"
    value = value_of(scene, key)
    if isinstance(value, Profile):
        return f"is a profile, whose points are not varied; {out}, or compare two tactgen solve"
    if isinstance(value, int):
        return f"is a whole number, which is not varied; {out}"
    if value is None:
        return f"has no value of its own in this scene, but follows from others; {out}"
    if not isinstance(value, float):
        return f"is a choice, not a number, and has no sensitivity; {out}"
    if idle(scene, key):
        return "has no sensitivity: " + idle(scene, key)
    if not device and (key.partition(".")[0] in _NUMERICAL or not _reads(scene, model, key)):
        return f"is not read by the model {model} for these quantities; {out}"
    if value == 0.0:
        return f"is 0, and there is no percentage of 0; set another value, or {out}"
    if device and (kink := tmm_kink(scene, device, key)):
        return f"cannot be varied: {kink}; {out}"
    if device and key not in parameter_keys(device):
        return (
            f'is not read by the transfer-matrix model with support.kind = "{scene.support.kind}" '
            f'and load.kind = "{scene.load.kind}"; {out}'
        )
    return ""


def _reads(scene: Scene, model: str, key: str) -> bool:
    """Whether a stage that the quantities need reads a key, or the reading of them."""
    row = MODELS[model]
    stages = {s for name in scene.quantities for s in row.stages_for(QUANTITIES[name])}
    entries = [entry for stage in stages for entry in row.stages[stage.partition(".")[2]]]
    return key in keys_read(scene, [*entries, *reading(model)])


def _misfit(scene: Scene, changed: Changed, key: str) -> str:
    """Reason why a neighbouring scene makes no device, or ""."""
    value = float(value_of(scene, key))
    try:
        for share in (NEAREST, -NEAREST):
            changed(key, value * (1.0 + share))
    except InputError as error:
        return f"next to its value {error}"
    return ""


def tmm_kink(scene: Scene, device: Actuator, key: str) -> str:
    """Reason why the transfer-matrix model is not smooth in a number, or ""."""
    try:
        check_keys(device, [key])
    except InputError:
        profiles = [f"bimorph.{name}" for name in scene.bimorph.profiles]
        if key == "bimorph.length" and profiles:
            return f"{' and '.join(profiles)} would not end at the ceramic's edge any more"
        return "a piece of the row of beams appears or vanishes at its value"
    return ""


def left_out(scene: Scene) -> str:
    """Parameters without exact sensitivity by tmm, with reasons; "" if none."""
    device = actuator(scene)
    reasons: dict[str, list[str]] = {}
    for key in scene_keys():
        group, _, name = key.partition(".")
        if key not in scene.tolerances and (not name or group in _ELSEWHERE):
            continue
        reason = _omission(scene, device, key)
        if not reason and key in scene.tolerances and key not in parameter_keys(device):
            reason = "has a tolerance, but is not read here"
        if reason:
            reasons.setdefault(reason, []).append(key)
    listed = "; ".join(f"{', '.join(keys)} ({reason})" for reason, keys in reasons.items())
    return f"left out of the parameters: {listed}" if listed else ""


def _omission(scene: Scene, device: Actuator, key: str) -> str:
    group, _, name = key.partition(".")
    value, profile = value_of(scene, key), f"{name}_profile"
    if group == "bimorph" and profile in scene.bimorph.profiles and idle(scene, key):
        return f"bimorph.{profile} gives it"
    if isinstance(value, Profile) and value:
        return "its points are not varied"
    if not isinstance(value, float) or not value or idle(scene, key):
        return ""
    if group in _CONTACT and scene.support.kind == "contact":
        return "the contact is held as the springs that it is at rest; tactgen whatif varies it"
    return tmm_kink(scene, device, key)


def thinned(columns: Sequence[SensitivityColumn]) -> list[SensitivityColumn]:
    """As many columns as people can read: of each quantity a few of its frequencies."""
    if len(columns) <= _SHOWN:
        return list(columns)
    names = dict.fromkeys(c.quantity for c in columns)
    groups = [[c for c in columns if c.quantity == name] for name in names]
    single = sum(len(group) == 1 for group in groups)
    each = max(1, (_SHOWN - single) // max(1, len(groups) - single))
    return [
        group[i]
        for group in groups
        for i in np.unique(np.linspace(0, len(group) - 1, min(len(group), each)).astype(int))
    ]
