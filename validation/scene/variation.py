"""Values of a scene by dotted key, and scenes that differ from it in a few."""

from __future__ import annotations

import copy
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from tactgen.geometry.device.laminate import OWN, Laminate
from tactgen.geometry.device.parameters import Bimorph, Parameters, Piezo, Rod, Shim, Sleeve
from tactgen.validation.scene.files import assign
from tactgen.validation.scene.load import checked_scene
from tactgen.validation.scene.scene import Scene


@dataclass(frozen=True)
class ScenesNearby:
    """The scenes next to one."""

    base: dict[str, Any]  #: Values of the one, as they are written; it need not be a scene itself

    def values(self, changes: Mapping[str, Any]) -> dict[str, Any]:
        """All values with some changed, as they would be written."""
        values = copy.deepcopy(self.base)
        for key, value in changes.items():
            assign(values, key, value)
        return values

    def scene(self, changes: Mapping[str, Any]) -> Scene:
        """Scene with some values changed, as they would be written.

        Raises InputError as :func:`validation.scene.load.checked_scene`.
        """
        return checked_scene(self.values(changes))


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
    group, _, name = key.partition(".")
    value = getattr(scene, group)
    return value.value(name) if name else value


def with_values(scene: Scene, values: Mapping[str, float]) -> Scene:
    """Scene with other values (SI) at some dotted keys, without checking them."""
    update: dict[str, Any] = {}
    for key, value in values.items():
        group, _, name = key.partition(".")
        update[group] = (
            update.get(group, getattr(scene, group)).changed({name: value}) if name else value
        )
    return scene.model_copy(update=update)


def with_materials_as_keys(scene: Scene) -> Scene:
    """The same scene, one ceramic and one metal that its listed layers name being piezo and shim.

    Their constants are keys then, with ranges.  A group that the layers name already stays.
    """
    layers, groups = scene.bimorph.layers, dict[str, Parameters]()
    for group, make in (("piezo", Piezo), ("shim", Shim)):
        of_kind = [of.material for of in layers if of.is_ceramic == (group == "piezo")]
        named = [name for name in of_kind if name not in OWN]
        if named and group not in of_kind:
            groups[group] = make(material=named[0])
            each = (of._replace(material=group) if of.material == named[0] else of for of in layers)
            layers = Laminate(each)
    bimorph = scene.bimorph.model_copy(update={"layers": layers})
    return scene.model_copy(update={"bimorph": bimorph, **groups}) if groups else scene


#: What the paper varies or does not say: its two lengths, and how the layers are wired.
_FREE = {"length", "wiring", "poling", "tab_length"}


def is_papers_bimorph(scene: Scene) -> bool:
    """Whether layers, section and materials are the paper's; the length may be any."""
    own, papers = (b.model_dump(exclude=_FREE) for b in (scene.bimorph, Bimorph()))
    return own == papers and (scene.piezo, scene.shim) == (Piezo(), Shim())


def is_papers_generator(scene: Scene) -> bool:
    """Whether it is the machine that the paper measured, whose bimorph is 20 mm long."""
    papers = is_papers_bimorph(scene) and is_papers_actuator(scene)
    return papers and scene.bimorph.length == Bimorph().length


def is_papers_actuator(scene: Scene) -> bool:
    """Whether head and sleeve have the paper's outer diameter: whatever else, its own circuit."""
    own = scene.rod.head_radius, scene.sleeve.outer_radius
    return own == (Rod().head_radius, Sleeve().outer_radius)
