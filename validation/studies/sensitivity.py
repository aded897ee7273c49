"""Sensitivities of a scene's quantities to its keys, by any model, each with an error.

As `engine.derivatives` gives them; complex quantities by their magnitude.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import groupby

import numpy as np

from tactgen.geometry.device.profile import Profile
from tactgen.geometry.errors import InputError
from tactgen.geometry.formats import engineering
from tactgen.geometry.units import SI, quoted
from tactgen.validation.catalogue.models import MODELS, gives, reading
from tactgen.validation.catalogue.quantities import QUANTITIES, QuantityRow
from tactgen.validation.engine.answers import modelling_at
from tactgen.validation.engine.derivatives import NEAREST, Changed, Derivatives, derivatives, misfit
from tactgen.validation.engine.solve import check_models, check_request
from tactgen.validation.engine.warnings import check_held
from tactgen.validation.scene.inputs import keys_read
from tactgen.validation.scene.keys import check_key, number_keys, read_as
from tactgen.validation.scene.load import scene_values
from tactgen.validation.scene.scene import Scene
from tactgen.validation.scene.variation import ScenesNearby, value_of
from tactgen.validation.scene.warnings import idle

#: Groups and keys that say how a model is solved or compared, not what the device is.
_NUMERICAL = ("mesh", "accuracy", "modes", "frequency", "limits")
#: Columns that a table for people has at most, if a quantity's frequencies can be thinned.
_SHOWN = 8


@dataclass(frozen=True)
class SensitivityColumn:
    """One number with its derivatives; complex quantities by their magnitude."""

    quantity: str
    unit: str
    frequency: float | None  #: In Hz, for quantities that depend on it
    extreme: str  #: "largest", "least" or "at peak" of another, over the band; else empty
    value: float
    derivatives: dict[str, float]  #: dq/dp in SI units by scene key
    #: d ln q / d ln p by scene key, and its error
    logarithmic: dict[str, float]
    bars: dict[str, float]
    model: str
    method: str  #: How derivatives and errors come about
    #: Modelling error of the value, in words and absolute; nan where it is not known
    modelling: str
    modelling_error: float

    @property
    def label(self) -> str:
        """Heading for people, a word per line."""
        name = self.quantity.replace("_", "\n")
        if self.frequency is not None:
            return f"{name}\n{self.extreme} {self.frequency:.4g} Hz".replace("\n ", "\n")
        return name.replace("frequencies", "frequency 1")

    @property
    def text(self) -> str:
        """The value with its unit."""
        return engineering(self.value, self.unit)


def changed_scenes(name: str, overrides: Sequence[str]) -> Changed:
    """Function that gives a command line's scene with another value (SI) at one key."""
    nearby = ScenesNearby(scene_values(name, list(overrides))[0])
    return lambda key, value: nearby.scene({key: SI(value)})


def all_columns(
    scene: Scene,
    changed: Changed,
    keys: Sequence[str] | None = None,
    announce: Callable[[str], None] = lambda _: None,
) -> tuple[list[SensitivityColumn], list[str]]:
    """Sensitivities by all models of a scene, and which keys are left out, in words.

    `changed` is of :func:`changed_scenes`; without `keys` all numbers are taken that a model reads.

    Raises InputError for a quantity or key without derivative, a number that is zero, or a model
    that gives none of the quantities.
    """
    check_models(scene.models, scene.quantities)
    check_held(scene, scene.quantities)
    columns: list[SensitivityColumn] = []
    omitted: list[str] = []
    for model in scene.models:
        names = [name for name in scene.quantities if gives(model, name)]
        if not names:
            raise InputError(
                f"model {model} gives none of {', '.join(scene.quantities)}; remove it, or add "
                "a --quantity that it gives"
            )
        for name in names:
            if QUANTITIES[name].unit == "SI":
                raise InputError(
                    f"quantity {name} is a matrix and has no sensitivities here; ask for what is "
                    "read off it, such as tip_displacement"
                )
        alone = scene.model_copy(update={"models": (model,), "quantities": tuple(names)})
        check_request(alone, (model,), names)
        chosen, sentence = readable_keys(alone, changed, model, keys)
        omitted += [sentence] if sentence else []
        for result in derivatives(alone, changed, model, names, chosen, announce):
            columns += _columns(alone, result)
    return columns, omitted


