"""Every key of built-in scenes: whether it has an effect, and within what it may lie."""

import re

import pytest
from approved import described

from tactgen.validation.scene.idle_keys import idle, scene_warnings
from tactgen.validation.scene.ranges import ranges
from tactgen.validation.scene.scene import load_scene, scene_keys

#: Others that the built-in scenes do not show.
OTHERS = {
    "paper": ("support.kind=clamped load.kind=none", "load.kind=mass models=tmm,solid,cad"),
    "generator": ("coil.current=60mA coil.supply=voltage models=tmm", "load.kind=pad models=solid"),
    "bimorph_on_rod": ("load.kind=spring_damper mesh.level=2", "modes=2"),
    "reluctance": ("models=axisymmetric,magnetic3d", "models=network steel.curve=linear"),
    "display": ("models=network", "load.kind=none display.rows=1"),
}


@pytest.mark.parametrize("name", OTHERS)
def test_keys_without_effect(name, approved):
    lines = []
    for overrides in ("", *OTHERS[name]):
        scene, origins = load_scene(name, overrides.split())
        because = {}
        for key in scene_keys():
            said = idle(scene, key)
            if said:
                reason = re.sub(r"= [\w, ]+;", "= …;", said.partition(" has no effect ")[2])
                because.setdefault(reason, []).append(key)
        lines += [f"{name} {overrides}", *scene_warnings(scene, origins, report=True)]
        lines += [f"  {', '.join(keys)}: {reason}" for reason, keys in because.items()]
    approved("\n".join(lines))


def test_ranges(approved):
    found = {**ranges(load_scene("generator")[0]), **ranges(load_scene("bimorph_on_rod")[0])}
    approved("\n".join(described(tuple(spread), key) for key, spread in found.items()))
