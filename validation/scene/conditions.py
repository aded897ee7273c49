"""Conditions of an answer: how the device is held, loaded, wired and driven, in one line.

A scene that does not state one of them takes it from what it starts from: the paper's device, or
neutral conditions, which suit a bimorph on a bench.
"""

from __future__ import annotations

import copy
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from tactgen.geometry.device.parameters import Load, Support
from tactgen.geometry.formats import engineering
from tactgen.validation.catalogue.models import models_of
from tactgen.validation.scene.files import assign, leaves

if TYPE_CHECKING:
    from tactgen.validation.scene.scene import Scene

#: Conditions of ``start_from = "neutral"``.
NEUTRAL = {
    "support.kind": "clamped",
    "load.kind": "none",
    "bimorph.wiring": "parallel",
    "drive.voltage": "1 V",
}
#: Conditions of the normal actuator.
_OF_THE_COIL = ("gap", "coil.current")


def with_start(values: Mapping[str, Any]) -> tuple[dict[str, Any], tuple[str, ...]]:
    """Scene's values with the conditions of its start, and the keys that it does not state."""
    stated = {key for key, _ in leaves(dict(values))}
    missing = tuple(key for key in (*NEUTRAL, *_OF_THE_COIL) if key not in stated)
    complete = copy.deepcopy(dict(values))
    if values.get("start_from") == "neutral":
        for key in NEUTRAL.keys() & set(missing):
            if isinstance(complete.get(key.partition(".")[0], {}), dict):
                assign(complete, key, NEUTRAL[key])
    return complete, missing


def conditions(scene: Scene) -> str:
    """Conditions of a scene's answers, and which of them the scene does not state."""
    parts, keys = [], []
    bimorph = set(scene.models) & set(models_of("bimorph"))
    if bimorph:
        keys += [*NEUTRAL]
        parts += [
            _support(scene.support),
            _load(scene.load),
            f"{scene.bimorph.wiring} wiring",
            f"{engineering(scene.drive.voltage, 'V')} peak",
        ]
    if not bimorph or scene.support.kind == "contact":
        keys += _OF_THE_COIL
        parts += [
            f"gap {engineering(scene.gap, 'm')}",
            f"coil current {engineering(scene.coil.current, 'A')}",
        ]
    line = f"Conditions: {', '.join(parts)}."
    missing = [key for key in keys if key in scene.not_stated]
    if not missing:
        return line
    start = "neutral conditions" if scene.start_from == "neutral" else "the paper's device"
    return f"{line} Not stated, taken from {start}: {', '.join(missing)}."


def _support(support: Support) -> str:
    """Support in words."""
    match support.kind:
        case "spring":
            rotational = engineering(support.rotational_stiffness, "N*m/rad")
            return (
                f"base on springs ({rotational}, {engineering(support.lateral_stiffness, 'N/m')})"
            )
        case "rod":
            return "glued into the held rod"
        case "contact":
            return "on the rod, whose head rests on its stop"
        case _:
            return support.kind


def _load(load: Load) -> str:
    """Load in words."""
    match load.kind:
        case "none":
            return "free tip"
        case "finger":
            return "the paper's finger on the tip"
        case "mass":
            return f"{engineering(1e3 * load.mass, 'g')} on the tip"
        case "spring_damper":
            damping = engineering(load.damping, "N*s/m")
            return f"{engineering(load.stiffness, 'N/m')} and {damping} on the tip"
        case "table":
            return f"load of {Path(load.file).name} on the tip"
        case _:
            return "skin pad on the tip"
