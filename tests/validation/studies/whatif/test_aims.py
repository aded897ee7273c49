"""Aims: what is met, what is best, and what their small language refuses."""

from types import SimpleNamespace

import numpy as np
import pytest

from tactgen.geometry.errors import InputError
from tactgen.validation.catalogue.detection import DISPLAY_THRESHOLD
from tactgen.validation.command_line.cli import main
from tactgen.validation.engine.answers import Answer
from tactgen.validation.models.model import Quantity
from tactgen.validation.scene.load import scene_values
from tactgen.validation.studies.whatif.aim_evaluation import (
    Judged,
    Verdict,
    as_values,
    judged,
    margin_in_words,
    pareto,
    parse_aims,
    sentences,
    verdicts,
    yield_interval,
)
from tactgen.validation.studies.whatif.aims import at_threshold, parse_aim
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
        (
            "first(short_circuit_frequencies) - 2 * 150 Hz < max_over(short_circuit_frequencies)",
            800.0,
        ),
        ("max_over(short_circuit_frequencies)/first(short_circuit_frequencies) >= 25 %", 2.0),
        ("sqrt(first(short_circuit_frequencies) / 1 Hz) >= -(3 - 5)", 18.0),
        ("mean_over(short_circuit_frequencies) >= 650 Hz", 0.0),
        ("minimise first(short_circuit_frequencies)", -400.0),
        ("maximize abs(first(tip_displacement))", 4e-6),
    ],
)
def test_aims_mean_what_they_say(text, margin):
    """Arithmetic, precedence, functions, magnitudes, units, and what has no value left out."""
    assert parse_aim(text).margin(KNOWN) == pytest.approx(margin, rel=1e-12, abs=1e-12)


def test_an_aim_carries_the_error_bars():
    """A ratio of two numbers: the larger change of each, added."""
    aim = parse_aim("first(short_circuit_frequencies) / first(tip_displacement) >= 0 Hz/um".replace(
        " Hz/um", " Hz / 1 um"))  # fmt: skip
    _, bar = aim.margin_with_bar(KNOWN)
    assert bar == pytest.approx(2.0 / 4e-6 + 400.0 * (1 / 3.9e-6 - 1 / 4e-6), rel=1e-9)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("", "is not an arithmetic expression"),
        ("tip_displacement", "has no comparison"),
        ("min_over(tip_displacment) > 1 um", 'did you mean "tip_displacement"'),
        ("min_over(tip_displacement > 1 um", "is not an arithmetic expression"),
        ("min_over(tip_displacement) > 1 parrot", 'unknown unit "parrot"'),
        ("min_over(tip_displacement) > __import__", 'names "__import__"'),
        ("1 > 2", "names neither quantity nor scene key"),
        ("minimise bimorph.wiring", "bimorph.wiring, which is a choice"),
        ("minimise bimorph.lenght", 'did you mean "bimorph.length"'),
        ("first(dynamic_stiffness) > 1", "no common unit"),
        ("first(tip_displacement) ** 2 >= 1", "has a part that is not an arithmetic expression"),
        ("(" * 999 + "tip_displacement" + ")" * 999 + " > 1 um", "is not an arithmetic expression"),
        ("-" * 9999 + "tip_displacement > 1 um", "is not an arithmetic expression"),
        (f"tip_displacement > 1{400 * '0'}", "is not an arithmetic expression"),
    ],
)
def test_what_is_no_aim_is_refused(text, words):
    with pytest.raises(InputError) as caught:
        parse_aim(text)
    assert words in str(caught.value)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("first(tip_displacement) / (2 um + 2) >= 1", "write units that fit"),
        ("tip_displacement >= 2 um", "leaves 4 values where one is wanted"),
    ],
)
def test_units_and_shapes_are_checked(text, words):
    with pytest.raises(InputError, match=words):
        parse_aim(text).margin(KNOWN)


@pytest.mark.filterwarnings("error")
def test_a_point_where_a_divisor_is_0_has_no_margin():
    """Nor do two of the ones by which a unit is found, where their difference divides."""
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
    assert [one.near(0) for one in met.judged] == [True, False]
    for one, at in zip(met.judged, found.answers, strict=True):
        assert one.modelling == pytest.approx([at["tmm"].quantities[0].modelling_error], rel=1e-6)
        assert one.values["modelling_errors"] == list(one.modelling)
    said = sentences(found, [met])
    assert any("than the modelling error: 1 of 2 points" in line for line in said)
    assert f"(± {1e9 * met.judged[1].modelling[0]:.2g} nm)" in said[-2]


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
    found = study(
        "gap=100um,200um", models=("tmm", "network"),
        quantities=("magnetic_force", "static_tip_displacement"),
    )  # fmt: skip
    (both,) = verdicts(found, parse_aims(["magnetic_force / static_tip_displacement > 0 N / 1 m"]))
    assert (both.models, len(both.judged)) == ("tmm with network", 2)


