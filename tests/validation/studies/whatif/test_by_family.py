"""Points of one family: found, answered together, and by what single answers say."""

import numpy as np
import pytest

from tactgen.geometry.errors import InputError
from tactgen.validation.engine.families import find_families
from tactgen.validation.engine.results import Quantity
from tactgen.validation.scene.scene import load_scene
from tactgen.validation.studies.whatif import answers, by_family

MODAL = ("short_circuit_frequencies",)


def scenes(*sets):
    return [load_scene("prototype", ["models=solid", *more])[0] for more in sets]


def lengths(count, *more):
    return [(f"bimorph.length={mm} mm", *more) for mm in np.linspace(14.0, 18.0, count)]


def test_families_are_what_differs_in_the_bimorphs_numbers_only():
    both = scenes(*lengths(10, "load.kind=none"), *lengths(9, "load.kind=finger"))
    found = find_families("solid", both, MODAL)
    assert [family.keys for family in found] == [("bimorph.length",)] * 2
    assert [len(family.numbers) for family in found] == [10, 9]
    assert "10 points differ in bimorph.length only" in found[0].reason


@pytest.mark.parametrize(
    ("model", "sets", "quantities"),
    [
        ("solid", lengths(8), MODAL),  # too few to pay
        ("tmm", lengths(12), MODAL),  # a model that is quick anyway
        ("solid", lengths(12), ("dynamic_stiffness",)),  # a matrix
        ("solid", [(f"support.rotational_stiffness={c} N*m/rad",) for c in range(1, 13)], MODAL),
    ],
)
def test_what_is_no_family_is_answered_point_by_point(model, sets, quantities):
    assert find_families(model, scenes(*sets), quantities) == []


@pytest.mark.parametrize("refusing", ["answer_family", "accuracy_warnings"])
def test_what_a_family_cannot_answer_is_left_to_be_asked_alone(monkeypatch, refusing):
    """All of it where there is no basis; where only the answer is refused, that is said there."""

    def refused(*_):
        raise InputError("the range is too wide")

    given = (
        Quantity(
            name=MODAL[0],
            model="solid",
            value=np.ones(1),
            unit="Hz",
            error=np.zeros(1),
            method="",
            seconds=0.1,
        ),
    )
    monkeypatch.setattr(by_family, "answer_family", lambda _, scenes, *__: [given] * len(scenes))
    monkeypatch.setattr(by_family, refusing, refused)
    asked = {
        n: (answers.Question("solid", MODAL, (), ()), s) for n, s in enumerate(scenes(*lengths(9)))
    }
    said = []
    assert by_family.answers_by_family(asked, said.append) == {}
    alone = ["solid: one by one, since the range is too wide"]
    assert said == (alone if refusing == "answer_family" else [])
