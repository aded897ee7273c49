"""Parts of a study that are read off in blocks: the same answers, refusals and counts."""

import numpy as np
import pytest

from tactgen.geometry.bimorph.bimorph_bricks import BrickMeshing
from tactgen.geometry.errors import InputError
from tactgen.validation.engine.results import Quantity
from tactgen.validation.models.bimorph import solid
from tactgen.validation.models.bimorph.family import solid_family
from tactgen.validation.scene.scene import scene_values
from tactgen.validation.studies.whatif import questions, sweep
from tactgen.validation.studies.whatif.asked.statement import Statement
from tactgen.validation.studies.whatif.run import Counts, run_study

QUICK = (
    BrickMeshing((2, 2, 2), smallest=1.0, tip=1.0, longest=20.0, pieces=(2.0, 4.0)),
    BrickMeshing((2, 2, 3), smallest=0.5, tip=1.0, longest=20.0, pieces=(2.0, 4.0)),
)
AXES = ("bimorph.length=14mm:18mm:9", "load.kind=none,finger,table", "coil.current=1mA,2mA")


def statement(*vary, models=("tmm", "solid"), quantities=("short_circuit_frequencies",)):
    values, _ = scene_values("prototype", ["accuracy=0.1", "modes=1"])
    return Statement("prototype", values, vary, models, quantities)


class Reduced:
    """Says of each member its length."""

    def __init__(self, model, scene, ranges, quantities, members, announce):
        self.asked = (model, ranges, quantities, members)

    def answers(self, values):
        return [
            (
                Quantity(
                    name="static_tip_displacement",
                    model="solid",
                    value=np.array(length),
                    unit="m",
                    error=np.array(0.0),
                    method="",
                    seconds=0.1,
                ),
            )
            for length in values["bimorph.length"]
        ]


def test_parts_are_read_off_in_blocks_once(own_store, monkeypatch):
    """Two loads of nine lengths, whatever the coil's current; a load that makes no scene."""
    made = []
    monkeypatch.setattr(sweep, "MANY", 9)
    monkeypatch.setattr(sweep, "_BLOCK", 4)
    monkeypatch.setattr(sweep, "reduce_family", lambda *a: made.append(Reduced(*a)) or made[-1])
    monkeypatch.setattr(questions, "question", lambda *_: pytest.fail("a point was asked alone"))
    asked = statement(*AXES, models=("solid",), quantities=("static_tip_displacement",))
    study = run_study(asked, 1)
    ranges = {"bimorph.length": (0.014, 0.018)}
    assert [each.asked for each in made] == [("solid", ranges, ("static_tip_displacement",), 9)] * 2
    assert study.counts == Counts(0, 18, 0, 18, 18)
    for point, _, answer in study.rows:
        if point["load.kind"] == "table":
            assert answer.status == "refused"
            assert "load.file" in answer.reason
        else:
            assert answer.quantities[0].value == point["bimorph.length"]


@pytest.mark.heavy
def test_blocks_say_what_points_one_by_one_say(own_store, monkeypatch):
    """With loads, an axis that is not read, and a load that makes no scene; asked of none."""
    for module in (solid, solid_family):
        monkeypatch.setattr(module, "LEVELS", QUICK)
    quantities = ("short_circuit_frequencies", "static_tip_displacement")
    one_by_one = run_study(statement(*AXES, quantities=quantities), 1)
    monkeypatch.setattr(sweep, "MANY", 9)
    monkeypatch.setattr(sweep, "_BLOCK", 4)
    asked, whole = [], questions.question

    def noted(scene, model, names):
        asked.append(model)
        return whole(scene, model, names)

    monkeypatch.setattr(questions, "question", noted)
    said = []
    study = run_study(statement(*AXES, quantities=quantities), 1, said.append)
    assert set(asked) == {"tmm"}
    assert any("9 points differ in bimorph.length only and are read off" in text for text in said)
    assert [list(answers) for answers in study.answers] == [["tmm", "solid"]] * 54
    # two loads of nine lengths, whatever the coil's current; tmm's were kept
    assert (study.counts.together, study.counts.recalled) == (18, one_by_one.counts.computed - 18)
    assert study.counts.refused == one_by_one.counts.refused == 36
    for (_, model, a), (_, _, b) in zip(study.rows, one_by_one.rows, strict=True):
        assert (a.status, a.reason, a.warnings) == (b.status, b.reason, b.warnings)
        for one, two in zip(a.quantities, b.quantities, strict=True):
            assert (one.name, one.unit, one.classes) == (two.name, two.unit, two.classes)
            # blocks are other groupings of the same sums
            tolerance = 1e-9 if model == "solid" else 0.0
            np.testing.assert_allclose(one.value, two.value, rtol=tolerance)


