"""Aims: what is met, what is best, what their language refuses, and a bounded search for them."""

import json
import re
from types import SimpleNamespace

import numpy as np
import pytest

from tactgen.geometry.bimorph.bricks import BrickMeshing
from tactgen.geometry.errors import InputError
from tactgen.validation.catalogue.detection import DISPLAY_THRESHOLD
from tactgen.validation.command_line.cli import main
from tactgen.validation.engine.answers import Answer
from tactgen.validation.engine.solve import solve
from tactgen.validation.models.bimorph import solid
from tactgen.validation.models.model import Quantity
from tactgen.validation.scene.load import load_scene, scene_values
from tactgen.validation.studies.whatif import optimisation
from tactgen.validation.studies.whatif.aim_evaluation import (
    Judged,
    Verdict,
    as_values,
    judged,
    pareto,
    parse_aims,
    sentences,
    verdicts,
    yield_interval,
)
from tactgen.validation.studies.whatif.aims import Margin, at_threshold, parse_aim
from tactgen.validation.studies.whatif.axes import Distribution
from tactgen.validation.studies.whatif.definition import Statement
from tactgen.validation.studies.whatif.study import run_study


def quantity(name, value, unit, error=0.0, frequency=None):
    value = np.asarray(value)
    bars = np.full(value.shape, error)
    return Quantity(value, bars, name=name, model="tmm", unit=unit, frequency=frequency)


#: Thresholds at these frequencies are 2, 0.2 and 1 um; outside them there is none.
TIP = quantity(
    "tip_displacement", [4e-6, 3e-6j, -5e-6, 1.0], "m", 1e-7, (10.0, 250.0, 1000.0, 2000.0)
)
MODES = quantity("short_circuit_frequencies", [400.0, 900.0], "Hz", 2.0)
KNOWN = at_threshold(
    {"tip_displacement": TIP, "short_circuit_frequencies": MODES}, DISPLAY_THRESHOLD
)


@pytest.mark.parametrize(
    ("text", "margin"),
    [
        ("min_over(tip_displacement / threshold) >= 1", 1.0),
        ("min_over(tip_displacement / threshold) <= 1.5", -0.5),
        ("first(short_circuit_frequencies) > 0.5 kHz", -100.0),
        ("first(short_circuit_frequencies) - 2 * 150 Hz < max_over(short_circuit_frequencies)",
         800.0),
        ("max_over(short_circuit_frequencies)/first(short_circuit_frequencies) >= 25 %", 2.0),
        ("sqrt(first(short_circuit_frequencies) / 1 Hz) >= -(3 - 5)", 18.0),
        ("mean_over(short_circuit_frequencies) >= 650 Hz", 0.0),
        ("minimise first(short_circuit_frequencies)", -400.0),
        ("maximize abs(first(tip_displacement))", 4e-6),
    ],
)  # fmt: skip
def test_aims_mean_what_they_say(text, margin):
    """Arithmetic, precedence, functions, magnitudes, units, and what has no value left out."""
    assert parse_aim(text).margin(KNOWN) == pytest.approx(margin, rel=1e-12, abs=1e-12)


def test_an_aim_carries_the_error_bars():
    """A ratio of two numbers: the larger change of each, added."""
    aim = parse_aim("first(short_circuit_frequencies) / first(tip_displacement) >= 0 Hz / 1 um")
    bar = aim.judged(KNOWN).bar
    assert bar == pytest.approx(2.0 / 4e-6 + 400.0 * (1 / 3.9e-6 - 1 / 4e-6), rel=1e-9)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("", "is not an arithmetic expression"),
        ("tip_displacement", "has no comparison"),
        ("min_over(tip_displacment) > 1 um", 'did you mean "tip_displacement"'),
        ("min_over(tip_displacement) > 1 parrot", 'unknown unit "parrot"'),
        ("min_over(tip_displacement) > __import__", 'names "__import__"'),
        ("1 > 2", "names neither quantity nor scene key"),
        ("minimise bimorph.wiring", "bimorph.wiring, which is a choice"),
        ("first(dynamic_stiffness) > 1", "no common unit"),
        ("first(tip_displacement) ** 2 >= 1", "has a part that is not an arithmetic expression"),
        ("-" * 9999 + "tip_displacement > 1 um", "is not an arithmetic expression"),
        (f"tip_displacement > 1{400 * '0'}", "is not an arithmetic expression"),
        ("(" * 999 + "tip_displacement" + ")" * 999 + " > 1 um", "is not an arithmetic expression"),
    ],
)
def test_what_is_no_aim_is_refused(text, words):
    with pytest.raises(InputError, match=re.escape(words)):
        parse_aim(text)


