"""An own detection threshold: where it counts, what its key is, and what is refused."""

import json

import numpy as np
import pytest

from tactgen.validation.catalogue.detection import DISPLAY_THRESHOLD
from tactgen.validation.command_line.cli import main
from tactgen.validation.engine.solve import solve
from tactgen.validation.scene.scene import load_scene, scene_values
from tactgen.validation.studies.whatif.aim_evaluation import parse_aims, verdicts
from tactgen.validation.studies.whatif.definition import Statement
from tactgen.validation.studies.whatif.study import run_study

BOTH = ("detection_ratio", "threshold_voltage")


@pytest.fixture
def felt(tmp_path):
    """Twice the paper's threshold as a table, and what a scene says to use it."""
    path = tmp_path / "felt.csv"
    rows = [f"{p.frequency}, {2e6 * p.amplitude}" for p in DISPLAY_THRESHOLD.points]
    path.write_text("\n".join(["frequency (Hz), threshold (um)", *rows]) + "\n")
    return ("threshold.kind=table", f"threshold.file={path}")


def solved(*overrides):
    scene, _ = load_scene("paper", ("frequency=10,40,300", "models=tmm", *overrides))
    found = solve(scene, None, ("tip_displacement", *BOTH))
    return [found.get(name, "tmm") for name in ("tip_displacement", *BOTH)]


def test_ratio_and_voltage_say_the_same(felt):
    """Ratio is |w| over the threshold, voltage is drive over ratio; twice the threshold, half."""
    tip, ratio, voltage = solved()
    level = DISPLAY_THRESHOLD.at(np.array(tip.frequency))
    np.testing.assert_allclose(ratio.value, np.abs(tip.value) / level, rtol=1e-12)
    np.testing.assert_allclose(voltage.value * ratio.value, 50.0, rtol=1e-12)
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
    paper, own = (judged.margins[0][0] for judged in found.judged)
    assert own == pytest.approx(paper / 2.0, rel=1e-9)
