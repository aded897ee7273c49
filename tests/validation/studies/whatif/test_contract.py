"""A study before it runs: its model by the accuracy, judged at its edges, and its plan."""

import json
from dataclasses import replace

import pytest

from tactgen.geometry.bimorph.bricks import BrickMeshing
from tactgen.geometry.errors import InputError
from tactgen.validation.command_line.cli import main
from tactgen.validation.command_line.commands import whatif
from tactgen.validation.engine import comparison as ladders
from tactgen.validation.engine.comparison import FidelityLevel, choose
from tactgen.validation.models.bimorph import solid
from tactgen.validation.scene.load import load_scene, scene_values
from tactgen.validation.studies.whatif.defaults import judged_points, under_contract
from tactgen.validation.studies.whatif.definition import Statement, read_statement
from tactgen.validation.studies.whatif.study import plan_study, run_study

QUICK = (
    BrickMeshing((2, 2, 2), smallest=1.0, tip=1.0, longest=20.0, pieces=(2.0, 4.0)),
    BrickMeshing((2, 2, 3), smallest=0.5, tip=1.0, longest=20.0, pieces=(2.0, 4.0)),
)
STATIC = ("static_tip_displacement",)


def stated(*vary, sets=(), quantities=STATIC, **more):
    values, _ = scene_values("prototype", ["accuracy=10%", *sets])
    return Statement("prototype", values, vary, ("tmm",), quantities, by_accuracy=True, **more)


@pytest.fixture
def forms(monkeypatch):
    """Make a beam's error of form 2 % at 14 mm and fall with the length; return the lengths."""
    asked = []

    def level(scene, model, quantities, announce):
        if model != "tmm":
            raise InputError("left out")
        asked.append(scene.bimorph.length)
        form = 0.02 * 14e-3 / scene.bimorph.length
        return FidelityLevel(model, form, 0.0, 0.1, form <= scene.accuracy, "q")

    monkeypatch.setattr(ladders, "_level", level)
    return asked


def test_judged_at_the_middle_and_the_ends_of_each_axis():
    """Of samples at the least and the largest."""
    points = judged_points(
        stated("bimorph.length=14mm:22mm:5", "load.kind=none,finger,mass", "modes=4,2,3")
    )
    assert [tuple(point.values()) for point in points] == [
        (0.018, "finger", 2), (0.014, "finger", 2), (0.022, "finger", 2),
        (0.018, "none", 2), (0.018, "mass", 2), (0.018, "finger", 4),
    ]  # fmt: skip
    statement = stated("bimorph.length=normal(18mm,2%)", samples=20)
    lengths = [point["bimorph.length"] for point in statement.points()]
    judged = [point["bimorph.length"] for point in judged_points(statement)]
    assert set(judged) == {lengths[10], min(lengths), max(lengths)}


@pytest.mark.parametrize(
    ("accuracy", "model", "form"), [("3%", "tmm", 0.02), ("1.5%", "solid", 0.02)]
)
def test_the_worst_of_the_points_decides(forms, accuracy, model, form):
    """At 22 mm the beam would meet 1.5 %; at 14 mm it does not, and there it is asked as well."""
    statement, choice = under_contract(
        stated("bimorph.length=14mm:22mm:5", sets=[f"accuracy={accuracy}"])
    )
    assert sorted(forms) == [0.014, 0.018, 0.022]
    assert statement.models == (model,)
    assert choice.ladders[0][0].form == pytest.approx(form)
    (sentence,) = choice.sentences
    assert "worst of 3 points" in sentence
    assert f"{model} meets it" in sentence


def test_an_accuracy_that_varies_is_met_at_its_tightest(forms):
    statement, choice = under_contract(stated("accuracy=1%,5%"))
    assert (statement.models, choice.accuracy) == (("solid",), 0.01)


def test_refused_once_with_the_reason(forms, tmp_path, capsys):
    """One sentence, exit code 2, nothing written; and a study none of whose edges is a scene."""
    asked = ["whatif", "prototype", "--vary", "bimorph.length=14mm:22mm:5"]
    out = tmp_path / "study"
    code = main([*asked, "--set", "accuracy=1e-7", "--quantity", *STATIC, "--out", str(out)])
    said = capsys.readouterr().err
    assert code == 2
    assert said.count("no model meets accuracy = 1e-07 (worst of 3 points") == 1
    assert not out.exists()
    with pytest.raises(InputError, match="no point at the study's edges makes a scene: "):
        under_contract(stated("rod.length=1um:2um:3"))


def test_what_the_judge_does_not_compute_is_refused():
    scene, _ = load_scene("display", ["models=tmm"])
    with pytest.raises(InputError, match="judged by solid, which does not compute tuned_spread"):
        choose((scene,), ("tuned_spread",))


