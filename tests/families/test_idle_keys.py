"""What is said to have no effect has none: the key is turned and nothing moves, to the last bit."""

import pytest

from tactgen.geometry.errors import InputError
from tactgen.validation.engine.solve import solve
from tactgen.validation.scene.load import load_scene
from tactgen.validation.scene.parameter_list import parameter_rows
from tactgen.validation.scene.warnings import idle

SCENES = (
    ("paper", ("models=tmm", "frequency=100")),
    ("reluctance", ("models=network",)),
    ("generator", ("models=tmm", "frequency=100")),
    ("generator", ("models=tmm,network", "frequency=100", "coil.current=50mA")),
    ("display", ("models=tmm", "frequency=100")),
)


def numbers(scene):
    """Return every number of a scene with its bar, to the last bit."""
    return {
        (q.name, q.model): (q.value.tobytes(), q.error.tobytes()) for q in solve(scene).quantities
    }


def value_of(scene, key):
    for part in key.split("."):
        scene = getattr(scene, part)
    return scene


def turned(scene, key, factor):
    """Return the scene with a key times a factor."""
    group, _, last = key.rpartition(".")
    if not group:
        return scene.model_copy(update={last: factor * value_of(scene, key)})
    own = getattr(scene, group)
    changed = own.model_copy(update={last: factor * getattr(own, last)})
    return scene.model_copy(update={group: changed})


def idle_keys(scene):
    """Return the keys with a number that are said to have no effect."""
    keys = [row.key for row in parameter_rows(scene, {})]
    numeric = [k for k in keys if isinstance(value_of(scene, k), float) and value_of(scene, k)]
    return [key for key in numeric if idle(scene, key)]


def check(scene, keys):
    before = numbers(scene)
    for key in keys:
        for factor in (1.05, 0.95):
            try:
                assert numbers(turned(scene, key, factor)) == before, key
                break
            except InputError:  # a part that would not fit: the other way
                continue
        else:
            pytest.fail(f"{key} cannot be turned either way")


@pytest.mark.parametrize(
    ("name", "overrides"), [*SCENES[:-2], pytest.param(*SCENES[-2], marks=pytest.mark.heavy)]
)
def test_what_is_said_to_have_no_effect_has_none(name, overrides):
    """All keys at once."""
    scene, _ = load_scene(name, overrides)
    keys, together = idle_keys(scene), scene
    assert len(keys) > 50
    for key in keys:
        together = turned(together, key, 1.05)
    assert numbers(together) == numbers(scene)


@pytest.mark.heavy
@pytest.mark.parametrize(("name", "overrides"), SCENES)
def test_nothing_that_is_said_to_have_no_effect_has_one(name, overrides):
    """Every key by itself."""
    scene, _ = load_scene(name, overrides)
    check(scene, idle_keys(scene))


def test_the_machine_reads_its_magnet_whatever_the_model_of_the_bimorph():
    """By its coil's impedance, without a current too."""
    scene, _ = load_scene("generator", ["models=tmm"])
    assert "coil_impedance" in scene.quantities
    for key in ("gap", "coil.turns", "sleeve.outer_radius", "coil.temperature"):
        assert not idle(scene, key), key
