"""What is kept is what was computed: real entries of every kind, damaged in every way.

The store's own tests damage a made-up value; here are the entries that commands leave behind.
"""

import random

import numpy as np
import pytest

from tactgen.geometry.store import store
from tactgen.geometry.store.store import Damaged, read_entry
from tactgen.validation.engine.solve import solve
from tactgen.validation.scene.load import load_scene

#: Scenes whose answers leave entries behind, by what they cost.
LIGHT = [
    ("prototype", ["models=beam", "modes=2", "frequency=100,500"],
     "static_tip_displacement,short_circuit_frequencies,tip_displacement"),
    ("reluctance", ["models=network"], "magnetic_force,pull_in_current"),
]  # fmt: skip
HEAVY = [
    *LIGHT,
    ("j1", ["models=solid", "mesh.level=2", "modes=2"], "all"),
    ("j1", ["models=cad", "mesh.level=1", "modes=2"], "static_tip_displacement"),
    ("prototype", ["models=solid", "mesh.level=2"], "tip_velocity"),
    ("reluctance", ["models=axisymmetric"], "magnetic_force,pull_in_current"),
    ("reluctance", ["models=magnetic3d"], "magnetic_force"),
]


def answers(cases):
    """Return all numbers of some scenes, as they are solved now."""
    found = []
    for name, overrides, quantities in cases:
        scene, _ = load_scene(name, [*overrides, f"quantities={quantities}"])
        found += [(q.model, q.value, q.error) for q in solve(scene).quantities]
    return found


def assert_same(before, after):
    """Digit for digit; on tetrahedra, whose mesher does not repeat itself, within the bars."""
    for (model, a, bar_a), (_, b, bar_b) in zip(before, after, strict=True):
        if model == "cad":
            assert np.all(np.abs(a - b) <= bar_a + bar_b)
        else:
            assert np.array_equal(a, b, equal_nan=True)
            assert np.array_equal(bar_a, bar_b, equal_nan=True)


def flipped(content, chance):
    at = chance.randrange(len(content))
    return content[:at] + bytes([content[at] ^ (1 << chance.randrange(8))]) + content[at + 1 :]


def cut(content, chance):
    return content[: chance.randrange(len(content))]


def longer(content, chance):
    return content + chance.randbytes(chance.randint(1, 64))


def zeroed(content, chance):
    """Blocks that never reached the disk."""
    at = chance.randrange(len(content))
    size = min(4096, len(content) - at)
    changed = content[:at] + bytes(size) + content[at + size :]
    return changed if changed != content else b""


def shuffled(content, chance):
    """Two parts that changed places."""
    a, b = sorted(chance.sample(range(1, len(content)), 2))
    changed = content[:a] + content[b:] + content[a:b]
    return changed if changed != content else b""


def older(content, _):
    """What a version with another format wrote."""
    return content.replace(b"kept 1", b"kept 0", 1)


DAMAGES = (flipped, flipped, cut, longer, zeroed, shuffled, older)


def damage_all(folder, number, seed):
    """Damage entries of each kind `number` times in all; return how often by kind."""
    chance = random.Random(seed)
    paths = sorted(folder.glob("*.kept"))
    kinds = {}
    for path in paths:
        kinds.setdefault(path.stem.rpartition("-")[0] or path.stem, []).append(path)
    whole = {path: path.read_bytes() for path in paths}
    tried = dict.fromkeys(kinds, 0)
    for turn in range(number):
        kind = sorted(kinds)[turn % len(kinds)]
        path = chance.choice(kinds[kind])
        if chance.random() < 0.2:  # another entry, whole, under this one's name
            damaged = whole[chance.choice([other for other in paths if other != path])]
        else:
            damaged = chance.choice(DAMAGES)(whole[path], chance)
        path.write_bytes(damaged)
        with pytest.raises(Damaged):
            read_entry(path)
        path.write_bytes(whole[path])
        tried[kind] += 1
    return tried


def check_damages(folder, cases, number):
    """Damage single entries, then all of them at once: numbers are those of an empty store."""
    before = answers(cases)
    tried = damage_all(folder, number, seed=number)
    assert sum(tried.values()) == number
    chance = random.Random(number)
    for path in folder.glob("*.kept"):
        path.write_bytes(chance.choice(DAMAGES)(path.read_bytes(), chance))
    assert_same(before, answers(cases))
    return tried


def test_no_damaged_entry_is_trusted(own_store, monkeypatch):
    """Fifty damages of what beam and network leave behind."""
    monkeypatch.setattr(store, "_said", set())
    tried = check_damages(own_store, LIGHT, 50)
    assert {"beam.modes", "beam.static", "network.point", "network.map"} <= set(tried)


@pytest.mark.heavy
def test_no_damaged_entry_of_any_kind_is_trusted(own_store, monkeypatch):
    """Six thousand, of every kind that the program keeps."""
    monkeypatch.setattr(store, "_said", set())
    tried = check_damages(own_store, HEAVY, 6000)
    # the map in 3D takes minutes; its rows are entries like its points
    assert set(tried) >= {
        *(f"solid.{stage}" for stage in ("static", "modal", "ports")), "cad.static",
        *(f"beam.{stage}" for stage in ("static", "modes", "ports")), "magnetic3d.point",
        *(f"{model}.{stage}" for model in ("network", "axisymmetric")
          for stage in ("point", "map", "switching")),
        "mesh", "reduction",
    }  # fmt: skip
