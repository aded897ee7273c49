"""Tolerances in scenes: they travel beside the numbers, and nothing else changes."""

import pickle

import pytest

from tactgen.geometry.errors import InputError
from tactgen.validation.catalogue.models import stage_reads
from tactgen.validation.scene.inputs import stage_key
from tactgen.validation.scene.load import checked_scene, load_scene, scene_values
from tactgen.validation.scene.parameter_list import parameter_rows, ranges


def test_a_file_and_an_override_state_them(tmp_path):
    """Values are those without a tolerance, and so are the keys by which they are kept."""
    file = tmp_path / "mine.toml"
    file.write_text('[bimorph]\nwidth = "2.0 ± 0.1 mm"\n[piezo]\nquality_factor = "60 (50..80)"\n')
    scene, origins = load_scene(str(file), ["bimorph.length=18 mm +/- 1 %"])
    plain, _ = load_scene(
        "paper", ["bimorph.width=2.0 mm", "bimorph.length=18 mm", "piezo.quality_factor=60"]
    )
    assert scene.model_dump(exclude={"name"}) == plain.model_dump(
        exclude={"name", "description"}
    ) | {"description": scene.description}
    for stage in stage_reads():
        assert stage_key(stage, scene) == stage_key(stage, plain)
    found = ranges(scene)
    assert found["bimorph.width"][:2] == pytest.approx((1.9e-3, 2.1e-3))
    assert found["piezo.quality_factor"][:3] == (50.0, 80.0, "stated: 50..80")
    assert found["bimorph.length"][:2] == pytest.approx((17.82e-3, 18.18e-3))
    assert found["bimorph.shim_thickness"].whose == "printed"
    text = {row.key: row.text for row in parameter_rows(scene, origins)}
    assert text["piezo.quality_factor"] == "60 (50..80)"
    assert text["bimorph.width"] == "2 mm ± 0.1 mm"


def test_a_listed_layer_has_them_in_its_text():
    """Of any size, in any form; a key that states the size takes its place."""
    layers = "brass 300 um (290..320 um); PZT-5A 0.2 ± 0.01 mm wide 2 mm ± 5 % to 9 +/- 0.5 mm +x"
    scene, _ = load_scene("prototype", [f"bimorph.layers={layers}"])
    assert str(scene.bimorph.layers) == "brass 0.3 mm; PZT-5A 0.2 mm wide 2 mm to 9 mm +x"
    ends = {
        "1.thickness": (0.29e-3, 0.32e-3), "2.thickness": (0.19e-3, 0.21e-3),
        "2.width": (1.9e-3, 2.1e-3), "2.end": (8.5e-3, 9.5e-3),
    }  # fmt: skip
    assert set(scene.tolerances) == {f"bimorph.layers.{name}" for name in ends}
    values, _ = scene_values("prototype", [])
    values["bimorph"]["layers"] = layers.split("; ")
    assert checked_scene(values).tolerances == scene.tolerances
    row = next(row for row in parameter_rows(scene, {}) if row.key == "bimorph.layers")
    again, _ = load_scene("prototype", [f"bimorph.layers={row.written}"])
    words = [{key: of.words for key, of in s.tolerances.items()} for s in (again, scene)]
    assert words[0] == words[1]
    for name, wanted in ends.items():
        assert ranges(scene)[f"bimorph.layers.{name}"][:2] == pytest.approx(wanted)
    other, _ = load_scene("prototype", [f"bimorph.layers={layers}", "bimorph.layers.2.end=8 mm"])
    assert other.bimorph.layers[1].end == 8e-3
    assert len(other.tolerances) == 3


def test_they_follow_a_value_that_changes():
    """A copy keeps them, another process too; a changed number takes its amount along."""
    scene, _ = load_scene("paper", ["bimorph.width=2.1 ± 0.1 mm"])
    wider = scene.bimorph.model_copy(update={"width": 2.5e-3})
    moved = pickle.loads(pickle.dumps(scene.model_copy(update={"bimorph": wider})))
    assert ranges(moved)["bimorph.width"][:2] == pytest.approx((2.4e-3, 2.6e-3))


@pytest.mark.parametrize(
    ("override", "words"),
    [
        ("bimorph.layers=brass 0.3 ± 0.1 kg", 'layers.1.thickness = "0.3 ± 0.1 kg" has the unit'),
        ("bimorph.layers=brass 0.3 ± 0.4 mm", "reaches"),
        ("accuracy=1e-3 ± 1e-4", "says how the scene is solved"),
        ("modes=4 ± 1", "is not a whole number"),
        ("frequency=10 ± 1 Hz", "is not a frequency"),
        ("bimorph.width_profile=0 mm: 2.1 ± 0.1 mm, 20 mm: 1 mm", "has a tolerance"),
        ("support.kind=rod ± 1", "is not a valid choice"),
        ("shim.poisson_ratio=0.3 ± 0.3", 'reaches "0.6", which must be less than 0.5'),
    ],
)
def test_where_none_can_be_the_sentence_says_so(override, words):
    """One sentence with key and value."""
    with pytest.raises(InputError) as refused:
        load_scene("paper", [override])
    assert words in str(refused.value)
    assert override.partition("=")[0] in str(refused.value)


def test_a_name_may_hold_the_sign():
    """Words are no numbers."""
    assert load_scene("paper", ["name=18 ± 1"])[0].name == "18 ± 1"