def _columns(scene: Scene, result: Derivatives) -> list[SensitivityColumn]:
    """One column for each frequency; of other lists the first value."""
    q = result.quantity
    values, peak = np.atleast_1d(q.value), q.extreme if q.frequency is None else None
    at_peak = peak.frequency if peak is not None else None
    if not np.isfinite(values).any():
        raise InputError(
            f"{q.name} has no value by {q.model} in this scene; check piezo.d31, drive.voltage and "
            "the frequencies, or remove it"
        )
    columns = []
    for i in range(values.size if q.frequency is not None else min(values.size, 1)):
        if not np.isfinite(values[i]):
            continue
        value = float(abs(values[i]) if np.iscomplexobj(values) else values[i])
        if value == 0.0:
            raise InputError(
                f"{q.name} is 0 by {q.model} in this scene, so no parameter changes it in "
                "relation to its size; give drive.voltage and piezo.d31 a value, or ask at "
                "another frequency or of another quantity"
            )
        phase = np.conj(values[i]) / value if np.iscomplexobj(values) else 1.0
        here = {key: [np.atleast_1d(of)[i] for of in both] for key, both in result.slopes.items()}
        slopes = {key: float((phase * slope).real) for key, (slope, _) in here.items()}
        scales = {key: float(value_of(scene, key)) / value for key in slopes}
        columns.append(
            SensitivityColumn(
                quantity=q.name,
                unit=QUANTITIES[q.name].unit,
                frequency=float(q.frequency[i]) if q.frequency else at_peak,
                extreme=_extreme(QUANTITIES[q.name]) if peak else "",
                value=value,
                derivatives=slopes,
                logarithmic={key: slope * scales[key] for key, slope in slopes.items()},
                model=q.model,
                bars={key: float(bar) * abs(scales[key]) for key, (_, bar) in here.items()},
                method=result.method,
                modelling=modelling_at(q, i if np.ndim(q.value) else ()),
                modelling_error=float(np.atleast_1d(q.modelling_error)[i]),
            )
        )
    return columns


def _extreme(row: QuantityRow) -> str:
    """What a value over a band is, in a word or two."""
    return "at peak" if row.peak_of else "least" if row.is_limit else "largest"


def readable_keys(
    scene: Scene, changed: Changed, model: str, keys: Sequence[str] | None = None
) -> tuple[list[str], str]:
    """Keys that a model reads, or those given, and in words which cannot be varied.

    Raises InputError for a given key that cannot be varied.
    """

    def unfit(key: str) -> str:
        value = float(value_of(scene, key))
        return misfit(changed, key, value, NEAREST * abs(value))

    if keys is not None:
        for key in keys:
            check_key(key)
            reason = _refusal(scene, key, model)
            if not reason and (error := unfit(key)):
                reason = f"cannot be varied: next to its value {error}; leave the key out"
            if reason:
                raise InputError(f"--key {quoted(key)} {reason}")
        return list(dict.fromkeys(keys)), ""
    able = [key for key in number_keys(scene) if not _refusal(scene, key, model)]
    stuck = [key for key in able if unfit(key)]
    sentence = (
        f"left out of the parameters by {model}, since next to their values the parts do not fit "
        f"together: {', '.join(stuck)}"
    )
    return [key for key in able if key not in stuck], sentence if stuck else ""


def _refusal(scene: Scene, key: str, model: str) -> str:
    """Reason why a key has no sensitivity, and the remedy, or ""."""
    out = "leave the key out"
    value = value_of(scene, key)
    if isinstance(value, Profile):
        return f"is a profile, whose points are not varied; {out}, or compare two tactgen solve"
    if value is None:
        return f"has no value of its own in this scene, but follows from others; {out}"
    if not isinstance(value, float):
        return f"is a choice or a whole number and has no sensitivity; {out}"
    if idle(scene, key):
        return "has no sensitivity: " + idle(scene, key)
    if key.partition(".")[0] in _NUMERICAL or not _reads(scene, model, key):
        return f"is not read by the model {model} for these quantities; {out}"
    if value == 0.0 and read_as(key) != key:
        return "is not stated in bimorph.layers; state it there, or leave the key out"
    if value == 0.0:
        return f"is 0, and there is no percentage of 0; set another value, or {out}"
    return ""


def _reads(scene: Scene, model: str, key: str) -> bool:
    """Whether a stage that the quantities need reads a key, or the reading of them."""
    row = MODELS[model]
    stages = {s for name in scene.quantities for s in row.stages_for(QUANTITIES[name])}
    entries = [entry for stage in stages for entry in row.stages[stage.partition(".")[2]]]
    return read_as(key) in keys_read(scene, [*entries, *reading(model)])


def thinned(columns: Sequence[SensitivityColumn]) -> list[SensitivityColumn]:
    """As many columns as people can read: of each quantity its extreme and a few frequencies."""
    if len(columns) <= _SHOWN:
        return list(columns)
    groups = [list(of) for _, of in groupby(columns, lambda c: (c.quantity, c.model))]
    single = sum(len(group) == 1 for group in groups)
    each = max(1, (_SHOWN - single) // max(1, len(groups) - single))
    return [column for group in groups for column in _a_few(group, each)]


def _a_few(columns: Sequence[SensitivityColumn], count: int) -> list[SensitivityColumn]:
    """So many of one quantity's columns, its extreme last."""
    extreme = [c for c in columns if c.extreme]
    others = [c for c in columns if not c.extreme]
    wanted = min(len(others), count - len(extreme))
    places = np.unique(np.linspace(0, len(others) - 1, wanted).astype(int))
    return [*(others[i] for i in places), *extreme]
