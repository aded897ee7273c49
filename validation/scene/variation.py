"""Values of a scene by dotted key, and scenes that differ from it in a few.

Only the groups of these are read again: several times faster than
:func:`validation.scene.scene.checked_scene` where thousands of points of a study ask.
"""

from __future__ import annotations

import copy
from collections.abc import Mapping
from typing import Any

from pydantic import ValidationError

from tactgen.geometry.device.parameters import Bimorph, Piezo, Shim
from tactgen.geometry.errors import InputError
from tactgen.validation.scene.files import assign
from tactgen.validation.scene.scene import Scene, check_together, checked_scene
from tactgen.validation.scene.tolerances import Tolerance, split_tolerances


class ScenesNearby:
    """The scenes next to one.

    Parameters
    ----------
    values : dict
        That of which they differ, as it is written; it need not be a scene itself.
    """

    def __init__(self, values: dict[str, Any]) -> None:
        self._values = values
        self._base: Scene | None = None
        if "models" not in values:  # which can take a scene follows from all of it
            return
        try:
            self._base = checked_scene(values)
        except InputError:  # only with other values a device
            return
        self._plain, self._tolerances = split_tolerances(Scene, values)

    def values(self, changes: Mapping[str, Any]) -> dict[str, Any]:
        """All values with some changed, as they would be written."""
        values = copy.deepcopy(self._values)
        for key, value in changes.items():
            assign(values, key, value)
        return values

    def scene(self, changes: Mapping[str, Any]) -> Scene:
        """Scene with some values changed, as they would be written.

        Raises InputError as :func:`validation.scene.scene.checked_scene`.
        """
        scene = self._by_groups(changes)
        return checked_scene(self.values(changes)) if scene is None else scene

    def _by_groups(self, changes: Mapping[str, Any]) -> Scene | None:
        """Scene, or None if it must be read as a whole."""
        base = self._base
        if base is None or not all(key.count(".") == 1 for key in changes):
            return None
        groups: dict[str, dict[str, Any]] = {}
        tolerances: dict[str, Tolerance] = dict(self._tolerances)
        for key, value in changes.items():
            if isinstance(value, str):  # it may be a file, or state a tolerance
                return None
            name, field = key.split(".")
            groups.setdefault(name, dict(self._plain.get(name) or {}))[field] = value
            tolerances.pop(key, None)
        context = {"units_required": True}
        try:
            read = {
                name: type(getattr(base, name)).model_validate(group, context=context)
                for name, group in groups.items()
            }
        except ValidationError:  # read as a whole it is refused with the key's whole name
            return None
        scene = base.model_copy(update=read)
        scene._tolerances = tolerances
        check_together(scene, changed=groups)
        return scene


#: Symbols of the paper that stand for scene keys.
SYMBOLS = {
    "c_s": "support.rotational_stiffness",
    "c_sl": "support.lateral_stiffness",
    "d_s": "support.rotational_damping",
    "theta": "support.rotational_inertia",
    "rho_p": "piezo.density",
}


def value_of(scene: Scene, key: str) -> Any:
    """Value of a dotted key."""
    value: Any = scene
    for name in key.split("."):
        value = getattr(value, name)
    return value


def with_values(scene: Scene, values: Mapping[str, float]) -> Scene:
    """Scene with other values (SI) at some dotted keys, without checking them."""
    update: dict[str, Any] = {}
    for key, value in values.items():
        group, _, last = key.rpartition(".")
        if group:
            inner = update.get(group, getattr(scene, group))
            update[group] = inner.model_copy(update={last: value})
        else:
            update[last] = value
    return scene.model_copy(update=update)


#: What the paper varies or does not say: its two lengths, and how the layers are wired.
_FREE = {"length", "wiring", "poling", "tab_length"}


def is_papers_bimorph(scene: Scene) -> bool:
    """Whether layers, section and materials are the paper's; the length may be any."""
    own, papers = (b.model_dump(exclude=_FREE) for b in (scene.bimorph, Bimorph()))
    return own == papers and (scene.piezo, scene.shim) == (Piezo(), Shim())
