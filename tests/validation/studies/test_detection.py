"""The detection threshold as data, and the voltage that reaches it by every model."""

import json

import numpy as np
import pytest

from tactgen.geometry.device.parameters import Threshold
from tactgen.geometry.errors import InputError
from tactgen.validation.catalogue.detection import DISPLAY_THRESHOLD, threshold_of
from tactgen.validation.command_line.cli import main
from tactgen.validation.engine.solve import as_json, solve
from tactgen.validation.scene.load import load_scene, scene_values
from tactgen.validation.studies.whatif.aim_evaluation import parse_aims, verdicts
from tactgen.validation.studies.whatif.definition import Statement
from tactgen.validation.studies.whatif.study import run_study


def test_the_papers_points_are_joined_in_log_log():
    """Sections 6 and 7: starts around 2 um, 0.2 um at 250 Hz, 1 um at 1000 Hz.

    Halfway between two points in ln f is the geometric mean of their amplitudes.  nan below 10 Hz,
    at 0 Hz and above 1000 Hz; the ends, to rounding, have values.
    """
    f, level = np.array([10.0, 250.0, 1000.0]), np.array([2e-6, 0.2e-6, 1e-6])
    assert DISPLAY_THRESHOLD.at(f) == pytest.approx(level, rel=1e-12)
    middle = DISPLAY_THRESHOLD.at(np.sqrt(f[1:] * f[:-1]))
    assert middle == pytest.approx(np.sqrt(level[1:] * level[:-1]), rel=1e-12)
    values = DISPLAY_THRESHOLD.at(np.array([0.0, 9.999, 10.0, 1000.0 * (1 + 1e-15), 1001.0]))
    assert np.isfinite(values).tolist() == [False, False, True, True, False]


@pytest.fixture
def felt(tmp_path):
    """Twice the paper's threshold as a table, and what a scene says to use it."""
    path = tmp_path / "felt.csv"
    rows = [f"{p.frequency}, {2e6 * p.amplitude}" for p in DISPLAY_THRESHOLD.points]
    path.write_text("\n".join(["frequency (Hz), threshold (um)", *rows]) + "\n")
    return ("threshold.kind=table", f"threshold.file={path}")


@pytest.mark.parametrize(("model", "wiring"), [("tmm", "parallel"), ("beam", "series")])
def test_ratio_and_voltage_say_the_same(felt, model, wiring):
    """Ratio is |w| over the threshold, voltage is drive over ratio; twice the threshold, half."""
    names = ("tip_displacement", "detection_ratio", "threshold_voltage")

    def solved(*overrides):
        asked = [f"bimorph.wiring={wiring}", "frequency=10,100,940", "drive.voltage=3V"]
        found = solve(load_scene("paper", [*asked, *overrides])[0], (model,), names)
        return [found.get(name, model) for name in names]

    tip, ratio, voltage = solved()
    level = DISPLAY_THRESHOLD.at(np.array(tip.frequency))
    np.testing.assert_allclose(ratio.value, np.abs(tip.value) / level, rtol=1e-12)
    np.testing.assert_allclose(voltage.value * ratio.value, 3.0, rtol=1e-12)
    assert voltage.unit == "V"
    assert (voltage.error > 0.0).all()
    _, half, twice = solved(*felt)
    np.testing.assert_allclose(half.value, 0.5 * ratio.value, rtol=1e-12)
    np.testing.assert_allclose(twice.value, 2.0 * voltage.value, rtol=1e-12)


def test_design_asks_for_it(felt, capsys):
    """As much margin about twice the threshold as twice the margin about the paper's."""
    asked = ["design", "paper", "--json", "--lengths", "14mm:28mm"]
    assert main([*asked, "--margin", "2"]) == 0
    paper = json.loads(capsys.readouterr().out)
    overrides = [word for text in felt for word in ("--set", text)]
    assert main([*asked, *overrides]) == 0
    own = json.loads(capsys.readouterr().out)
    assert own["length"] == pytest.approx(paper["length"], rel=1e-6)
    assert own["margin"] == pytest.approx(paper["margin"] / 2.0, rel=1e-6)
    assert "felt.csv" in own["aim"]["threshold"][0]["source"]


