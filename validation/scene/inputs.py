"""Inputs of stages: scene keys read, result keys, keys without effect.

All of it follows from the entries of :mod:`validation.catalogue.models`.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterable, Mapping
from functools import lru_cache
from typing import Any

from tactgen.geometry.device.load_table import load_table
from tactgen.geometry.device.steel_table import magnetisation_curve
from tactgen.geometry.units import Unit
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
from tactgen.validation.scene.scene import ON_COMMAND_LINE, Scene, scene_keys
from tactgen.validation.scene.variation import value_of

#: Keys that say whose scene it is and what is asked of it.
_ASKED = ("name", "description", "models", "quantities")
#: Quantities that a sentence lists.
_LISTED = 4


@lru_cache
def _leaves(path: str) -> tuple[str, ...]:
    """Scene keys that a key or group stands for."""
    return tuple(key for key in scene_keys() if key == path or key.startswith(f"{path}."))


def _holds(scene: Scene, condition: str) -> bool:
    """Whether a condition of an entry holds."""
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
    # the tab below the ceramic has its width and shim
    of_tab = key != "bimorph.piezo_thickness" and scene.bimorph.tab_length > 0.0
    return "" if of_tab else profile


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


def keys_read(scene: Scene, entries: Iterable[str]) -> set[str]:
    """All keys that a scene's entries read, those of a contact and of a map included."""
    entries = tuple(entries)
    keys = set(_own_keys(scene, entries))
    if "support" in entries and scene.support.kind == "contact":
        keys |= keys_read(scene, HELD_WITH_CURRENT if scene.coil.current else HELD)
    if "models" in entries:
        keys |= keys_read(scene, stage_reads()[f"{scene.map_model}.map"])
    return keys - set(_ASKED)


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
    if "threshold.file" in values:
        points = threshold_of(scene.threshold).points
        values["threshold.file"] = [[point.frequency, point.amplitude] for point in points]
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
        Where each key was set; "" for a key that is only asked about.
    report : bool
        Whether all is shown that the models know, not the scene's quantities only.
    """
    wanted = keys_read(scene, _entries(scene.models, scene.quantities))
    found = []
    for key, origin in origins.items():
        if key in wanted or key in _ASKED:
            continue
        # a file may describe both actuators, whichever is asked about today
        asked = origin in (ON_COMMAND_LINE, "")
        because = _idle(scene, key, report=report, asked=asked)
        if because:
            found.append(f"{key} = {_text(scene, key)} has no effect {because}")
    load = scene.load
    if load.kind == "mass" and load.mass == 0.0:
        found.append('load.kind = "mass" with load.mass = 0 mg is a free tip; set load.mass')
    if load.kind == "spring_damper" and load.stiffness == load.damping == 0.0:
        both = "load.stiffness = 0 N/m and load.damping = 0 N*s/m"
        found.append(f'load.kind = "spring_damper" with {both} is a free tip; set one of them')
    # a size that was taken for a value
    if scene.piezo.d31 > 0.0:
        found.append(
            f"piezo.d31 = {_text(scene, 'piezo.d31')} is positive, and that of poled ceramics is "
            "negative; if a data sheet prints its size, write it with a minus"
        )
    for name, part in (("shim", scene.shim), ("rod", scene.rod), ("glue", scene.glue)):
        if part.poisson_ratio < 0.0:
            key = f"{name}.poisson_ratio"
            found.append(f"{key} = {_text(scene, key)} is negative, as hardly any material's is")
    return tuple(found)


def idle(scene: Scene, key: str) -> str:
    """Reason why a key has no effect on a scene's request, or ""."""
    because = _idle(scene, key, report=False, asked=True)
    return f"{key} = {_text(scene, key)} has no effect {because}" if because else ""


def _idle(scene: Scene, key: str, *, report: bool, asked: bool) -> str:
    wanted = _sensible(scene, key) if report else scene.quantities
    if key in _ASKED or key in keys_read(scene, _entries(scene.models, wanted)):
        return ""
    profile = key in PROFILED and _profile(scene, key)
    if profile:
        return f"with {profile}, which gives it along the ceramic; leave one of the two out"
    sensible = _sensible(scene, key)
    unmet = _unmet(scene, key, scene.models, sensible)
    shown = report and key.startswith("coil.") and set(scene.models) & set(models_of("reluctance"))
    if unmet or not asked or shown:
        return unmet
    if key in keys_read(scene, _entries(scene.models, sensible)):
        names = [q for q in sensible if key in keys_read(scene, _of(scene.models, q))]
        listed = ", ".join(names[:_LISTED]) + (", …" if len(names) > _LISTED else "")
        return f"with quantities = {', '.join(scene.quantities)}; ask for {listed} to use it"
    return _by_other_models(scene, key, sensible)


def _sensible(scene: Scene, key: str) -> tuple[str, ...]:
    """Quantities that a scene can be asked for: of machines where one stands."""
    machine = scene.support.kind == "contact" or key.partition(".")[0] in ("display", "skin")
    return tuple(
        name for name, row in QUANTITIES.items()
        if machine or row.actuator in ("bimorph", "reluctance")
    )  # fmt: skip


def _entries(models: Iterable[str], quantities: Iterable[str]) -> tuple[str, ...]:
    """Entries of all that models read for quantities."""
    models, found = tuple(models), dict[str, None]()
    for model in models:
        found |= dict.fromkeys(SETTINGS.get(model, ()))
        if any(gives(model, q) for q in quantities):
            found |= dict.fromkeys(entry for entry in reading(model) if entry != "accuracy")
    for quantity in quantities:
        found |= dict.fromkeys(_of(models, quantity))
    return tuple(found)


def _of(models: Iterable[str], quantity: str) -> list[str]:
    """Entries of the stages that a quantity needs by models that give it."""
    rows = [MODELS[model] for model in models if gives(model, quantity)]
    return [
        entry
        for row in rows
        for stage in row.stages_for(QUANTITIES[quantity])
        for entry in row.stages[stage.partition(".")[2]]
    ]


def _unmet(scene: Scene, key: str, models: Iterable[str], quantities: Iterable[str]) -> str:
    """Condition without which a key counts for none of the models, in words."""
    conditions = [CONDITIONS.get(key), CONDITIONS.get(key.partition(".")[0])]
    if key.partition(".")[0] in ("contact", "guide"):
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


def _by_other_models(scene: Scene, key: str, quantities: tuple[str, ...]) -> str:
    """Models that read a key which none of the requested ones reads."""
    able = [m for m in MODELS if key in keys_read(scene, _entries((m,), quantities))]
    if not able:
        nobody = "on any quantity; tactgen report shows the coil's resistance and heat"
        return _unmet(scene, key, MODELS, quantities) or nobody
    model = next((m for m in able if not MODELS[m].shortcut), able[0])
    actuator, use = MODELS[model].actuator, f"with models = {', '.join(scene.models)}; "
    if set(scene.models) & set(models_of(actuator)) or key.startswith("mesh."):
        return f"{use}use it with --set models={model}"
    side = "lateral" if actuator == "bimorph" else "normal"
    return f"{use}ask for one of the {side} actuator, such as --set models={model}, to use it"


def _text(scene: Scene, key: str) -> str:
    value: Any = scene
    info: Any = None
    for name in key.split("."):
        info, value = type(value).model_fields[name], getattr(value, name)
    if isinstance(value, tuple):
        return f"{len(value)} value{'s' if len(value) > 1 else ''}"
    unit = next((m for m in info.metadata if isinstance(m, Unit)), None)
    return unit.show(value) if unit else str(value)
