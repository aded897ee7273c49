"""Slips of units: asked about by key, with the value that would explain them."""

import pytest

from tactgen.geometry.device.ceramic_library import LIBRARY
from tactgen.geometry.device.plausibility import EXPECTED
from tactgen.geometry.errors import InputError
from tactgen.validation.scene.load import load_scene
from tactgen.validation.scene.warnings import scene_warnings


def questions(*overrides):
    return [
        w for w in scene_warnings(*load_scene("j1", overrides)) if "range of" in w or "near" in w
    ]


@pytest.mark.parametrize(
    ("override", "meant"),
    [
        ("piezo.density=7.8 kg/m^3", "did you mean 7800 kg/m^3?"),
        ("shim.youngs_modulus=70e3 N/m^2", "did you mean 70 GPa?"),
        ("shim.density=8.5 kg/m^3", "did you mean 8500 kg/m^3?"),
        ("piezo.material=PZT-5A,piezo.eps33=830", "at constant strain"),
    ],
)
def test_a_slip_is_asked_about(override, meant):
    (question,) = questions(*override.split(","))
    assert meant in question
    assert override.split(",")[-1].partition("=")[0] in question


def test_a_refusal_blames_the_constant_that_is_off():
    with pytest.raises(InputError, match=r"piezo\.s11 = .* did you mean .*?") as refused:
        load_scene("j1", ["piezo.s11=1.43e-5 m^2/N"])
    assert "d31" not in str(refused.value)


@pytest.mark.parametrize("name", LIBRARY)
def test_library_materials_are_usual(name):
    """Each constant of every material lies inside the range itself, not ten times around it."""
    assert questions(f"piezo.material={name}") == []
    for constant, value in LIBRARY[name].reduced().items():
        expected = EXPECTED.get(f"piezo.{constant}")
        assert expected is None or expected.low <= abs(value) <= expected.high