def test_a_study_says_why_and_remembers_that_none_was_named(
    forms, own_store, monkeypatch, capsys, tmp_path
):
    """So does its plan; gone on with it is judged anew, with a model named it is not."""
    monkeypatch.setattr(whatif, "_write", lambda *_: None)  # the pictures take longest
    out = tmp_path / "study"
    asked = ["--quantity", *STATIC, "--vary", "bimorph.length=14mm:18mm:3", "--out", str(out)]
    plain = ["prototype", "--set", "accuracy=3%", *asked[:4], "--json"]
    for command in (["plan", *plain], ["whatif", *plain, *asked[4:]]):
        assert main(command) == 0
        said = capsys.readouterr()
        assert said.err.count("tmm meets it: modelling error 2 %") == 1
        answer = json.loads(said.out)
        assert [rung["model"] for rung in answer["ladders"][0]] == ["tmm", "solid"]
    assert {point["model"] for point in answer["points"]} == {"tmm"}
    assert read_statement(out).by_accuracy
    grown = ["--vary", "bimorph.length=12mm:18mm:3", "--resume", "--out", str(out)]
    assert main(["whatif", *grown]) == 0
    assert "tmm meets it: modelling error 2.3 %" in capsys.readouterr().err
    assert main(["whatif", *grown, "--model", "tmm"]) == 0
    assert "meets it" not in capsys.readouterr().err
    assert not read_statement(out).by_accuracy


@pytest.mark.heavy
def test_by_the_real_ladder_on_coarse_bricks(monkeypatch):
    monkeypatch.setattr(solid, "LEVELS", QUICK)
    statement, choice = under_contract(stated("bimorph.length=14mm:18mm:3", sets=["accuracy=50%"]))
    assert statement.models == ("lumped",)
    ladder = [rung.model for rung in choice.ladders[0]]
    assert ladder == ["lumped", "tmm", "calibrated", "solid"]
    assert choice.scenes == 3


def statement(*vary, models=("solid",)):
    values, _ = scene_values("prototype", ["accuracy=0.1", "modes=1"])
    return Statement("prototype", values, vary, models, ("short_circuit_frequencies",))


@pytest.mark.heavy
def test_a_surrogate_is_named_and_what_it_is_made_from_counted(own_store, monkeypatch):
    """And the plan says of each point what the run then does with it."""
    monkeypatch.setattr(solid, "LEVELS", QUICK)
    asked = statement("bimorph.length=14mm:18mm:12")
    (before,) = plan_study(asked)
    assert (before.points, before.kept, before.solved) == (12, 0, 9)
    (said,) = before.interpolated
    assert said.startswith("solid: 12 points differ in bimorph.length only")
    counts = run_study(asked, 1).counts
    assert (counts["computed"], counts["interpolated"]) == (9, 12)
    (after,) = plan_study(asked)
    assert (after.kept, after.solved) == (9, 0)


def test_what_is_solved_alone_kept_or_refused_is_counted(own_store):
    asked = statement("bimorph.length=14mm,16mm", "coil.current=1mA,2mA", models=("tmm", "solid"))
    tmm, solids = plan_study(asked)
    assert (tmm.points, tmm.solved, tmm.kept, tmm.refused) == (4, 2, 0, 0)
    assert tmm.sentences == ("tmm: 4 points, 2 to be solved, a fraction of a second each",)
    assert (solids.solved, solids.interpolated, solids.seconds) == (2, (), None)
    assert "2 to be solved, cost not recorded yet" in solids.sentences[0]
    both = replace(asked, models=("tmm", "network"), quantities=(*asked.quantities, "coenergy"))
    assert [model.solved for model in plan_study(both)] == [2, 2]
    run_study(statement("bimorph.length=14mm", models=("tmm",)))
    (tmm,) = plan_study(statement("bimorph.length=14mm,16mm,1um", models=("tmm",)))
    assert (tmm.solved, tmm.kept, tmm.refused) == (1, 1, 1)


def test_plan_of_a_study(own_store, capsys):
    asked = ["plan", "prototype", "--vary", "bimorph.length=14mm:18mm:12", "--model", "solid",
             "--quantity", "short_circuit_frequencies"]  # fmt: skip
    assert main(asked) == 0
    assert "are interpolated between 9 solutions" in capsys.readouterr().out
    assert main([*asked, "--json"]) == 0
    (model,) = json.loads(capsys.readouterr().out)["study"]
    assert (model["model"], model["points"], model["solved"]) == ("solid", 12, 9)


@pytest.mark.parametrize(
    ("command", "vary", "words"),
    [
        ("plan", "bimorph.length=14mm:22mm:3", "none of the 3 points makes a scene: frequency = "),
        ("whatif", "bimorph.length=14mm", "the only point makes no scene: frequency = "),
    ],
)
def test_points_of_which_none_makes_a_scene_are_refused_alike(command, vary, words, capsys):
    asked = [command, "--vary", vary, "--model", "tmm", "--frequency", "abc"]
    assert main(asked) == 2
    out, err = capsys.readouterr()
    assert (out, err.count("\n")) == ("", 1)
    assert words in err
