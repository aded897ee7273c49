"""Verdicts on models side by side: what the bars cover agrees, and nothing else does."""

import numpy as np
import pytest

from tactgen.validation.catalogue.needs import Actuator
from tactgen.validation.engine.results import Quantity
from tactgen.validation.models.comparison import compare
from tactgen.validation.scene.scene import load_scene


def verdict(model, value, bar, reference, reference_bar=0.0, name="static_tip_displacement"):
    """Return the verdict on a model's value beside the reference's 1."""
    scene, _ = load_scene("paper")
    found = [
        Quantity(name, m, np.asarray(v), "m", np.asarray(b), "", 0.0)
        for m, v, b in ((model, value, bar), (reference, 1.0, reference_bar))
    ]
    (row,) = compare(scene, found, LATERAL)
    assert row.cells[-1].verdict == "reference"
    return row.cells[0].verdict


LATERAL: Actuator = "bimorph"


@pytest.mark.parametrize(
    ("bar", "reference_bar", "expected"),
    [
        (0.011, 0.0, "agrees"),
        (0.0, 0.011, "agrees"),
        (0.006, 0.005, "agrees"),
        (0.009, 0.0, "model form"),
        (0.0, 0.009, "model form"),
        (0.001, 0.001, "model form"),
    ],
)
def test_both_bars_cover_or_the_models_differ(bar, reference_bar, expected):
    """1 % apart: the bars together must reach."""
    assert verdict("tmm", 1.01, bar, "solid", reference_bar) == expected


@pytest.mark.parametrize(("off", "expected"), [(0.9e-8, "agrees"), (1.1e-8, "differs")])
def test_one_theory_leaves_nothing_to_explain(off, expected):
    """Transfer matrices and beam elements solve one equation: 1e-8, or something is wrong."""
    assert verdict("tmm", 1.0 + off, 0.0, "beam") == expected
