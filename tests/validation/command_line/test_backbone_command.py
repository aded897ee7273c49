"""``tactgen backbone``: a table, JSON, a picture; bad input refused in one sentence."""

import json
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from tactgen.validation.command_line.cli import main
from tactgen.validation.command_line.commands.studies import backbone
from tactgen.validation.models.amplitude.backbone import RESOLUTION, Backbone, Curve

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


def test_the_scenes_band_is_from_its_lowest_to_its_highest_frequency():
    """In whatever order they stand; rest is no part of it."""
    scene = SimpleNamespace(frequency=(300.0, 0.0, 80.0, 900.0, 500.0))
    assert backbone._scene_band(scene) == (80.0, 900.0)


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        (("paper",), "support.kind = spring in scene paper is linear"),
        (("reluctance",), "are all of the normal actuator, and backbone is about the lateral"),
        ((*ON_A_STOP, "--voltage", "0.1:2"), "is not START:STOP:N"),
        ((*ON_A_STOP, "--voltage", "0.1:2:1"), "N from 2 to 100"),
        ((*ON_A_STOP, "--voltage", "1,x"), 'has "x", which is no amplitude above 0 V'),
        ((*ON_A_STOP, "--voltage", "-1"), "which is no amplitude above 0 V"),
        ((*ON_A_STOP, "--voltage", "0"), "which is no amplitude above 0 V"),
        ((*ON_A_STOP, "--frequency", "500"), "is not LOW:HIGH above 0 Hz"),
        ((*ON_A_STOP, "--frequency", "500:100"), "is not LOW:HIGH above 0 Hz"),
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


def test_curves_that_end_early_or_leave_out_too_much_are_told(capsys):
    """With their voltage; and a curve without a peak has a line of its own."""
    empty = np.zeros(0)
    fine = Curve(1.0, empty, empty, empty, (), (410.5, 400.25), 5, RESOLUTION.missing, "")
    lossy = replace(fine, voltage=2.5, folds=(), missing=0.0234, harmonics=7)
    found = Backbone(
        SimpleNamespace(
            place=SimpleNamespace(kind="stop", contact_force=0.25),
            support=SimpleNamespace(rotational_stiffness=1.5),
        ),
        (fine, lossy, replace(fine, voltage=3.0, ended="it turns back outside")),
    )
    assert found.warnings == (
        "at 2.5 V 7 harmonics leave out up to 2.3 % of the motion", "at 3 V it turns back outside",
    )  # fmt: skip
    backbone._print(SimpleNamespace(name="mine"), found)
    head, _, *lines = capsys.readouterr().out.splitlines()
    assert head == "mine: head on its stop with 250 mN, small rocking stiffness 1.5 N m/rad"
    assert [line.split() for line in lines[:2]] == [
        ["1", "V", "no", "peak", "in", "the", "band", "410.5", "Hz,", "400.25", "Hz"],
        ["2.5", "V", "no", "peak", "in", "the", "band", "-"],
    ]
