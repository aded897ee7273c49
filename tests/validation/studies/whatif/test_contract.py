"""Accuracy without a model in a study: judged once, at its edges, by what is worst there."""

import json

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

    def rungs(scene, actuator, quantities, announce, judge):
        asked.append(scene.bimorph.length)
        form = 0.02 * 14e-3 / scene.bimorph.length
        return (
            FidelityLevel("tmm", form, 0.0, 0.1, form <= scene.accuracy, "q"),
            FidelityLevel(judge, 0.0, scene.accuracy, None, scene.accuracy >= 1e-6, ""),
        )

    monkeypatch.setattr(ladders, "ladder", rungs)
    return asked


def test_judged_at_the_middle_and_the_ends_of_each_axis():
    points = judged_points(
        stated("bimorph.length=14mm:22mm:5", "load.kind=none,finger,mass", "modes=4,2,3")
    )
    assert points == [
        {"bimorph.length": length, "load.kind": load, "modes": modes}
        for length, load, modes in [
            (0.018, "finger", 2), (0.014, "finger", 2), (0.022, "finger", 2),
            (0.018, "none", 2), (0.018, "mass", 2), (0.018, "finger", 4),
        ]
    ]  # fmt: skip


def test_of_samples_the_least_and_the_largest_are_judged():
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
    """A study that is gone on with is judged anew, one with a model named is not."""
    monkeypatch.setattr(whatif, "_write", lambda *_: None)  # the pictures take longest
    out = tmp_path / "study"
    asked = ["--quantity", *STATIC, "--vary", "bimorph.length=14mm:18mm:3", "--out", str(out)]
    assert main(["whatif", "prototype", "--set", "accuracy=3%", *asked, "--json"]) == 0
    said = capsys.readouterr()
    answer = json.loads(said.out)
    assert {point["model"] for point in answer["points"]} == {"tmm"}
    assert [rung["model"] for rung in answer["ladders"][0]] == ["tmm", "solid"]
    assert said.err.count("tmm meets it: modelling error 2 %") == 1
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


def test_the_plan_of_a_study_says_which_model_its_accuracy_asks_for(forms, capsys):
    """In words beside what that model would do, and with what each model was found to miss."""
    asked = ["plan", "prototype", "--vary", "bimorph.length=14mm:22mm:5", "--set", "accuracy=3%",
             "--quantity", *STATIC]  # fmt: skip
    assert main(asked) == 0
    out, err = capsys.readouterr()
    assert "tmm meets it" in err
    assert out.startswith("study of prototype: 5 points")
    assert main([*asked, "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert [rung["model"] for rung in found["ladders"][0]] == ["tmm", "solid"]
