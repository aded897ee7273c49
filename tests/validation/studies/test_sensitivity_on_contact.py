"""On its contact the bimorph stands on springs that are no parameters of the scene."""

import pytest

from tactgen.geometry.errors import InputError
from tactgen.validation.scene.scene import load_scene
from tactgen.validation.studies.parameter_uncertainty import uncertain_parameters
from tactgen.validation.studies.sensitivity import all_columns, changed_scenes, left_out

OVERRIDES = ("models=tmm", "quantities=short_circuit_frequencies", "modes=1")


def columns(*keys):
    changed = changed_scenes("generator", OVERRIDES)
    return all_columns(load_scene("generator", OVERRIDES)[0], changed, keys or None)


def test_what_the_contact_is_made_of_is_varied():
    """Its stiffness is the preload over the decay length, so the two act against each other."""
    (column,), _ = columns("spring.preload", "contact.decay_length")
    pressed, rough = (column.logarithmic[key] for key in ("spring.preload", "contact.decay_length"))
    assert 0.3 < pressed < 0.5
    # the pull of the coil is no part of it without current, the rod's own weight next to none
    assert rough == pytest.approx(-pressed, rel=0.01)


def test_a_spring_that_stands_for_the_contact_is_no_key():
    with pytest.raises(InputError, match=r'has no effect with support\.kind = "contact"'):
        columns("support.rotational_stiffness")
    scene, _ = load_scene("generator")
    known = {parameter.key for parameter in uncertain_parameters(scene)}
    assert "bimorph.length" in known
    assert not any(key.startswith("support.") for key in known)


def test_what_samples_hold_is_said():
    scene, _ = load_scene("generator")
    sentence = left_out(scene)
    assert "contact.decay_length" in sentence
    assert "the contact is held as the springs that it is at rest" in sentence
    assert "appears or vanishes" not in sentence
    assert "contact.shape" not in sentence  # a choice is no number
