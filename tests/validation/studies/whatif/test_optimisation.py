"""A bounded search over any keys: optima known otherwise, least changes, ends, a surrogate."""

import json
import re
from types import SimpleNamespace

import numpy as np
import pytest

from tactgen.geometry.bimorph.bricks import BrickMeshing
from tactgen.validation.command_line import cli
from tactgen.validation.engine.solve import solve
from tactgen.validation.models.bimorph import solid
from tactgen.validation.scene.load import load_scene
from tactgen.validation.studies.whatif import optimisation as points
from tactgen.validation.studies.whatif.optimisation import Range

QUICK = (
    BrickMeshing((2, 2, 2), smallest=1.0, tip=1.0, longest=20.0, pieces=(2.0, 4.0)),
    BrickMeshing((2, 2, 3), smallest=0.5, tip=1.0, longest=20.0, pieces=(2.0, 4.0)),
)
LONG = "bimorph.length=10mm:20mm"


def design(capsys, *arguments):
    assert cli.main(["design", "prototype", *arguments, "--set", "modes=1", "--json"]) == 0
    return json.loads(capsys.readouterr().out)


def by_tmm(*sets, quantity):
    return solve(load_scene("prototype", list(sets))[0], ("tmm",), (quantity,)).quantities[0].value


@pytest.mark.heavy
def test_the_goal_ends_at_the_condition(capsys):
    """Deflection rises and frequency falls with length, so the condition decides."""
    found = design(capsys, "--vary", LONG, "--aim", "maximise static_tip_displacement",
                   "--aim", "first(short_circuit_frequencies) >= 700 Hz")  # fmt: skip
    assert found["met"]
    assert found["ends"] == []
    length = found["best"]["at"]["bimorph.length"]
    own = by_tmm(f"bimorph.length={length!r} m", quantity="short_circuit_frequencies")[0]
    # a hundred-thousandth of 10 mm, at 70 Hz/mm
    assert 700.0 <= own <= 700.02


@pytest.mark.heavy
def test_two_keys_with_an_optimum_inside(capsys):
    """The shim at which the deflection under an area of cross-section is largest."""
    found = design(
        capsys, "--vary", "bimorph.shim_thickness=0.05mm:0.4mm:log",
        "--vary", "bimorph.piezo_thickness=0.1mm:0.4mm", "--aim", "maximise blocked_force",
        "--aim", "static_tip_displacement >= 0.4 um", "--set", "frequency=1",
    )  # fmt: skip
    assert found["met"]
    best = found["best"]
    rng = np.random.default_rng(5)
    for shim, piezo in rng.uniform([0.05, 0.1], [0.4, 0.4], (25, 2)):
        sets = [f"bimorph.shim_thickness={shim} mm", f"bimorph.piezo_thickness={piezo} mm"]
        if by_tmm(*sets, quantity="static_tip_displacement") >= 0.4e-6:
            force = np.abs(by_tmm(*sets, "frequency=1", quantity="blocked_force"))[0]
            assert force <= best["margins"][0] * (1.0 + 1e-6)


@pytest.mark.heavy
def test_without_a_goal_the_least_change_is_found(capsys):
    """The prototype has 782 Hz at 14 mm; 700 Hz or less is met from 15 mm on."""
    found = design(capsys, "--vary", LONG, "--model", "lumped",
                   "--aim", "first(short_circuit_frequencies) <= 700 Hz")  # fmt: skip
    assert found["present"]["at"]["bimorph.length"] == pytest.approx(14e-3)
    assert 0.0 <= found["best"]["margins"][0] <= 0.02


def test_what_cannot_be_met_is_said_with_what_comes_nearest(capsys):
    """Before is the scene's own, though 14 mm lie outside the ranges."""
    aim = ["--aim", "static_tip_displacement >= 5 um", "--vary", "bimorph.length=15mm:20mm"]
    assert cli.main(["design", "prototype", "--model", "lumped", *aim]) == 0
    out = capsys.readouterr().out
    own = solve(load_scene("prototype", [])[0], ("lumped",), ("static_tip_displacement",))
    assert out.startswith("Conditions: base on springs")
    assert "No point of the ranges meets all aims by lumped; this one comes nearest" in out
    assert "bimorph.length = 20 mm" in out
    margins = r">= 5 um: margin -4\.0\d+ µm \(± .*\); before: margin (-4\.5\d+) µm \(± .*\)"
    before = float(re.search(margins, out)[1])
    assert before == pytest.approx(1e6 * abs(own.quantities[0].value) - 5.0, rel=1e-4)


def test_ranges_without_any_answer_are_refused(capsys):
    """As a what-if of the same points would give none; the first reason is said."""
    asked = ["--vary", LONG, "--aim", "maximise static_tip_displacement", "--set", "load.kind=none"]
    given = SimpleNamespace(judged=None, reason="no such piezo", at={})
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(points.Points, "ask", lambda self, shares: [given] * len(shares))
        assert cli.main(["design", "prototype", *asked]) == 2
    said = capsys.readouterr().err
    assert said == "tactgen: no point of the ranges has an answer: no such piezo\n"


@pytest.mark.heavy
def test_the_solid_is_searched_on_one_surrogate(capsys, own_store, monkeypatch):
    monkeypatch.setattr(solid, "LEVELS", QUICK)
    found = design(capsys, "--vary", LONG, "--model", "solid", "--aim", "capacitance_free <= 9 nF",
                   "--set", "accuracy=0.1", "--set", "modes=1")  # fmt: skip
    assert found["met"]
    assert found["interpolated"] == found["points"]
    assert found["best"]["margins"][0] <= 1e-13


def test_the_normal_actuator_by_its_quick_model(capsys):
    assert cli.main(["design", "reluctance", "--vary", "gap=0.1mm:0.4mm", "--aim",
                     "magnetic_force >= 150 mN", "--json"]) == 0  # fmt: skip
    found = json.loads(capsys.readouterr().out)
    assert (found["models"], found["met"]) == (["network"], True)
    assert 0.1e-3 < found["best"]["at"]["gap"] < found["present"]["at"]["gap"] == 0.2e-3


def test_ends_of_a_range_are_exact():
    by_ratio = Range("gap", 1e-4, 3e-3, logarithmic=True)
    assert (by_ratio.at(0.0), by_ratio.at(1.0)) == (1e-4, 3e-3)
    assert by_ratio.share(by_ratio.at(0.3)) == pytest.approx(0.3, abs=1e-12)
    assert by_ratio.share(1.0) == 1.0
