"""Inputs of stages: scene keys read, result keys, keys without effect.

All of it follows from the entries of :mod:`validation.catalogue.models`.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterable, Iterator, Mapping
from functools import lru_cache
from typing import Any

from tactgen.geometry.device.ceramic_constants import tabulated
from tactgen.geometry.device.load_table import load_table
from tactgen.geometry.device.steel_table import magnetisation_curve
from tactgen.geometry.device.support_table import support_table
from tactgen.validation.catalogue.detection import threshold_of
from tactgen.validation.catalogue.models import (
    CONDITIONS,
    HELD,
    HELD_WITH_CURRENT,
    MODELS,
    PROFILED,
    SETTINGS,
    gives,
    models_of,
    reading,
    stage_reads,
)
from tactgen.validation.catalogue.quantities import QUANTITIES
from tactgen.validation.scene.scene import (
    ON_COMMAND_LINE,
    Scene,
    declaration,
    is_scene_key,
    no_solid,
    read_as,
    scene_keys,
    unusual_values,
)
from tactgen.validation.scene.tolerances import unit_of
from tactgen.validation.scene.variation import value_of

#: Keys that say whose scene it is and what is asked of it.
_ASKED = ("name", "description", "start_from", "models", "quantities")
#: Relative distance of two values that may be one, rounded.
_AS_PRINTED = 0.02
#: Before a key in a condition that it is not stated, and before a group of a layer's constants.
_NOT, _LAYER = "no ", "layer of "


@lru_cache
def _leaves(path: str) -> tuple[str, ...]:
    """Scene keys that a key or group stands for."""
    return tuple(key for key in scene_keys() if key == path or key.startswith(f"{path}."))


def _holds(scene: Scene, condition: str) -> bool:
    """Whether a condition of an entry holds."""
    if condition.startswith(_NOT):
        return not value_of(scene, condition.removeprefix(_NOT))
    if condition.startswith(_LAYER):
        return condition.removeprefix(_LAYER) in scene.bimorph.own_materials
    key, unequal, value = condition.partition("!=")
    if not unequal:
        key, _, value = condition.partition("=")
    found = value_of(scene, key)
    if not value:
        return bool(found)
    return (str(found) == value) is not bool(unequal)


def _profile(scene: Scene, key: str) -> str:
    """Key of the profile that gives a dimension of the ceramic instead, if one does."""
    profile = f"{key}_profile"
    if profile.removeprefix("bimorph.") not in scene.bimorph.profiles:
        return ""
    return "" if key != "bimorph.piezo_thickness" and _bare_shim(scene) else profile


def _bare_shim(scene: Scene) -> str:
    """Key of a length of bare shim, which has the width and the shim that no profile gives."""
    lengths = ("bimorph.tab_length", "bimorph.tip_extension")
    return next((key for key in lengths if value_of(scene, key)), "")


def _width_of_bare_shim(scene: Scene, origins: Mapping[str, str]) -> Iterator[str]:
    """Yield what the bare shim is like beside a profile if the scene does not say so."""
    bare = _bare_shim(scene)
    for key in ("bimorph.width", "bimorph.shim_thickness"):
        profile = f"{key}_profile"
        if (
            bare
            and key not in origins
            and profile.removeprefix("bimorph.") in scene.bimorph.profiles
        ):
            yield (
                f"{key} = {_text(scene, key)} is that of the bare shim ({bare}), and not stated "
                f"beside {profile}; set {key}"
            )


def _stated_twice(scene: Scene, origins: Mapping[str, str]) -> Iterator[str]:
    """Yield which of the ceramic's stated constants do not hold beside its single keys."""
    constants = scene.piezo.constants
    single = [key for key in ("s11", "s55", "d31", "eps33") if f"piezo.{key}" in origins]
    if not (constants and single):
        return
    names = " and ".join(f"piezo.{key}" for key in single)
    found = tabulated(scene.piezo.ceramic(), [constant.name for constant in constants])
    for stated, own in zip(constants, found, strict=True):
        if abs(own.value - stated.value) > _AS_PRINTED * abs(stated.value):
            yield f"piezo.constants has {stated}, and with {names} it is {own}; leave one out"


def _own_keys(scene: Scene, entries: Iterable[str]) -> dict[str, None]:
    """Keys that entries name and whose conditions hold, in order."""
    found: dict[str, None] = {}
    holds: dict[str, bool] = {"": True}
    for entry in entries:
        path, _, own = entry.partition(" if ")
        for key in _leaves(path):
            conditions = own, CONDITIONS.get(key, ""), CONDITIONS.get(key.partition(".")[0], "")
            for condition in conditions:
                if condition not in holds:
                    holds[condition] = _holds(scene, condition)
                if not holds[condition]:
                    break
            else:
                if key not in PROFILED or not _profile(scene, key):
                    found[key] = None
    return found


