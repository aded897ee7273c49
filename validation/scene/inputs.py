"""Inputs of stages: scene keys that they read, and keys of their results.

All of it follows from the entries of :mod:`validation.catalogue.models`.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterable
from functools import lru_cache
from typing import Any

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
    stage_reads,
)
from tactgen.validation.scene.keys import scene_keys
from tactgen.validation.scene.scene import Scene
from tactgen.validation.scene.variation import value_of

#: Keys that say whose scene it is and what is asked of it.
ASKED = ("name", "description", "start_from", "models", "quantities")
#: Before a key in a condition that it is not stated, and before a group of a layer's constants.
NOT, LAYER = "no ", "layer of "


@lru_cache
def keys_of(path: str) -> tuple[str, ...]:
    """Scene keys that a key or group stands for."""
    return tuple(key for key in scene_keys() if key == path or key.startswith(f"{path}."))


def condition_holds(scene: Scene, condition: str) -> bool:
    """Whether a condition of an entry holds."""
    if condition.startswith(NOT):
        return not value_of(scene, condition.removeprefix(NOT))
    if condition.startswith(LAYER):
        return condition.removeprefix(LAYER) in scene.bimorph.own_materials
    key, unequal, value = condition.partition("!=")
    if not unequal:
        key, _, value = condition.partition("=")
    found = value_of(scene, key)
    if not value:
        return bool(found)
    return (str(found) == value) is not bool(unequal)


def profile_of(scene: Scene, key: str) -> str:
    """Key of the profile that gives a dimension of the ceramic instead, if one does."""
    profile = f"{key}_profile"
    if profile.removeprefix("bimorph.") not in scene.bimorph.profiles:
        return ""
    return "" if key != "bimorph.piezo_thickness" and bare_shim(scene) else profile


def bare_shim(scene: Scene) -> str:
    """Key of a length of bare shim, which has the width and the shim that no profile gives."""
    lengths = ("bimorph.tab_length", "bimorph.tip_extension")
    return next((key for key in lengths if value_of(scene, key)), "")


def _own_keys(scene: Scene, entries: Iterable[str]) -> dict[str, None]:
    """Keys that entries name and whose conditions hold, in order."""
    found: dict[str, None] = {}
    holds: dict[str, bool] = {"": True}
    for entry in entries:
        path, _, own = entry.partition(" if ")
        for key in keys_of(path):
            conditions = own, CONDITIONS.get(key, ""), CONDITIONS.get(key.partition(".")[0], "")
            for condition in conditions:
                if condition not in holds:
                    holds[condition] = condition_holds(scene, condition)
                if not holds[condition]:
                    break
            else:
                if key not in PROFILED or not profile_of(scene, key):
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
    return frozenset(keys.difference(ASKED))


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
