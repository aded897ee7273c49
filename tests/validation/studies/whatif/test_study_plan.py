"""The plan of a study: what is kept, what a reduced basis gives and costs, what is solved alone."""

import json

import pytest

from tactgen.geometry.bimorph.bimorph_bricks import BrickMeshing
from tactgen.geometry.errors import InputError
from tactgen.validation.command_line.cli import main
from tactgen.validation.engine.costs import recorded
from tactgen.validation.models.bimorph import solid
from tactgen.validation.models.bimorph.family import solid_family
from tactgen.validation.scene.scene import scene_values
from tactgen.validation.studies.whatif import study_plan, sweep
from tactgen.validation.studies.whatif.asked.statement import Statement
from tactgen.validation.studies.whatif.run import run_study
from tactgen.validation.studies.whatif.study_plan import plan_study

QUICK = (
    BrickMeshing((2, 2, 2), smallest=1.0, tip=1.0, longest=20.0, pieces=(2.0, 4.0)),
    BrickMeshing((2, 2, 3), smallest=0.5, tip=1.0, longest=20.0, pieces=(2.0, 4.0)),
)


def statement(*vary, models=("solid",)):
    values, _ = scene_values("prototype", ["accuracy=0.1", "modes=1"])
    return Statement("prototype", values, vary, models, ("short_circuit_frequencies",))


def test_a_basis_is_named_with_its_cost_before_and_after(own_store, monkeypatch):
    """And the plan says of each point what the run then does with it."""
    for module in (solid, solid_family):
        monkeypatch.setattr(module, "LEVELS", QUICK)
    asked = statement("bimorph.length=14mm:18mm:9")
    (before,) = plan_study(asked)
    (basis,) = before.bases
    assert (basis.points, basis.kept, basis.seconds, before.alone) == (9, False, None, 0)
    assert "9 points differ in bimorph.length only, and more than 8" in basis.sentence
    assert "not built yet; what it costs is not recorded yet" in basis.sentence
    counts = run_study(asked, 1).counts
    assert counts.together == basis.points
    assert recorded()["solid.family of 1 keys"] > 0.0
    (after,) = plan_study(asked)
    assert after.bases[0].kept
    assert after.bases[0].sentence.endswith("which is kept")
    (wider,) = plan_study(statement("bimorph.length=14mm:19mm:9"))
    (basis,) = wider.bases
    assert not basis.kept
    assert f"about {recorded()['solid.family of 1 keys']:.2g} s, once" in basis.sentence
    # the same points as a part that is read off in blocks
    monkeypatch.setattr(sweep, "MANY", 9)
    (blocks,) = plan_study(asked)
    assert blocks.bases[0].reason.endswith("are read off one reduced basis")
    assert (blocks.bases[0].kept, blocks.alone) == (True, 0)


def test_what_is_solved_alone_kept_or_refused_is_counted(own_store):
    asked = statement("bimorph.length=14mm,16mm", "coil.current=1mA,2mA", models=("tmm", "solid"))
    tmm, solids = plan_study(asked)
    assert (tmm.points, tmm.alone, tmm.kept, tmm.refused) == (4, 2, 0, 0)
    assert tmm.sentences == ("tmm: 4 points, 2 solved one by one, a fraction of a second each",)
    assert (solids.alone, solids.bases, solids.seconds) == (2, (), None)
    assert "2 solved one by one, cost not recorded yet" in solids.sentences[0]
    run_study(statement("bimorph.length=14mm", models=("tmm",)))
    (tmm,) = plan_study(statement("bimorph.length=14mm,16mm,1um", models=("tmm",)))
    assert (tmm.alone, tmm.kept, tmm.refused) == (1, 1, 1)


def test_plan_of_a_study(own_store, capsys):
    asked = ["plan", "prototype", "--vary", "bimorph.length=14mm:18mm:9", "--model", "solid",
             "--quantity", "short_circuit_frequencies"]  # fmt: skip
    assert main(asked) == 0
    said = capsys.readouterr().out
    assert said.startswith("study of prototype: 9 points over bimorph.length\nsolid: 9 points\n")
    assert "reduced basis, which is not built yet" in said
    assert main([*asked, "--json"]) == 0
    (model,) = json.loads(capsys.readouterr().out)["study"]
    assert (model["model"], model["bases"][0]["points"]) == ("solid", 9)


@pytest.mark.parametrize(
    ("vary", "words"),
    [("bimorph.lenght=1mm:2mm:3", "did you mean"), ("bimorph.length=2mm:1mm:3", "runs backwards")],
)
def test_refusals_as_of_the_study(vary, words, capsys):
    assert main(["plan", "prototype", "--vary", vary]) == 2
    assert words in capsys.readouterr().err


def test_one_point_is_one(own_store, capsys):
    assert main(["plan", "paper", "--vary", "bimorph.length=14mm", "--model", "tmm"]) == 0
    said = capsys.readouterr().out
    assert said.startswith("study of paper: 1 point over bimorph.length\ntmm: 1 point, 1 solved")


@pytest.mark.parametrize(
    ("vary", "words"),
    [
        ("bimorph.length=14mm:22mm:3", "none of the 3 points makes a scene: frequency = "),
        ("bimorph.length=14mm", "the only point makes no scene: frequency = "),
    ],
)
@pytest.mark.parametrize("command", ["plan", "whatif"])
def test_points_of_which_none_makes_a_scene_are_refused_alike(command, vary, words, capsys):
    asked = [command, "--vary", vary, "--model", "tmm", "--frequency", "abc"]
    assert main(asked) == 2
    out, err = capsys.readouterr()
    assert (out, err.count("\n")) == ("", 1)
    assert words in err


@pytest.mark.parametrize("many", [9, 1000], ids=["in blocks", "as a family"])
def test_points_of_a_basis_that_cannot_be_built_are_counted_alone(own_store, monkeypatch, many):
    """At so many times what one of them takes."""

    def refused(*_):
        raise InputError("the range is too wide")

    monkeypatch.setattr(sweep, "MANY", many)
    monkeypatch.setattr(study_plan, "_basis", refused)
    monkeypatch.setattr(study_plan, "total", lambda prospects: 2.5)
    (planned,) = plan_study(statement("bimorph.length=14mm:18mm:9"))
    assert (planned.bases, planned.alone, planned.seconds) == ((), 9, 9 * 2.5)