def keys_read(scene: Scene, entries: Iterable[str]) -> frozenset[str]:
    """All keys that a scene's entries read, those of a contact and of a map included."""
    return _keys_read(scene, tuple(entries))


@lru_cache(maxsize=128)  # a report asks it for each of its keys, models and quantities
def _keys_read(scene: Scene, entries: tuple[str, ...]) -> frozenset[str]:
    keys = set(_own_keys(scene, entries))
    if "support" in entries and scene.support.kind == "contact":
        keys |= keys_read(scene, HELD_WITH_CURRENT if scene.coil.current else HELD)
    if "models" in entries:
        keys |= keys_read(scene, stage_reads()[f"{scene.map_model}.map"])
    return frozenset(keys.difference(_ASKED))


def values_read(scene: Scene, entries: Iterable[str]) -> dict[str, Any]:
    """Values that entries read, as plain values that a hash can be made of."""
    return _values(scene, scene.model_dump(mode="json"), tuple(entries))


def _values(scene: Scene, dump: dict[str, Any], entries: tuple[str, ...]) -> dict[str, Any]:
    values: dict[str, Any] = {}
    for key in _own_keys(scene, entries):
        group, _, name = key.rpartition(".")
        values[key] = dump[group][name] if group else dump[key]
    # of a file counts what is in it
    if "steel.curve" in values:
        curve = magnetisation_curve(scene.steel)
        content = [curve.flux_density.tolist(), curve.field.tolist(), curve.slope_beyond]
        values["steel.curve"] = content
    if "load.file" in values:
        table = load_table(scene.load)
        impedance = [table.impedance.real.tolist(), table.impedance.imag.tolist()]
        values["load.file"] = [table.frequencies.tolist(), *impedance]
    if "support.file" in values:
        held = support_table(scene.support)
        both = [held.rotational] if held.lateral is None else [held.rotational, held.lateral]
        parts = [part.tolist() for of in both for part in (of.real, of.imag)]
        values["support.file"] = [held.frequencies.tolist(), *parts]
    if "threshold.file" in values:
        points = threshold_of(scene.threshold).points
        values["threshold.file"] = [[point.frequency, point.amplitude] for point in points]
    if scene.piezo.grows and "piezo.d31" in values:
        values["field"] = scene.field
    if "models" in entries:  # what counts is whose map pulls at the rod, and that map's inputs
        stage = f"{scene.map_model}.map"
        values["models"] = [stage, _values(scene, dump, stage_reads()[stage])]
    if "support" in entries and scene.support.kind == "contact":
        # what counts is how its load holds the base; a field's map is not solved to say that
        by_field = scene.coil.current and MODELS[scene.map_model].theory == "field"
        values["support"] = (
            _values(scene, dump, HELD_WITH_CURRENT) if by_field
            else scene.held.model_dump(mode="json")
        )  # fmt: skip
        if scene.contact.board_stiffness:
            values["board"] = dump["contact"]
        if scene.spring.tilts_both_planes:
            values["planes"] = _values(scene, dump, (*HELD_WITH_CURRENT, "beam"))
    return values


def stage_keys(names: Iterable[str], scene: Scene) -> dict[str, str]:
    """Keys of stages by name: hashes of the scene values that they read."""
    dump, entries = scene.model_dump(mode="json"), stage_reads()
    digests: dict[tuple[str, ...], str] = {}
    for name in names:
        if entries[name] not in digests:
            values = _values(scene, dump, entries[name])
            digests[entries[name]] = json.dumps(values, sort_keys=True)
    return {
        name: hashlib.sha256(f"{name} {digests[entries[name]]}".encode()).hexdigest()[:16]
        for name in names
    }


def stage_key(name: str, scene: Scene) -> str:
    """Key of one stage."""
    return stage_keys((name,), scene)[name]


# ---- keys without effect ----


def scene_warnings(
    scene: Scene, origins: Mapping[str, str], *, report: bool = False
) -> tuple[str, ...]:
    """One sentence for each key that was set but has no effect.

    Parameters
    ----------
    origins : mapping of str to str
        Where each key was set.
    report : bool
        Whether all is shown that the models know, not the scene's quantities only.
    """
    found = []
    for key, origin in origins.items():
        if report and key.startswith("coil.") and set(scene.models) & set(models_of("reluctance")):
            continue  # a report shows the coil's resistance and heat
        quantities = _sensible(scene, key) if report else scene.quantities
        # a file may describe both actuators, whichever is asked about today
        found.append(_idle(scene, key, quantities, asked=origin == ON_COMMAND_LINE))
    stated = [key for key in origins if is_scene_key(key)]
    found += [*unusual_values(scene, stated), no_solid(scene)]
    found += [*_width_of_bare_shim(scene, origins), *_stated_twice(scene, origins)]
    load = scene.load
    if load.kind == "mass" and load.mass == 0.0:
        found.append('load.kind = "mass" with load.mass = 0 mg is a free tip; set load.mass')
    if load.kind == "spring_damper" and load.stiffness == load.damping == 0.0:
        both = "load.stiffness = 0 N/m and load.damping = 0 N*s/m"
        found.append(f'load.kind = "spring_damper" with {both} is a free tip; set one of them')
    return tuple(filter(None, found))


