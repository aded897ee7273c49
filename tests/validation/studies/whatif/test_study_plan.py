"""The plan of a study: what is kept, what is interpolated, what is solved."""

import json
from dataclasses import replace

import pytest

from tactgen.geometry.bimorph.bricks import BrickMeshing
from tactgen.validation.command_line.cli import main
from tactgen.validation.models.bimorph import solid
from tactgen.validation.scene.load import scene_values
from tactgen.validation.studies.whatif.definition import Statement
from tactgen.validation.studies.whatif.study import plan_study, run_study

QUICK = (
    BrickMeshing((2, 2, 2), smallest=1.0, tip=1.0, longest=20.0, pieces=(2.0, 4.0)),
    BrickMeshing((2, 2, 3), smallest=0.5, tip=1.0, longest=20.0, pieces=(2.0, 4.0)),
)


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
    assert (counts.computed, counts.interpolated) == (9, 12)
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
    said = capsys.readouterr().out
    assert said.startswith(
        "study of prototype: 12 points over bimorph.length\nsolid: 12 points, 9 "
    )
    assert "are interpolated between 9 solutions" in said
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
