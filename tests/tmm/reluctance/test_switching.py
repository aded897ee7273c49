"""Switching and heat of the normal actuator, on a map with closed forms."""

import numpy as np
import pytest
from reluctance_samples import BEND, G0, C, falling_samples, linear_samples

from tactgen.geometry.device.parameters import Coil, Device, Spring
from tactgen.geometry.device.winding import winding
from tactgen.geometry.errors import InputError
from tactgen.tmm.reluctance import network as coil_heat
from tactgen.tmm.reluctance import switching as normal_actuator
from tactgen.tmm.reluctance.coenergy_fit import fit


@pytest.fixture(scope="module")
def pull():
    return fit(linear_samples(np.linspace(0.0, 0.3, 9), np.geomspace(0.015e-3, 0.25e-3, 24)))


def device(preload, stiffness, **coil):
    spring = Spring(preload=preload, stiffness=stiffness, stop_gap=20e-6)
    return Device(spring=spring, coil=Coil(**coil))


def balance(preload, stiffness, gap):
    """i_b = (g + G0) √(2 S/C), exact."""
    spring = preload + stiffness * (0.2e-3 - gap)
    return (gap + G0) * np.sqrt(2.0 * spring / C)


#: Of the map's force, by its own samples' spacing: cubic in ln(g + g0), third order.
CLOSE = 1e-3


def test_forces(pull):
    """Finger force = spring − pull, for any number of currents and gaps."""
    soft = device(0.1, 100.0)
    gaps = np.array([20e-6, 0.2e-3])
    np.testing.assert_allclose(normal_actuator.spring_force(soft, gaps), [0.118, 0.1])
    pulls = C * 0.1**2 / (2.0 * (gaps + G0) ** 2)
    found = normal_actuator.finger_force(soft, pull, 0.1, gaps)
    np.testing.assert_allclose(found, np.array([0.118, 0.1]) - pulls, atol=CLOSE * pulls.max())
    # without current the finger feels the spring alone
    assert normal_actuator.finger_force(soft, pull, 0.0, 0.2e-3) == pytest.approx(0.1)


def test_balance_current(pull):
    """The current at which the forces balance, and inf where the map's currents do not do."""
    gaps = np.linspace(20e-6, 0.2e-3, 7)
    found = normal_actuator.balance_current(device(0.1, 100.0), pull, gaps)
    np.testing.assert_allclose(found, balance(0.1, 100.0, gaps), rtol=CLOSE)
    assert np.isinf(normal_actuator.balance_current(device(5.0, 100.0), pull, gaps)[-1])


def test_drop_out_below_holding(pull):
    """With the fold below the lower stop the rod floats near that stop before it falls back."""
    # no preload: the balance current grows from zero at the upper stop, so the rod follows
    found = normal_actuator.switching(device(0.0, 500.0), pull)
    assert [found.lift_off, found.drop_out] == pytest.approx([0.0, 0.0], abs=1e-9)
    assert found.holding == pytest.approx(balance(0.0, 500.0, 20e-6), rel=CLOSE)


def test_the_way_of_the_rod(pull):
    """A stiff spring: rising the rod floats down to the fold and jumps, falling it jumps at the
    lower stop's balance to the place that is stable there; a soft one jumps from stop to stop."""
    low, high = 20e-6, 0.2e-3
    stiff, soft = device(0.02, 1500.0), device(0.1, 100.0)
    for built in (stiff, soft):
        at = normal_actuator.switching(built, pull)
        current = np.array([0.0, 0.999 * at.pull_in, 1.001 * at.pull_in, 0.29])
        gaps = normal_actuator.resting_gaps(built, pull, current, rising=True)
        np.testing.assert_allclose(gaps[[0, 2, 3]], [high, low, low])
        if built is soft:
            assert gaps[1] == high
        else:  # near the fold the gap goes with the root of the current's distance
            assert gaps[1] == pytest.approx(at.pull_in_gap, abs=0.1 * (high - low))
        current = np.array([0.0, 0.999 * at.drop_out, 1.001 * at.holding, 0.29])
        gaps = normal_actuator.resting_gaps(built, pull, current, rising=False)
        np.testing.assert_allclose(gaps[[0, 2, 3]], [high, low, low])


def test_saturation_does_not_hide_a_balance():
    """Where the pull falls again with the current, the least current that balances counts."""
    gaps = np.geomspace(0.015e-3, 0.25e-3, 24)
    falling = fit(falling_samples(np.linspace(0.0, 0.3, 13), gaps))
    # the pull is largest at i = 2/b = 0.25 A and falls beyond
    peak = C * (0.25**2 / 6.0) / (0.2e-3 + G0) ** 2
    built = device(0.99 * peak, 0.0)
    (found,) = normal_actuator.balance_current(built, falling, np.array([0.2e-3]))
    exact = np.roots([-BEND / 6.0, 0.5, 0.0, -0.99 * 0.25**2 / 6.0])
    expected = min(r.real for r in exact if abs(r.imag) < 1e-12 and r.real > 0.0)
    # the pull is flat there: 0.1 % of it is a few percent of the current
    assert found == pytest.approx(expected, rel=0.05)


def test_heat_is_judged_in_words():
    """The statement carries the numbers, and its verdict follows them."""
    built = Device()
    rise = coil_heat.steady_temperature_rise(built, 0.13)
    assert rise == pytest.approx(
        winding(built.coil).power(0.13) / (25.0 * np.pi * (2.3e-3 * 18.7e-3 + 1.15e-3**2))
    )
    assert "not plausible" in coil_heat.thermal_statement(built, 0.13)
    assert "not plausible" not in coil_heat.thermal_statement(built, 1e-3)
    assert coil_heat.thermal_statement(built, 0.0) == "no current, no heat"


def test_refusals(pull):
    """No stroke, or one beyond the map: one sentence with the remedy."""
    with pytest.raises(InputError, match=r"spring.stop_gap = 0.3 mm leaves no stroke"):
        normal_actuator.switching(Device(spring=Spring(stop_gap=0.3e-3)), pull)
    with pytest.raises(InputError, match="gap = 5 um lies outside the map"):
        normal_actuator.switching(Device(spring=Spring(stop_gap=5e-6)), pull)
