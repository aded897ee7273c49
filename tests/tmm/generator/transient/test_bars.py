"""Error bars of runs in time: what the distances of three passes say, and against known motions."""

import math

import numpy as np
import pytest

from tactgen.tmm.generator.transient.system import Element, Output, Stop, System
from tactgen.tmm.generator.transient.time_integration import error_bar, simulate
from tactgen.tmm.generator.transient.waveform import Sources

ONE, UNIT = np.ones(1), np.eye(1)


@pytest.mark.parametrize(
    ("larger", "smaller", "error"),
    [
        (4.0, 1.0, 1.0 / 3.0),  # order two
        (2.0, 1.0, 1.0),  # order one
        (1.0, 1.0, 2.0),  # no order: as if it were 0.58
        (1.0, 5.0, 10.0),
        (4.0, 1e-3, 1.0 / 3.0),  # agreement by chance
        (0.0, 1.0, 2.0),  # no steps in pairs
        (0.0, 0.0, 0.0),
    ],
)
def test_an_error_follows_the_observed_order(larger, smaller, error):
    """Richardson's error of the last pass, times the safety factor."""
    (found,) = error_bar(np.array([larger]), np.array([smaller]), 1.25)
    assert found == pytest.approx(1.25 * error, rel=1e-12)


def test_the_bar_of_a_smooth_run_is_half_as_wide_again_as_its_error():
    """A mass on a spring: order two, so the largest error is two thirds of the bar.

    In steps as long as allowed, so that all have partners; the next term is smaller by (ω h)².
    """
    system = System(
        UNIT, 0.0 * UNIT, UNIT, 0.0 * ONE, 0.0 * ONE, 0.0, (), (), None,
        {"x": Output(ONE, "m", 1.0)},
    )  # fmt: skip
    found = simulate(system, Sources(), 10.0, position=ONE, longest=0.02)
    off = np.abs(found.outputs["x"] - np.cos(found.run.time)).max()
    assert found.errors["x"] / off == pytest.approx(1.5, rel=0.03)


def test_the_bar_holds_over_impacts():
    """A mass that bounces on a hard stop without loss, against its closed form between impacts."""
    mass, g, k, height = 1e-3, 9.81, 1e5, 1e-3
    system = System(
        mass * UNIT, 0.0 * UNIT, 0.0 * UNIT, -mass * g * ONE, 0.0 * ONE, 0.0,
        (Element("stop", Stop(k), -ONE),), (), None, {"x": Output(ONE, "m", height)},
    )  # fmt: skip
    fall = math.sqrt(2.0 * height / g)
    omega, sag = math.sqrt(k / mass), mass * g / k
    touch = 2.0 * (math.pi - math.atan(g * fall / omega / sag)) / omega
    period = 2.0 * fall + touch
    found = simulate(system, Sources(), 4.0 * period, position=height * ONE, accuracy=1e-2)
    since = (found.run.time + 0.5 * period) % period - 0.5 * period  # from the nearest top
    flies = np.abs(since) < 0.99 * fall
    off = np.abs(found.outputs["x"] - (height - 0.5 * g * since**2))[flies]
    bar = found.bars["x"][flies]
    assert (off <= bar + 1e-9 * height).all()
    assert off.max() > 1e-6 * height
