"""Misspelt names get the nearest known one."""

import pytest

from tactgen.geometry.synonyms import _MEANT, nearest
from tactgen.validation.catalogue.quantities import QUANTITIES
from tactgen.validation.scene.keys import scene_keys

KEYS = (
    "gap", "frequency", "bimorph.length", "bimorph.width", "rod.length", "coil.length",
    "sleeve.length", "coil.current", "display.coil_current", "spring.stiffness", "load.stiffness",
)  # fmt: skip


@pytest.mark.parametrize(
    ("written", "meant"),
    [
        ("frequncy", ["frequency"]),
        ("bimorph.lenght", ["bimorph.length"]),
        ("currnt", ["coil.current"]),
        # several groups have it, and nobody said which
        ("stiffness", ["spring.stiffness", "load.stiffness"]),
    ],
)
def test_a_slip_of_the_pen_is_understood(written, meant):
    """A group that was left out as well, whichever groups have the key."""
    shown = ", ".join(f'"{key}"' for key in meant)
    assert nearest(written, KEYS) == f" (did you mean {shown}?)"


def test_of_many_only_some_are_shown():
    """More groups than fit a sentence are hinted at."""
    first = '"bimorph.length", "rod.length", "coil.length"'
    assert nearest("lenght", KEYS) == f" (did you mean {first}, …?)"


def test_what_is_like_nothing_gets_no_guess():
    """No guess is better than a wild one; a text that is no name at all is not compared."""
    assert nearest("xyzzy", KEYS) == ""
    assert nearest("length" * 50, KEYS) == ""


def test_names_by_meaning_lead_to_what_exists():
    """A synonym finds its names, and only ones that a scene or an answer has."""
    choices = ("clamped", "load", "glue")  # of a support, a circuit and a layer
    known = (*scene_keys(), *QUANTITIES, *choices)
    for word, meant in _MEANT.items():
        assert set(meant) <= set(known), word
        assert f'"{meant[0]}"' in nearest(word, known)
    assert nearest("tip_mass", known) == ' (did you mean "load.mass"?)'
