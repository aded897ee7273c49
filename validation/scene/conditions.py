"""Conditions of an answer: how the device is held, loaded, wired and driven, in one line.

A scene that does not state one of them takes it from what it starts from: the paper's device, or
neutral conditions, which suit a bimorph on a bench.
"""

from __future__ import annotations

from pathlib import Path

from tactgen.geometry.device.material_library import curve_in_words
from tactgen.geometry.device.parameters import Load, Support
from tactgen.geometry.formats import engineering
from tactgen.validation.catalogue.models import models_of
from tactgen.validation.scene.files import NEUTRAL, OF_THE_COIL
from tactgen.validation.scene.scene import Scene


def answer_head(scene: Scene) -> dict[str, str]:
    """First entries of every JSON answer."""
    return {"scene": scene.name, "conditions": conditions(scene)}


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
        keys += OF_THE_COIL
        parts += [
            f"gap {engineering(scene.gap, 'm')}",
            f"coil current {engineering(scene.coil.current, 'A')}",
        ]
    if not bimorph:
        parts.append(curve_in_words(scene.steel.curve))
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