@pytest.mark.parametrize(
    ("vary", "models", "quantities"),
    [
        (AXES[:1], ("tmm",), ("short_circuit_frequencies",)),  # no families
        (AXES[:1], ("solid",), ("dynamic_stiffness",)),  # a matrix
        (("bimorph.length=14mm:18mm:8",), ("solid",), ("short_circuit_frequencies",)),  # few
        (("drive.voltage=1V:9V:9",), ("solid",), ("static_tip_displacement",)),  # no such key
    ],
)
def test_what_is_no_part_is_asked_point_by_point(vary, models, quantities, monkeypatch):
    monkeypatch.setattr(sweep, "MANY", 9)
    asked = statement(*vary, models=models, quantities=quantities)
    points = list(asked.points())
    nearby = questions.scenes_nearby(asked)[models[0]]
    assert sweep.parts(models[0], quantities, points, nearby) == []


def part(monkeypatch):
    """Return a study's part of nine lengths, in blocks of four."""
    monkeypatch.setattr(sweep, "MANY", 9)
    monkeypatch.setattr(sweep, "_BLOCK", 4)
    asked = statement(AXES[0], models=("solid",), quantities=("static_tip_displacement",))
    nearby = questions.scenes_nearby(asked)["solid"]
    (found,) = sweep.parts("solid", asked.quantities, list(asked.points()), nearby)
    return found


def test_where_a_range_cannot_be_reduced_its_points_are_left_out(monkeypatch):
    def refused(*_):
        raise InputError("the range is too wide")

    monkeypatch.setattr(sweep, "reduce_family", refused)
    said = []
    assert part(monkeypatch).answers(None, said.append) == {}
    assert said[1:] == ["solid: one by one, since the range is too wide"]


def test_a_block_without_answers_is_left_out_and_the_others_are_there(monkeypatch):
    class Partly(Reduced):
        def answers(self, values):
            if 0.016 in values["bimorph.length"]:
                raise InputError("no answer at 16 mm")
            return super().answers(values)

    monkeypatch.setattr(sweep, "reduce_family", Partly)
    said = []
    found = part(monkeypatch).answers(None, said.append)
    assert sorted(found) == [0, 1, 2, 3, 8]
    assert "solid: 4 points one by one, since no answer at 16 mm" in said


def test_answers_are_taken_as_they_come(monkeypatch):
    """On one core no more than one block waits, and it is said how far the study is."""
    monkeypatch.setattr(sweep, "reduce_family", Reduced)
    monkeypatch.setattr(sweep.os, "sched_getaffinity", lambda _: {0})
    said = []
    assert len(part(monkeypatch).answers(None, said.append)) == 9
    assert said[1:] == [f"solid: {count} of 9 points" for count in (0, 4, 8)]


def test_what_is_refused_of_a_block_is_left_to_be_asked_alone(monkeypatch):
    """There it is said why."""
    monkeypatch.setattr(sweep, "reduce_family", Reduced)
    monkeypatch.setattr(sweep, "answer_with_warnings", lambda *_: None)
    assert part(monkeypatch).answers(None, lambda _: None) == {}


def test_points_that_make_no_scene_are_no_part(monkeypatch):
    monkeypatch.setattr(sweep, "MANY", 9)
    asked = statement("load.kind=table", AXES[0], models=("solid",))
    nearby = questions.scenes_nearby(asked)["solid"]
    assert sweep.parts("solid", asked.quantities, list(asked.points()), nearby) == []
