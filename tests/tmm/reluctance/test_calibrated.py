"""The network with its known differences taken off: one co-energy, and what lies beyond the fit."""

import numpy as np
import pytest

from tactgen.tmm.reluctance.calibrated import (
    GROUPS,
    VALUES,
    State,
    calibration,
    corrected,
    fit_of,
    groups,
)
from tactgen.tmm.reluctance.network import network_samples
from tactgen.validation.scene.load import load_scene

TURNS = GROUPS.index("ampere turns")


def device(*overrides):
    return load_scene("reluctance", list(overrides))[0].device


def at(of, current, gap):
    """State at one current and gap, each value a float."""
    where = np.array([current]), np.array([gap])
    plain = network_samples(of, *where)
    network = State(*(np.array([getattr(plain, name)[0, 0]]) for name in VALUES))
    found, errors = corrected(of, *where, network)
    return State(*(float(value[0]) for value in found)), errors[:, 0]


@pytest.mark.parametrize("current", [0.01, -0.05, 0.3, 3.0])
@pytest.mark.parametrize("gap", [0.02e-3, 0.45e-3])
def test_all_values_are_slopes_of_one_coenergy(current, gap):
    """Of either sign of the current, nearly without one, saturated, and beyond the fit's gaps."""
    of, step = device("steel.curve=armco"), 1e-3
    state, _ = at(of, current, gap)
    less, more = (at(of, current * (1.0 + s), gap)[0] for s in (-step, step))
    narrow, wide = (at(of, current, gap * (1.0 + s))[0] for s in (-step, step))
    # differences of the second order in the step, over curves that bend within a tenth
    rough = {"rel": 1e-3, "abs": 1e-3 * state.coenergy / gap}
    by_current = (more.coenergy - less.coenergy) / (2.0 * step * current)
    # beyond the range what gap and current change together is left out
    assert state.flux_linkage == pytest.approx(by_current, rel=3e-3)
    assert state.force == pytest.approx(
        (narrow.coenergy - wide.coenergy) / (2 * step * gap), **rough
    )
    slope = (more.flux_linkage - less.flux_linkage) / (2.0 * step * current)
    # the magnetisation curve is measured, and its slope is rougher
    assert state.incremental_inductance == pytest.approx(slope, rel=2e-2)


def test_values_go_on_beyond_the_range():
    """No jump at the widest gap, nor at the fewest and the most ampere turns."""
    of = device("steel.curve=armco")
    fit = calibration()["saturating"]
    r, low, high = of.rod.head_radius, fit.products.low, fit.products.high
    widest = r * np.exp(high[0])
    inside, outside = (at(of, 0.3, widest * (1.0 + s))[0] for s in (-1e-6, 1e-6))
    np.testing.assert_allclose(outside, inside, rtol=1e-4)
    # where P is held from: its value goes on, its slope, and with it the force, does not
    inside, outside = (at(of, 0.3, 2.0 * widest * (1.0 + s))[0] for s in (-1e-6, 1e-6))
    assert outside.coenergy == pytest.approx(inside.coenergy, rel=1e-4)
    one = groups(of, np.array([1.0]), np.array([0.2e-3]))[0, TURNS]
    last = high[TURNS] + np.log(2.0)
    inside, outside = (at(of, np.exp(last - one + s), 0.2e-3)[0] for s in (-1e-6, 1e-6))
    assert outside.coenergy == pytest.approx(inside.coenergy, rel=1e-4)
    for end in (low[TURNS], high[TURNS]):
        inside, outside = (at(of, np.exp(end - one + s), 0.2e-3)[0] for s in (1e-4, -1e-4))
        # P is held below the low end: its slope is not, within what the errors cover
        np.testing.assert_allclose(outside, inside, rtol=0.05)


def test_few_ampere_turns_and_those_of_a_straight_curve_are_not_beyond():
    straight, bent = device("steel.curve=linear"), device("steel.curve=armco")
    for of, current, beyond in (
        (bent, 1e-9, []), (bent, 0.1, []), (bent, 1e3, ["ampere turns"]), (straight, 1e3, []),
    ):  # fmt: skip
        ratios = groups(of, np.array([current]), np.array([0.2e-3]))[0]
        assert fit_of(of).outside(ratios) == beyond
    (inside, outside) = (at(bent, current, 0.2e-3)[1] for current in (1.0, 1e3))
    assert (outside > 2.0 * inside).all()