@pytest.mark.filterwarnings("error")
def test_units_and_shapes_are_checked_and_a_divisor_of_0_has_no_margin():
    """Nor have two of the ones by which a unit is found, where their difference divides."""
    for text, words in (
        ("first(tip_displacement) / (2 um + 2) >= 1", "write units that fit"),
        ("tip_displacement >= 2 um", "leaves 4 values where one is wanted"),
    ):
        with pytest.raises(InputError, match=words):
            parse_aim(text).margin(KNOWN)
    none = {"static_tip_displacement": quantity("static_tip_displacement", 0.0, "m")}
    assert parse_aim("1 um / static_tip_displacement >= 1").margin(none) == np.inf
    assert parse_aim("1 / (static_tip_displacement - 1 m) > 0 / 1 m").unit == "1/m"


def test_pareto_takes_what_cannot_be_bettered():
    """A lead within the error bars is none."""
    first = [(3.0, 0.0), (2.0, 0.0), (2.5, 0.0), (1.0, 0.0)]
    second = [(1.0, 0.1), (2.0, 0.1), (1.15, 0.1), (1.9, 0.1)]
    assert pareto(first, second) == [0, 1]
    exact = [(value, 0.0) for value, _ in second]
    assert pareto(first, exact) == [0, 2, 1]
    assert pareto([], []) == []


def test_the_interval_of_a_yield():
    """Wilson's interval as printed: Newcombe, Statistics in Medicine 17 (1998) 857, table I."""
    for met, of, low, high in ((81, 263, 0.2553, 0.3662), (15, 148, 0.0624, 0.1605),
                               (0, 20, 0.0, 0.1611), (1, 29, 0.0061, 0.1718)):  # fmt: skip
        np.testing.assert_allclose(yield_interval(met, of), (low, high), atol=5e-5)


def study(*vary, models=("tmm",), quantities=("static_tip_displacement",), **more):
    values, _ = scene_values("prototype", ["modes=1"])
    return run_study(Statement("prototype", values, vary, models, quantities, **more))


def test_conditions_and_goals_pick_points():
    """Longer bends more and is slower: the condition cuts, the goal orders, two make a front."""
    both = ("static_tip_displacement", "short_circuit_frequencies")
    found = study("bimorph.length=14mm:22mm:5", quantities=both)
    condition = "static_tip_displacement >= 0.7 um"
    goal = "maximise first(short_circuit_frequencies)"
    (met,) = verdicts(found, parse_aims([condition]))
    assert [one.number for one in met.met] == [2, 3, 4]
    assert [one.number for one in met.best] == [4, 3, 2]
    assert not met.undecided
    (best,) = verdicts(found, parse_aims([condition, goal]))
    assert [one.number for one in best.best] == [2, 3, 4]
    (front,) = verdicts(found, parse_aims([goal, "maximise static_tip_displacement"]))
    assert [one.number for one in front.best] == [0, 1, 2, 3, 4]
    with pytest.raises(InputError, match="more than two goals"):
        parse_aims([goal, goal, goal])


def test_a_margin_within_the_modelling_error_is_said():
    """5 % too much by beam theory: what lies that close to the edge the solid may see otherwise."""
    found = study("bimorph.length=18mm,22mm")
    (met,) = verdicts(found, parse_aims(["static_tip_displacement >= 0.78 um"]))
    assert [one.margins[0].near for one in met.judged] == [True, False]
    for one, at in zip(met.judged, found.answers, strict=True):
        off = at["tmm"].quantities[0].modelling_error
        assert one.values["modelling_errors"] == pytest.approx([off], rel=1e-6)
    said = sentences(found, [met])
    assert any("than the modelling error: 1 of 2 points" in line for line in said)
    assert f"(± {1e9 * met.judged[1].margins[0].modelling:.2g} nm)" in said[-2]


def test_each_model_has_a_verdict_of_its_own():
    """The limit lies between the first frequencies of two models: the one meets it, the other not.

    A yield is counted over the points, not over points times models.
    """
    lengths = "bimorph.length=normal(14mm,0.01%)"
    found = study(lengths, models=("tmm", "lumped"), quantities=("short_circuit_frequencies",),
                  samples=4)  # fmt: skip
    first = {m: [at[m].quantities[0].value[0] for at in found.answers] for m in ("tmm", "lumped")}
    assert max(first["tmm"]) < min(first["lumped"])
    limit = 0.5 * (max(first["tmm"]) + min(first["lumped"]))
    both = verdicts(found, parse_aims([f"first(short_circuit_frequencies) >= {limit} Hz"]))
    met = {one.models: (len(one.met), len(one.judged)) for one in both}
    assert met == {"tmm": (0, 4), "lumped": (4, 4)}
    assert as_values(found, both[1])["yield_interval_95"] == list(yield_interval(4, 4))