def test_the_command_says_yield_and_best(capsys, tmp_path):
    """What the aim names is asked for; the picture is written."""
    picture = tmp_path / "study.svg"
    code = main([
        "whatif", "prototype", "--vary", "bimorph.length=normal(20mm,2%)", "--sample", "8",
        "--quantity", "capacitance_free", "--aim", "static_tip_displacement >= 0.98 um",
        "--plot", str(picture),
    ])  # fmt: skip
    out = capsys.readouterr().out
    assert code == 0
    found = study("bimorph.length=normal(20mm,2%)", samples=8)
    met = sum(a.quantities[0].value >= 0.98e-6 for _, _, a in found.rows)
    assert 0 < met < 8
    assert f"tmm: {met} of 8 points meet static_tip_displacement >= 0.98 um: a yield of" in out
    assert picture.read_text().startswith("<svg")


@pytest.mark.parametrize(
    ("text", "margin", "words"),
    [
        ("minimise 2 * magnetic_force", -18.6e-3, "18.60 ± 0.10 mN"),
        ("min_over(tip_displacement / threshold) >= 1", 0.5, "margin 0.50 ± 0.10"),
        ("min_over(tip_displacement - threshold) >= 2 um", -2e-6, "margin -2.00 ± 0.10 µm"),
        (
            "magnetic_force * static_tip_displacement <= 1 nJ",
            5.0,
            "margin 5.00 ± 0.10 kg*m**2/s**2",
        ),
    ],
)
def test_margins_carry_the_unit_of_what_is_compared(text, margin, words):
    """As a quantity has it; where none named has it, in base units without a prefix."""
    bar = {"1": 0.1, "N": 0.1e-3, "m": 0.1e-6}
    aim = parse_aim(text)
    judged = Judged(0, "tmm", ((margin, bar.get(aim.unit, 0.1)),))
    assert margin_in_words(aim, judged, 0) == words
    # five digits and no bar, where the bar is in none of them
    force, judged = (
        parse_aim("minimise magnetic_force"),
        Judged(0, "tmm", ((-18.6123456e-3, 1e-12),), (1e-3,)),
    )
    assert margin_in_words(force, judged, 0) == "18.612 mN (± 1 mN)"


def test_keys_of_a_scene_are_values_of_a_point():
    """Varied or not, a layer's size too; with the unit of their kind, and without error."""
    values, _ = scene_values("prototype", ["bimorph.layers=brass 0.3 mm; PZT-5A 0.2 mm to 9 mm +x"])
    statement = Statement("study", values, (), ("tmm",), (), samples=1)
    aims = [
        parse_aim("minimise bimorph.length * bimorph.width"),
        parse_aim("bimorph.layers.2.end/bimorph.length<=50 %"),
    ]
    (found,) = judged(statement, aims, 0, {"bimorph.length": 18e-3}, {"tmm": Answer("ok", "")})
    assert [margin for margin, _ in found.margins] == pytest.approx([-18e-3 * 2.1e-3, 0.0])
    assert [bar for _, bar in found.margins] == [0.0, 0.0]
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
    points = tuple(Judged(n, "tmm", ((10.0 * n, 0.5),)) for n in range(7))
    study = SimpleNamespace(
        points=[{"gap": 1e-4 * n} for n in range(7)], statement=SimpleNamespace(samples=7)
    )
    verdict = Verdict("tmm", (condition,), points, points[6:], points[:1], points[6:])
    found = sentences(study, [verdict])
    ends = yield_interval(1, 7)
    low, high = (100.0 * end for end in ends)
    assert found[0].startswith("tmm: 1 of 7 points meet first(short_circuit_frequencies) > 0.5 kHz")
    assert f"{low:.3g} to {high:.3g} %" in found[0]
    assert "nearer to the edge" in found[1]
    assert "gap = 0.6 mm: margin 60.00 ± 0.50 Hz" in found[-1]
    (only,) = sentences(study, [])
    assert only.startswith("no point can be judged: ")
    said = as_values(study, verdict)
    assert (said["aims"], said["models"]) == ([condition.text], "tmm")
    assert (said["judged"], said["met"], said["undecided"]) == (7, 1, 1)
    assert said["yield_interval_95"] == list(ends)
    at = {"gap": pytest.approx(6e-4)}
    assert said["best"] == [{"at": at, "margins": [60.0], "bars": [0.5], "peaks": []}]
    study.statement.samples = 0
    assert as_values(study, verdict)["yield_interval_95"] is None
