"""Bands of predictions beside what others measured."""

from dataclasses import replace

import numpy as np
import pytest

from tactgen.validation.evidence.case import judged
from tactgen.validation.evidence.cases import devices
from tactgen.validation.evidence.verification import group_rows
from tactgen.validation.models.model import Estimate
from tactgen.validation.studies.published_measurements import Published, Unknown


def test_bands_multiply_the_effects_of_what_is_unknown():
    """Two factors on a number, the models alike: 95 % of what their product can be."""
    unknowns = tuple(Unknown(name, 0.5, 2.0, "1", "", 1.0) for name in "ab")

    def predict(values):
        return np.array([3.0 * values["a"] * values["b"], 10.0 if values["model"] else 5.0])

    numbers = (Published("product", 1.0, 2.0, "m"), Published("model", 1.0, 2.0, "m"))
    (low, high), by_model = devices.bands(
        devices.Figure("x", "", numbers, (*unknowns, devices._MODEL), predict)
    )
    # the same by 2e5 draws; logarithms between the ends are interpolated
    log = np.interp(np.random.default_rng(1).uniform(0.5, 2.0, (2, 200_000)), [0.5, 1.0, 2.0],
                    np.log([0.5, 1.0, 2.0]))  # fmt: skip
    expected = 3.0 * np.exp(np.quantile(log.sum(axis=0), [0.025, 0.975]))
    assert (low, high) == pytest.approx(tuple(expected), rel=0.02)  # 1024 samples
    assert tuple(by_model) == pytest.approx(5.0 * 2.0 ** np.array([0.025, 0.975]), rel=1e-3)


@pytest.mark.parametrize(
    ("middle", "half", "deviation"),
    [(1.5, 0.1, 0.0), (3.0, 1.5, 0.0), (3.0, 0.5, 0.25), (0.4, 0.2, -0.4)],
)
def test_bands_are_judged_by_their_nearest_value(middle, half, deviation):
    """A band that has a value in common with the published range passes."""
    row = replace(group_rows("devices")[0], reference=(1.0, 2.0), tolerance=0.0)
    outcome = judged(row, Estimate(middle, half))
    assert outcome.deviation == pytest.approx(deviation, rel=1e-12)
    assert (outcome.status == "pass") is (deviation == 0.0)
