"""Which parameters a sensitivity is given for, and why it is not given for others."""

from __future__ import annotations

from collections.abc import Iterable

from tactgen.geometry.device.profile import Profile
from tactgen.geometry.errors import InputError
from tactgen.geometry.names import nearest
from tactgen.geometry.units import quoted
from tactgen.tmm.beam.parametric import Actuator, check_keys, parameter_keys
from tactgen.validation.engine.inputs import idle
from tactgen.validation.scene.keys import SYMBOLS, value_of
from tactgen.validation.scene.scene import Scene, scene_keys

#: Groups that no one-dimensional model of the lateral actuator reads.
_ELSEWHERE = ("coil", "sleeve", "spring", "steel", "mesh", "limits")
#: Groups that say what the springs of a contact are.
_CONTACT = ("contact", "guide")


def chosen_keys(scene: Scene, device: Actuator, asked: Iterable[str]) -> tuple[str, ...]:
    """Return the keys asked for, each once.

    Raises
    ------
    InputError
        For one that has no sensitivity, with the reason.
    """
    chosen = tuple(dict.fromkeys(asked))
    for key in chosen:
        reason = _refusal(scene, device, key)
        if reason:
            raise InputError(f"--key {quoted(key)} {reason}")
    return chosen


def left_out(scene: Scene, device: Actuator) -> str:
    """Return which parameters that act have no sensitivity, and why, or nothing if all have one."""
    reasons: dict[str, list[str]] = {}
    read = parameter_keys(device)
    for key in scene_keys():
        group, _, name = key.partition(".")
        if key not in scene.tolerances and (not name or group in _ELSEWHERE):
            continue
        reason = _omission(scene, device, key)
        if reason:
            reasons.setdefault(reason, []).append(key)
        elif key in scene.tolerances and key not in read:
            reasons.setdefault("has a tolerance, but is not read here", []).append(key)
    listed = "; ".join(f"{', '.join(keys)} ({reason})" for reason, keys in reasons.items())
    return f"left out of the parameters: {listed}" if listed else ""


def _omission(scene: Scene, device: Actuator, key: str) -> str:
    group, _, name = key.partition(".")
    value = value_of(scene, key)
    profile = f"{name}_profile"
    if group == "bimorph" and profile in scene.bimorph.profiles and idle(scene, key):
        return f"bimorph.{profile} gives it"
    if isinstance(value, Profile) and value:
        return "its points are not varied"
    if not isinstance(value, float) or not value or idle(scene, key):
        return ""
    if group in _CONTACT and scene.support.kind == "contact":
        return "the contact is held as the springs that it is at rest; tactgen whatif varies it"
    return _kink(scene, key) if _has_kink(device, key) else ""


def not_a_number(scene: Scene, key: str) -> str:
    """Return why no model has a sensitivity to a key, and the remedy: it is no number."""
    if key not in scene_keys():
        symbol = f' (did you mean "{SYMBOLS[key]}"?)' if key in SYMBOLS else ""
        close = symbol or nearest(key, scene_keys())
        return f"is not a scene key{close}; tactgen init FILE.toml writes a scene with every key"
    value, out = value_of(scene, key), "leave the key out"
    if isinstance(value, Profile):
        return f"is a profile, whose points are not varied; {out}, or compare two tactgen solve"
    if isinstance(value, int):
        return f"is a whole number, which is not varied; {out}"
    if value is None:
        return f"has no value of its own in this scene, but follows from others; {out}"
    if not isinstance(value, float):
        return f"is a choice, not a number, and has no sensitivity; {out}"
    return ""


def _refusal(scene: Scene, device: Actuator, key: str) -> str:
    """Return why a key has no sensitivity by tmm, and the remedy, or nothing if it has one."""
    out = "leave the key out"
    if key in scene_keys() and ("." not in key or key.partition(".")[0] in _ELSEWHERE):
        return f"is no parameter of the transfer-matrix model; {out}"
    reason = not_a_number(scene, key)
    if reason:
        return reason
    if idle(scene, key):
        return "has no sensitivity: " + idle(scene, key)
    if value_of(scene, key) == 0.0:
        return f"is 0, and there is no percentage of 0; set another value, or {out}"
    if _has_kink(device, key):
        return f"cannot be varied: {_kink(scene, key)}; {out}"
    if key not in parameter_keys(device):
        return (
            f'is not read by the transfer-matrix model with support.kind = "{scene.support.kind}" '
            f'and load.kind = "{scene.load.kind}"; {out}'
        )
    return ""


def _has_kink(device: Actuator, key: str) -> bool:
    """Whether the model does not depend smoothly on a number that is not 0."""
    try:
        check_keys(device, [key])
    except InputError:
        return True
    return False


def _kink(scene: Scene, key: str) -> str:
    profiles = [f"bimorph.{name}" for name in scene.bimorph.profiles]
    if key == "bimorph.length" and profiles:
        return f"{' and '.join(profiles)} would not end at the ceramic's edge any more"
    return "a piece of the row of beams appears or vanishes at its value"
