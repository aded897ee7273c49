"""Scenes read by the groups that change are those that are read as a whole."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from tactgen.geometry.errors import InputError
from tactgen.geometry.units import SI
from tactgen.validation.scene.scene import checked_scene, scene_values
from tactgen.validation.scene.variation import ScenesNearby

VALUES, _ = scene_values("paper", ["gap=0.2 ± 0.01 mm", "bimorph.length=20 mm (19..21 mm)"])
NEARBY = ScenesNearby({**VALUES, "models": ["tmm"]})
#: What does not name its models is asked which can take it.
UNNAMED = ScenesNearby(VALUES)
#: Keys with values that make scenes, and values that are refused alone or together.
CHANGES = {
    "bimorph.length": (SI(14e-3), SI(-1.0), SI(0.4e-3), "25 mm", "20 mm (19..22 mm)"),
    "bimorph.bare_above": (SI(0.0), SI(18e-3), SI(30e-3)),
    "piezo.d31": (SI(-190e-12), SI(-3850e-12)),
    "drive.voltage": (SI(10.0), 10.0),
    "load.kind": ("none", "finger", "fingre"),
    "coil.outer_radius": (SI(0.8e-3), SI(3e-3)),
    "gap": (SI(0.1e-3), SI(-1e-3)),
}


def read(how, changes):
    """Return the scene with its tolerances, or the sentence that refuses it."""
    try:
        scene = how(changes)
    except InputError as error:
        return str(error)
    return scene, scene.tolerances


def whole(nearby):
    return lambda changes: checked_scene(nearby.values(changes))


@given(st.dictionaries(st.sampled_from(sorted(CHANGES)), st.integers(0, 4), min_size=1, max_size=3))
def test_groups_and_whole_say_the_same(places):
    changes = {key: CHANGES[key][n % len(CHANGES[key])] for key, n in places.items()}
    for nearby in (NEARBY, UNNAMED):
        assert read(nearby.scene, changes) == read(whole(nearby), changes)


def test_a_scene_that_is_none_by_itself_may_have_some_next_to_it():
    values, _ = scene_values("paper", ["bimorph.length=0.1 mm"])
    nearby = ScenesNearby(
        {**values, "models": ["tmm"], "bimorph": {**values.get("bimorph", {}), "length": "-1 mm"}}
    )
    assert nearby.scene({"bimorph.length": SI(14e-3)}).bimorph.length == 14e-3
    with pytest.raises(InputError, match=r"bimorph\.length"):
        nearby.scene({"drive.voltage": SI(3.0)})