def test_an_aim_over_both_actuators():
    """No model gives both: one of each is taken together."""
    both = ("magnetic_force", "static_tip_displacement")
    found = study("gap=100um,200um", models=("tmm", "network"), quantities=both)
    (both,) = verdicts(found, parse_aims(["magnetic_force / static_tip_displacement > 0 N / 1 m"]))
    assert (both.models, len(both.judged)) == ("tmm with network", 2)


def test_the_command_says_yield_and_best(capsys, tmp_path):
    """What the aim names is asked for; the picture is written."""
    assert main([
        "whatif", "prototype", "--vary", "bimorph.length=normal(20mm,2%)", "--sample", "8",
        "--quantity", "capacitance_free", "--aim", "static_tip_displacement >= 0.98 um",
        "--plot", str(tmp_path / "a.svg"),
    ]) == 0  # fmt: skip
    said = r"tmm: [1-7] of 8 points meet static_tip_displacement >= 0.98 um: a yield of"
    assert re.search(said, capsys.readouterr().out)
    assert (tmp_path / "a.svg").read_text().startswith("<svg")


@pytest.mark.parametrize(
    ("text", "margin", "modelling", "words"),
    [
        ("minimise 2 * magnetic_force", -18.6e-3, 0.0, "18.60 ± 0.10 mN"),
        ("min_over(tip_displacement / threshold) >= 1", 0.5, 0.0, "margin 0.50 ± 0.10"),
        ("min_over(tip_displacement - threshold) >= 2 um", -2e-6, 0.0, "margin -2.00 ± 0.10 µm"),
        ("magnetic_force * static_tip_displacement <= 1 nJ", 5.0, 0.0,
         "margin 5.00 ± 0.10 kg*m**2/s**2"),
        ("minimise magnetic_force", -18.6e-3, 1e-3, "18.60 ± 0.10 mN (± 1 mN)"),
    ],
)  # fmt: skip
def test_margins_carry_the_unit_of_what_is_compared(text, margin, modelling, words):
    """As a quantity has it; where none named has it, in base units without a prefix."""
    aim, bar = parse_aim(text), {"N": 0.1e-3, "m": 0.1e-6}
    assert Margin(aim, margin, bar.get(aim.unit, 0.1), modelling).text == words


def test_keys_of_a_scene_are_values_of_a_point():
    """Varied or not, a layer's size too; with the unit of their kind, and without error."""
    values, _ = scene_values("prototype", ["bimorph.layers=brass 0.3 mm; PZT-5A 0.2 mm to 9 mm +x"])
    statement = Statement("study", values, (), ("tmm",), (), samples=1)
    aims = parse_aims(["minimise bimorph.length * bimorph.width",
                       "bimorph.layers.2.end/bimorph.length<=50 %"])  # fmt: skip
    (found,) = judged(statement, aims, 0, {"bimorph.length": 18e-3}, {"tmm": Answer("ok", "")})
    assert [m.value for m in found.margins] == pytest.approx([-18e-3 * 2.1e-3, 0.0])
    assert [m.bar for m in found.margins] == [0.0, 0.0]
    assert [aim.unit for aim in aims] == ["m**2", "1"]


def test_aims_with_keys_leave_out_what_is_no_scene(capsys):
    """Refused points are not judged, and tensors of models that are not asked do not matter."""
    aim = ["--aim", "maximise static_tip_displacement / bimorph.length", "--model", "lumped"]
    for key, values in (("bimorph.bare_above", "1mm,18mm"), ("piezo.d31", "-180pm/V,-600pm/V")):
        assert main(["whatif", "prototype", "--vary", f"{key}={values}", *aim]) == 0
        assert "best by lumped" in capsys.readouterr().out
    one = ["whatif", "prototype", "--vary", "bimorph.length=1um,20mm", "--model", "lumped"]
    assert main([*one, "--aim", "minimise bimorph.width"]) == 0
    assert "length = 0.001 mm" not in capsys.readouterr().out
    assert main([*one, "--aim", "minimise shim.transverse_modulus"]) == 2
    assert "set shim.transverse_modulus" in capsys.readouterr().err


def test_what_a_verdict_says():
    """In words and as plain values; an interval of the yield only of drawn devices."""
    condition = parse_aim("first(short_circuit_frequencies) > 0.5 kHz")
    points = tuple(Judged(n, "tmm", (Margin(condition, 10.0 * n, 0.5),)) for n in range(7))
    study = SimpleNamespace(
        points=[{"gap": 1e-4 * n} for n in range(7)], statement=SimpleNamespace(samples=7)
    )
    verdict = Verdict("tmm", (condition,), points, points[6:], points[:1], points[6:])
    found = sentences(study, [verdict])
    low, high = (100.0 * end for end in yield_interval(1, 7))
    assert f"{low:.3g} to {high:.3g} %" in found[0]
    assert "nearer to the edge" in found[1]
    assert "gap = 0.6 mm: margin 60.00 ± 0.50 Hz" in found[-1]
    (only,) = sentences(study, [])
    assert only.startswith("no point can be judged: ")
    said = as_values(study, verdict)
    assert (said["judged"], said["met"], said["undecided"]) == (7, 1, 1)
    at = {"gap": pytest.approx(6e-4)}
    assert said["best"] == [
        {"at": at, "margins": [60.0], "bars": [0.5], "peaks": [None], "modelling_errors": [0.0]}
    ]
    study.statement.samples = 0
    assert as_values(study, verdict)["yield_interval_95"] is None