def test_aims_ask_for_it(felt):
    """The aims' threshold is that of each point's scene."""
    values, _ = scene_values("paper", ("frequency=40", *felt[1:]))
    statement = Statement("paper", values, ("threshold.kind=paper,table",), ("tmm",),
                          ("tip_displacement",))  # fmt: skip
    aims = parse_aims(["first(tip_displacement / threshold) >= 0"])
    (found,) = verdicts(run_study(statement), aims)
    paper, own = (judged.margins[0].value for judged in found.judged)
    assert own == pytest.approx(paper / 2.0, rel=1e-9)


@pytest.mark.usefixtures("own_store", "coarse_bricks")
def test_error_bar_of_the_solid_is_that_of_the_displacement():
    """V is a reciprocal of |w|: the same relative error bar, to first order (bars of 0.2 %)."""
    scene, _ = load_scene("paper", ["frequency=10,100", "mesh.level=1"])
    q = solve(scene, ("solid",), ("threshold_voltage", "tip_displacement"))
    voltage, tip = (q.get(n, "solid") for n in ("threshold_voltage", "tip_displacement"))
    relative = tip.error / np.abs(tip.value)
    assert relative.min() > 1e-6
    threshold = DISPLAY_THRESHOLD.at(np.array([10.0, 100.0]))
    assert voltage.value * np.abs(tip.value) / 50.0 == pytest.approx(threshold, rel=1e-12)
    # the phase of w moves too, which adds to its bar but not to V's
    assert (voltage.error / voltage.value <= 1.01 * relative).all()
    assert (voltage.error / voltage.value >= 0.5 * relative).all()


def test_partly_outside_is_null_with_a_warning(capsys):
    """No value to hold outside: null in strict JSON, and a warning."""
    code = main(
        ["solve", "prototype", "--model", "tmm", "--quantity", "threshold_voltage",
         "--frequency", "0,5,10,1500", "--json"]
    )  # fmt: skip
    out, err = capsys.readouterr()
    (quantity,) = json.loads(out, parse_constant=pytest.fail)["quantities"]
    assert code == 0
    for numbers in ("value", "uncertainty"):
        assert [v is None for v in quantity[numbers]] == [True, True, False, True]
    assert "3 of 4 frequencies are outside the range in which the detection threshold" in err


def test_wholly_outside_is_refused_if_nothing_else_is_asked():
    """Alone it is refused in one sentence; beside other quantities those are answered."""
    scene, _ = load_scene("prototype", ["frequency=1500,2000"])
    with pytest.raises(InputError, match=r"1500 Hz is outside .* \(10 to 1000 Hz\); choose"):
        solve(scene, ("tmm",), ("threshold_voltage",))
    both = solve(scene, ("tmm",), ("threshold_voltage", "tip_velocity"))
    assert np.isnan(both.get("threshold_voltage", "tmm").value).all()
    assert np.isfinite(both.get("tip_velocity", "tmm").value).all()
    # nor has a tip that does not respond a voltage
    scene, _ = load_scene("paper", ["frequency=100,200", "piezo.d31=0 pC/N"])
    solution = solve(scene, ("tmm", "beam"), ("threshold_voltage",))
    assert all(q["value"] == [None, None] for q in as_json(solution)["quantities"])


@pytest.mark.parametrize(
    ("content", "words"),
    [
        ("frequency (Hz)\n100\n200\n", "has no threshold column"),
        ("frequency (Hz),threshold (V)\n10,2\n20,1\n", "which is not that of a displacement"),
        ("frequency (Hz),threshold (um)\n100,0\n200,1\n", "line 2: threshold 0 m is not above 0"),
        ("frequency (Hz),threshold (um)\n100,1\n", "holds 1 frequencies; a curve needs at least 2"),
    ],
)
def test_tables_that_are_no_threshold(tmp_path, content, words):
    """One sentence that names the file and what is wrong with it."""
    path = tmp_path / "threshold.csv"
    path.write_text(content, encoding="utf-8")
    with pytest.raises(InputError, match=words):
        threshold_of(Threshold(kind="table", file=str(path)))
