"""Conditions of an answer: how the device is held, loaded, wired and driven, in one line.

A scene that does not state one of them takes it from what it starts from: the paper's device, or
neutral conditions, which suit a bimorph on a bench.
"""

from __future__ import annotations

from pathlib import Path

from tactgen.geometry.device.parameters import Circuit, Drive, Load, Support
from tactgen.geometry.device.steel_library import curve_in_words
from tactgen.geometry.formats import engineering
from tactgen.validation.catalogue.models import models_of
from tactgen.validation.scene.files import NEUTRAL, OF_THE_COIL
from tactgen.validation.scene.parameter_list import show
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
            driven_in_words(scene.drive, scene.circuit),
        ]
        if scene.piezo.grows:
            parts.append(f"field in the ceramic {engineering(scene.field, 'V/m')}")
        if scene.measurement.below_tip:
            parts.append(f"motion measured {scene.measurement.place}")
    if not bimorph or scene.support.kind == "contact":
        keys += OF_THE_COIL
        parts += [
            f"gap {engineering(scene.gap, 'm')}",
            f"coil current {engineering(scene.coil.current, 'A')}",
        ]
    if not bimorph:
        parts.append(curve_in_words(scene.steel.curve))
    line = f"Conditions: {', '.join(parts)}."
    if scene.circuit.kind != "source" and "drive.voltage" in keys:
        keys.remove("drive.voltage")
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
        case "table":
            return f"base on the support of {Path(support.file).name}"
        case "rod":
            return "glued into the held rod"
        case "contact":
            return "on the rod, whose head rests on its stop"
        case _:
            return support.kind


def driven_in_words(drive: Drive, circuit: Circuit) -> str:
    """Excitation and circuit in words."""
    parts = [
        engineering(size, unit)
        for size, unit in (
            (circuit.resistance, "ohm"), (circuit.inductance, "H"), (circuit.capacitance, "F"),
        )
        if size
    ]  # fmt: skip
    joined = f"{' and '.join(parts)}{f' in {circuit.connection}' if len(parts) > 1 else ''}"
    if circuit.kind == "source":
        found = [f"{engineering(drive.voltage, 'V')} peak{f' behind {joined}' if parts else ''}"]
    elif circuit.kind == "open":
        found = ["open electrodes"]
    else:
        found = [f"{joined or 'short circuit'} across the electrodes"]
    if drive.base_acceleration:
        found.append(f"base at {engineering(drive.base_acceleration, 'm/s^2')} peak")
    if drive.tip_force:
        found.append(f"{engineering(drive.tip_force, 'N')} peak on the tip")
    return ", ".join(found)


def beyond_voltage(scene: Scene) -> str:
    """Key and value of what excites besides a voltage at the electrodes, "" if nothing does."""
    usual = type(scene).model_fields
    for group in ("circuit", "drive"):
        default, stated = usual[group].default, getattr(scene, group)
        for name, info in type(stated).model_fields.items():
            value = getattr(stated, name)
            if f"{group}.{name}" != "drive.voltage" and value != getattr(default, name):
                return f"{group}.{name} = {show(value, info)}"
    return ""


def _load(load: Load) -> str:
    """Load in words."""
    match load.kind:
        case "none":
            return "free tip"
        case "pinned":
            return "pinned tip"
        case "finger":
            return "the paper's finger on the tip"
        case "mass":
            size = ""
            if load.offset:
                side = "above" if load.offset > 0.0 else "below"
                size = f", {engineering(abs(load.offset), 'm')} {side} it"
            if load.rotational_inertia:
                size += f", inertia {engineering(1e3 * load.rotational_inertia, 'g*m^2')}"
            return f"{engineering(1e3 * load.mass, 'g')} on the tip{size}"
        case "spring_damper":
            damping = engineering(load.damping, "N*s/m")
            return f"{engineering(load.stiffness, 'N/m')} and {damping} on the tip"
        case "table":
            return f"load of {Path(load.file).name} on the tip"
        case _:
            return "skin pad on the tip"
