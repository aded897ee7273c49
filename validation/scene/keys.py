"""Scene values by their dotted keys, and the paper's symbols that stand for some."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from tactgen.validation.scene.scene import Scene

#: Symbols of the paper that stand for scene keys.
SYMBOLS = {
    "c_s": "support.rotational_stiffness",
    "c_sl": "support.lateral_stiffness",
    "d_s": "support.rotational_damping",
    "theta": "support.rotational_inertia",
    "rho_p": "piezo.density",
}


def value_of(scene: Scene, key: str) -> Any:
    """Return the value of a dotted key."""
    value: Any = scene
    for name in key.split("."):
        value = getattr(value, name)
    return value


def with_values(scene: Scene, values: Mapping[str, float]) -> Scene:
    """Return the scene with other values (SI) at some dotted keys, without checking them."""
    update: dict[str, Any] = {}
    for key, value in values.items():
        group, _, last = key.rpartition(".")
        if group:
            inner = update.get(group, getattr(scene, group))
            update[group] = inner.model_copy(update={last: value})
        else:
            update[last] = value
    return scene.model_copy(update=update)
