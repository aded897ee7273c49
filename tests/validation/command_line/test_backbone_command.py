"""``tactgen backbone``: a table, JSON, a picture; bad input refused in one sentence."""

import json

import pytest

from tactgen.validation.command_line.cli import main

ON_A_STOP = ("prototype", "--set", "support.kind=contact", "--set", "coil.current=0mA")
#: From below the bent resonance to above it; peak and folds in between.
STRONG = (*ON_A_STOP, "--voltage", "2.5", "--frequency", "560:760", "--model", "lumped")


@pytest.mark.heavy
def test_bent_resonance(capsys, tmp_path):
    """At 2.5 V the peak lies where the curve hangs over: three answers, the middle one unstable."""
    plot = tmp_path / "backbone.svg"
    assert main(["backbone", *STRONG, "--plot", str(plot), "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert (found["scene"], found["model"]) == ("prototype", "lumped")
    assert found["place"]["kind"] == "upper stop"
    (curve,) = found["curves"]
    right, left = curve["folds"]
    (peak,) = curve["peaks"]
    assert 560.0 < left < peak["frequency"] < right < 760.0
    assert 0.0 < peak["frequency_bar"] < 1e-3 * peak["frequency"]
    assert 0.5 < peak["moment_share"] < 1.0
    assert len(curve["frequencies"]) == len(curve["displacement"]) == len(curve["stable"])
    backwards = [
        b < a for a, b in zip(curve["frequencies"], curve["frequencies"][1:], strict=False)
    ]
    assert any(backwards)
    turned = backwards.index(True)
    assert curve["stable"][0]
    assert curve["stable"][-1]
    assert not curve["stable"][turned + 2]
    assert found["warnings"] == []
    assert plot.read_text(encoding="utf-8").startswith("<svg")


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        (("paper",), "support.kind = spring in scene paper is linear"),
        (("reluctance",), "are all of the normal actuator, and backbone is about the lateral"),
        ((*ON_A_STOP, "--voltage", "1,x"), 'has "x", which is no voltage above 0'),
        ((*ON_A_STOP, "--model", "network"), 'model "network" has no ports'),
        ((*ON_A_STOP, "--plot", "a.png"), "is not an SVG file"),
        ((*ON_A_STOP, "--set", "frequency=500"), "states no band of frequencies above 0 Hz"),
    ],
)
def test_refusals(arguments, sentence, capsys):
    """One sentence on stderr, nothing on stdout, exit code 2."""
    assert main(["backbone", *arguments]) == 2
    caught = capsys.readouterr()
    assert caught.out == ""
    assert sentence in caught.err
    assert caught.err.strip().splitlines()[-1].startswith("tactgen: ")
