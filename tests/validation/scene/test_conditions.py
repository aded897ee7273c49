"""Conditions: what a scene starts from, and what it does not state."""

import pytest

from tactgen.geometry.errors import InputError
from tactgen.validation.scene.conditions import conditions
from tactgen.validation.scene.files import NEUTRAL, built_in_texts
from tactgen.validation.scene.load import load_scene


def scene_of(tmp_path, text, *overrides):
    file = tmp_path / "own.toml"
    file.write_text(text, encoding="utf-8")
    return load_scene(str(file), overrides)[0]


def test_a_scene_without_conditions_names_each_of_them(tmp_path):
    scene = scene_of(tmp_path, '[bimorph]\nlength = "27 mm"\n')
    line = conditions(scene)
    assert "the paper's finger on the tip" in line
    assert "Not stated, taken from the paper's device: " in line
    assert all(key in line for key in NEUTRAL)


def test_neutral_start_holds_only_what_is_not_stated(tmp_path):
    text = 'start_from = "neutral"\n[drive]\nvoltage = "60 V"\n'
    scene = scene_of(tmp_path, text, "load.kind=spring_damper", "load.stiffness=9 N/m")
    assert (scene.support.kind, scene.load.kind) == ("clamped", "spring_damper")
    assert (scene.drive.voltage, scene.bimorph.wiring) == (60.0, "parallel")
    line = conditions(scene)
    assert line.startswith("Conditions: clamped, 9 N/m and 0 N*s/m on the tip, parallel wiring")
    assert line.endswith("taken from neutral conditions: support.kind, bimorph.wiring.")


def test_conditions_of_the_normal_actuator_are_gap_and_current(tmp_path):
    scene = scene_of(tmp_path, 'models = ["network"]\ngap = "0.1 mm"\n')
    line = conditions(scene)
    assert line.startswith("Conditions: gap 100 µm, coil current 130 mA, ")
    assert line.endswith("Not stated, taken from the paper's device: coil.current.")


def test_a_steel_by_another_name_says_which_curve_it_takes(tmp_path):
    scene = scene_of(tmp_path, 'models = ["network"]\n[steel]\ncurve = "AISI 1010"\n')
    assert "steel37" in conditions(scene)


@pytest.mark.parametrize("name", built_in_texts())
def test_built_in_scenes_state_their_conditions(name):
    assert "Not stated" not in conditions(load_scene(name)[0])


def test_an_unknown_start_is_refused(tmp_path):
    with pytest.raises(InputError, match="start_from"):
        scene_of(tmp_path, 'start_from = "nothing"\n')