QUICK = (
    BrickMeshing((2, 2, 2), smallest=1.0, tip=1.0, longest=20.0, pieces=(2.0, 4.0)),
    BrickMeshing((2, 2, 3), smallest=0.5, tip=1.0, longest=20.0, pieces=(2.0, 4.0)),
)
LONG = "bimorph.length=10mm:20mm"


def design(capsys, *arguments):
    assert main(["design", "prototype", *arguments, "--set", "modes=1", "--json"]) == 0
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
    assert main(["design", "prototype", "--model", "lumped", *aim]) == 0
    out = capsys.readouterr().out
    own = solve(load_scene("prototype", [])[0], ("lumped",), ("static_tip_displacement",))
    assert "No point of the ranges meets all aims by lumped; this one comes nearest" in out
    assert "bimorph.length = 20 mm" in out
    margins = r">= 5 um: margin -4\.0\d+ µm \(± .*\); before: margin (-4\.5\d+) µm \(± .*\)"
    before = float(re.search(margins, out)[1])
    assert before == pytest.approx(1e6 * abs(own.quantities[0].value) - 5.0, rel=1e-4)


def test_ranges_without_any_answer_are_refused(capsys, monkeypatch):
    """As a what-if of the same points would give none; the first reason is said."""
    given = SimpleNamespace(judged=None, reason="no such piezo", at={})
    monkeypatch.setattr(optimisation.Search, "ask", lambda self, shares: [given] * len(shares))
    aim = ["--vary", LONG, "--aim", "maximise static_tip_displacement"]
    assert main(["design", "prototype", *aim]) == 2
    said = "tactgen: no point of the ranges has an answer: no such piezo\n"
    assert capsys.readouterr().err == said


@pytest.mark.heavy
def test_the_solid_is_searched_on_one_surrogate(capsys, own_store, monkeypatch):
    monkeypatch.setattr(solid, "LEVELS", QUICK)
    found = design(capsys, "--vary", LONG, "--model", "solid", "--aim", "capacitance_free <= 9 nF",
                   "--set", "accuracy=0.1", "--set", "modes=1")  # fmt: skip
    assert found["met"]
    assert found["interpolated"] == found["points"]
    assert found["best"]["margins"][0] <= 1e-13


def test_the_normal_actuator_by_its_quick_model(capsys):
    assert main(["design", "reluctance", "--vary", "gap=0.1mm:0.4mm", "--aim",
                     "magnetic_force >= 150 mN", "--json"]) == 0  # fmt: skip
    found = json.loads(capsys.readouterr().out)
    assert (found["models"], found["met"]) == (["network"], True)
    assert 0.1e-3 < found["best"]["at"]["gap"] < found["present"]["at"]["gap"] == 0.2e-3


def test_ends_of_a_range_are_exact():
    by_ratio = Distribution("loguniform", 1e-4, 3e-3)
    assert (by_ratio.at(0.0), by_ratio.at(1.0)) == (1e-4, 3e-3)
    assert by_ratio.share(by_ratio.at(0.3)) == pytest.approx(0.3, abs=1e-12)
    assert by_ratio.share(1.0) == 1.0


@pytest.mark.parametrize(
    ("band", "says"),
    [("600:3000:9", lambda peak: 600.0 < peak.frequency < 3000.0 and not peak.at_end),
     ("200:600:9", lambda peak: peak == (600.0, True))],
)  # fmt: skip
def test_an_aim_says_where_its_peak_is_and_whether_the_band_ends_there(band, says):
    """Only what the searched largest value is taken of, however it is spaced."""
    names = ("circuit_power", "optimum_resistance", "optimum_power")
    scene, _ = load_scene("prototype", [
        "support.kind=clamped", "load.kind=none", "circuit.kind=load", f"frequency={band}",
        "circuit.resistance=20 kohm", "drive.base_acceleration=1 g",
    ])  # fmt: skip
    found = solve(scene, ("tmm",), names, modelling=False)
    known = {name: found.get(name, "tmm") for name in names}
    margin = parse_aim("maximise max_over( circuit_power )").judged(known)
    assert says(margin.peak)
    assert ("end of the band" in margin.text) == margin.peak.at_end
    assert parse_aim("maximise max_over(optimum_resistance)").judged(known).peak is None
    assert parse_aim("maximise mean_over(circuit_power)").judged(known).peak is None
