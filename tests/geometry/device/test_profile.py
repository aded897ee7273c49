"""Text of a dimension along the ceramic: what is read, held and refused."""

import pytest

from tactgen.geometry.device import profile
from tactgen.geometry.device.parameters import Bimorph
from tactgen.geometry.device.profile import UNIFORM, Profile
from tactgen.geometry.errors import InputError
from tactgen.validation.scene.load import load_scene
from tactgen.validation.scene.template import template

STEPPED = "0 mm: 2.1 mm, 10 mm: 2.1 mm, 10 mm: 1.5 mm, 20 mm: 1 mm"
POINTS = ((0.0, 2.1e-3), (10e-3, 2.1e-3), (10e-3, 1.5e-3), (20e-3, 1e-3))


def read(text):
    return load_scene("paper", [f"bimorph.width_profile={text}"])[0].bimorph.width_profile


def test_points_are_read_with_their_units():
    """Each with any unit of length, and as a report shows them; a dump is read, too."""
    assert read("0 m:2100 um,2 cm:1 mm") == ((0.0, 2.1e-3), (20e-3, 1e-3))
    assert read(STEPPED) == POINTS
    assert str(read(STEPPED)) == STEPPED
    bimorph = Bimorph(width_profile=POINTS)
    assert isinstance(bimorph.width_profile, Profile)
    for mode in ("python", "json"):
        assert Bimorph.model_validate(bimorph.model_dump(mode=mode)) == bimorph


def test_a_profile_is_taken_away_again():
    """On the command line by the word uniform, which the refusal of an empty value names."""
    both = [f"bimorph.width_profile={STEPPED}", "bimorph.width_profile=uniform"]
    assert load_scene("paper", both)[0].bimorph == Bimorph()
    assert str(UNIFORM) == "uniform"
    for text in ("", " Uniform "):
        assert Bimorph(width_profile=text) == Bimorph()
    with pytest.raises(InputError, match=r"--set bimorph\.width_profile=uniform"):
        load_scene("paper", ["bimorph.width_profile="])
    assert '# width_profile = "uniform"' in template()


@pytest.mark.parametrize("end", ["20.0000001", "19.9999999", "20.00001", "19.99999"])
def test_an_end_missed_by_rounding_is_the_edge(end):
    """Up to 1e-6 of the length the last point is put to the ceramic's edge: no sliver beyond."""
    assert read(f"0 mm: 2.1 mm, {end} mm: 1 mm") == ((0.0, 2.1e-3), (20e-3, 1e-3))


def test_values_between_points():
    """Straight from point to point; at a step the side that is asked for."""
    for low, high, ends in (
        (2e-3, 10e-3, (2.1e-3, 2.1e-3)),
        (10e-3, 20e-3, (1.5e-3, 1e-3)),
        (12e-3, 18e-3, (1.4e-3, 1.1e-3)),
    ):
        assert Profile(POINTS).between(low, high) == pytest.approx(ends, rel=1e-14)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("abc", ("list of points", '"0 mm: 2.1 mm, 20 mm: 1 mm"', '"uniform"')),
        ("0 mm: 1 mm", ("at least two",)),
        ("1 mm: 1 mm, 20 mm: 1 mm", ("begins at 1 mm", "lower edge")),
        ("0 mm: 1, 20 mm: 1 mm", ('the dimension "1"', "no unit")),
        ("0 mm: 1 s, 20 mm: 1 mm", ('the dimension "1 s"', "not a dimension")),
        ("0 mm: -1 mm, 20 mm: 1 mm", ('"-1 mm"', "greater than 0 mm")),
        ("0 mm: 1 mm, 5 mm: 1 mm, 3 mm: 1 mm, 20 mm: 1 mm", ("do not ascend",)),
        ("0 mm: 2 mm, 20 mm: 1 mm, 20 mm: 2 mm", ("a step at its",)),
        ("0 mm: 1 mm, 5 mm: 1 mm, 5 mm: 2 mm, 5 mm: 3 mm, 20 mm: 1 mm", ("more than two points",)),
        ("0 mm: 1 mm, 19 mm: 1 mm", ("ends at 19 mm", "bimorph.length = 20 mm")),
        (", ".join(f"{i / 20} mm: 1 mm" for i in range(401)), ("401 points", "at most 200")),
    ],
)  # fmt: skip
def test_bad_profiles_are_refused(text, words):
    """One sentence that names the key, what is wrong with it, and a remedy."""
    with pytest.raises(InputError) as caught:
        read(text)
    message = str(caught.value)
    assert message.startswith("bimorph.width_profile ")
    assert "\n" not in message
    assert all(word in message for word in words), message


def test_a_new_length_needs_a_new_profile():
    """A what-if on the length says what to do with the profile."""
    with pytest.raises(InputError, match="let the profile end at the ceramic's upper edge"):
        load_scene("paper", [f"bimorph.width_profile={STEPPED}", "bimorph.length=25mm"])


@pytest.mark.parametrize("value", [3.0, [1.0, 2.0], [(0.0, 1.0, 2.0)], "1 mm"])
def test_what_is_no_list_of_points_is_refused(value):
    """A number, numbers, three of them, half a point."""
    with pytest.raises(ValueError, match="is not a list of points, each a position and a dim"):
        profile._pairs(value)