def idle(scene: Scene, key: str) -> str:
    """Reason why a key has no effect on a scene's request, or ""."""
    return _idle(scene, key, scene.quantities, asked=True)


def _idle(scene: Scene, key: str, quantities: tuple[str, ...], *, asked: bool) -> str:
    """The same of some quantities; unless `asked` only if the scene itself makes it idle."""
    stated, key = key, read_as(key)
    if key in _ASKED or key in keys_read(scene, _entries(scene.models, quantities)):
        return ""
    sensible = _sensible(scene, key)
    profile = _profile(scene, key) if key in PROFILED else ""
    because = _unmet(scene, key, scene.models, sensible)
    if profile:
        because = f"with {profile}, which gives it along the ceramic; remove one of the two"
    if asked and not because:
        because = _use(scene, key, sensible) or _unmet(scene, key, tuple(MODELS), sensible)
        because = because or "on any quantity; tactgen report shows the coil's resistance and heat"
    return because and f"{stated} = {_text(scene, stated)} has no effect {because}"


def _use(scene: Scene, key: str, quantities: tuple[str, ...]) -> str:
    """Quantity, or else model, to ask for so that a key is read; "" if there is none."""
    for name in quantities:
        if key in keys_read(scene, _entries(scene.models, (name,))):
            return f"with quantities = {', '.join(scene.quantities)}; ask for {name} to use it"
    able = [m for m in MODELS if key in keys_read(scene, _entries((m,), quantities))]
    model = next((m for m in able if not MODELS[m].shortcut), "")
    return model and f"with models = {', '.join(scene.models)}; use it with --set models={model}"


def _sensible(scene: Scene, key: str) -> tuple[str, ...]:
    """Quantities that a scene can be asked for: of machines where one stands."""
    machine = scene.support.kind == "contact" or key.partition(".")[0] in ("display", "skin")
    own = ("bimorph", "reluctance")
    return tuple(name for name, row in QUANTITIES.items() if machine or row.actuator in own)


@lru_cache(maxsize=1024)
def _entries(models: tuple[str, ...], quantities: tuple[str, ...]) -> tuple[str, ...]:
    """Entries of all that models read for quantities, in order."""
    found = dict[str, None]()
    for model in models:
        row, given = MODELS[model], [name for name in quantities if gives(model, name)]
        found |= dict.fromkeys(SETTINGS.get(model, ()))
        if given:
            found |= dict.fromkeys(entry for entry in reading(model) if entry != "accuracy")
        for name in given:
            for stage in row.stages_for(QUANTITIES[name]):
                found |= dict.fromkeys(row.stages[stage.partition(".")[2]])
    return tuple(found)


def _unmet(scene: Scene, key: str, models: tuple[str, ...], quantities: tuple[str, ...]) -> str:
    """Condition without which a key counts for none of the models, in words."""
    conditions = [CONDITIONS.get(key), CONDITIONS.get(key.partition(".")[0])]
    if key.partition(".")[0] in ("contact", "guide") or key.startswith("spring.eccentricity"):
        conditions.append("support.kind=contact")
    conditions += [
        condition
        for path, _, condition in (e.partition(" if ") for e in _entries(models, quantities))
        if condition and key in _leaves(path)
    ]
    unmet = (c for c in conditions if c and not _holds(scene, c))
    return next((_remedy(scene, condition) for condition in unmet), "")


def _remedy(scene: Scene, condition: str) -> str:
    """Words for a condition that does not hold."""
    if condition.startswith(_NOT):
        key = condition.removeprefix(_NOT)
        return f"with {key}; leave {key} out to use it"
    if condition.startswith(_LAYER):
        group = condition.removeprefix(_LAYER)
        if group == "glue" and not scene.bimorph.layers:
            return "without glue between the layers; set bimorph.glue_thickness to use it"
        return f"without a {condition}; name {group} in bimorph.layers to use it"
    key, unequal, value = condition.partition("!=")
    if unequal:
        return f'with {key} = "{value}"; set another {key} to use it'
    key, _, value = condition.partition("=")
    text = _text(scene, key)
    if not value:
        return f"with {key} = {text}; set {key} to use it"
    if value.isdecimal():
        return f"with {key} = {text}; leave {key} out to use it"
    return f'with {key} = "{text}"; set {key} = "{value}" to use it'


def _text(scene: Scene, key: str) -> str:
    value, unit = value_of(scene, key), unit_of(declaration(key))
    if isinstance(value, tuple):
        return f"{len(value)} value{'s' if len(value) > 1 else ''}"
    return unit.show(value) if unit and value is not None else str(value)
