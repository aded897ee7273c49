"""The accuracy contract: the cheapest model whose known error meets it, or a refusal."""

import json

import pytest

from tactgen.geometry.errors import InputError
from tactgen.validation.catalogue.models import MODELS
from tactgen.validation.command_line.cli import main
from tactgen.validation.engine.comparison import choose, ladder
from tactgen.validation.engine.solve import record, recorded, solve
from tactgen.validation.models.bimorph import solid
from tactgen.validation.scene.load import load_scene

STATIC = ("static_tip_displacement",)


def scene_with(accuracy):
    return load_scene("j1", [f"accuracy={accuracy}"])[0]


def test_the_model_form_covers_the_difference():
    """What a rung says is the modelling error, which reaches the solid's answer."""
    scene = scene_with("10%")
    rungs = {rung.model: rung for rung in ladder((scene,), "bimorph", STATIC)}
    beam = solve(scene, ("tmm",), STATIC).quantities[0]
    assert rungs["tmm"].form == pytest.approx(float(beam.modelling_error / abs(beam.value)))
    assert rungs["calibrated"].form < 0.2 * rungs["tmm"].form
    assert rungs["solid"].form == 0.0
    # what the beam leaves out of this wide short bimorph is percents, not more
    assert 0.01 < rungs["tmm"].form < 0.1
    # job J1's converged deflection lies where the rung says it does
    truth = solve(load_scene("j1", ["mesh.level=2"])[0], ("solid",), STATIC).quantities[0].value
    assert abs(beam.value - truth) <= (rungs["tmm"].form + rungs["tmm"].numerical) * abs(beam.value)


def test_what_no_model_meets_is_refused():
    with pytest.raises(InputError, match=r"no model meets accuracy = 1e-07: lumped does not"):
        choose((scene_with("1e-7"),), STATIC)
    assert MODELS["solid"].finest == solid._BRICK_BARS[-1]


def test_a_model_that_takes_only_some_of_the_scenes_is_left_out():
    """Beams take no bimorph that is shorter than it is thick; the judge takes both."""
    lengths = ("0.6mm", "14mm")
    scenes = [load_scene("j1", ["accuracy=50%", f"bimorph.length={l}"])[0] for l in lengths]
    assert [rung.model for rung in choose(scenes, STATIC).ladders[0]] == ["solid"]
    assert choose(scenes[1:], STATIC).models == ("lumped",)


def test_costs_are_written_down(own_store):
    """What takes long is there for the next plan; a small change is not worth a file."""
    for costs, kept in (
        ({}, {}), ({"solid.static": 2.0, "tmm.static": 1e-4}, {"solid.static": 2.0}),
        ({"solid.static": 2.1, "solid.mesh": 0.5}, {"solid.static": 2.1, "solid.mesh": 0.5}),
    ):  # fmt: skip
        record(costs)
        assert recorded() == kept
    (own_store / "costs.kept").write_bytes(b"damaged")
    assert recorded() == {}


def test_the_plan_takes_what_solve_takes(capsys, own_store):
    """Models and quantities by option; what is kept is known."""
    asked = ("prototype", "--model", "beam", "--quantity", "capacitance_free", "--json")
    for kept in (False, True):
        assert main(["plan", *asked]) == 0
        (step,) = json.loads(capsys.readouterr().out)["plan"]["run"]
        assert (step["stage"], step["kept"]) == ("beam.static", kept)
        assert main(["solve", *asked]) == 0
        capsys.readouterr()


def test_solve_under_the_contract(capsys):
    """No model named and an accuracy stated: one model answers, and why is on stderr."""
    asked = ("j1", "--set", "accuracy=10%", "--quantity", *STATIC, "--json")
    assert main(["solve", *asked]) == 0
    captured = capsys.readouterr()
    assert [q["model"] for q in json.loads(captured.out)["quantities"]] == ["lumped"]
    assert "lumped meets it" in captured.err
    assert main(["plan", *asked]) == 0
    (rungs,) = json.loads(capsys.readouterr().out)["ladders"]
    assert [rung["model"] for rung in rungs] == ["lumped", "tmm", "calibrated", "solid"]
