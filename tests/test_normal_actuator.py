"""Switching, equilibria and heat of the normal actuator, on a map with closed forms."""

import numpy as np
import pytest

from geometry.errors import InputError
from geometry.parameters import Coil, Device, Spring
from geometry.winding import winding
from tmm import normal_actuator
from tmm.coenergy import Samples
from tmm.coenergy_fit import fit
from tmm.reluctance_network import network_samples

#: A linear actuator: λ = C i/(g + G0), F = C i²/(2 (g + G0)²).
C, G0 = 2e-6, 0.1e-3


@pytest.fixture(scope="module")
def pull():
    i, g = np.linspace(0.0, 0.3, 9), np.geomspace(0.015e-3, 0.25e-3, 24)
    linkage = C * i[:, None] / (g + G0)
    force = 0.5 * linkage**2 / C
    coenergy = 0.5 * i[:, None] * linkage
    return fit(Samples(i, g, linkage, force, coenergy, np.tile(C / (g + G0), (9, 1))))


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


def test_soft_spring_snaps(pull):
    """A soft spring: the rod that leaves one stop arrives at the other."""
    found = normal_actuator.switching(device(0.1, 100.0), pull)
    assert found.pull_in == pytest.approx(found.lift_off, rel=1e-12)
    assert found.drop_out == pytest.approx(found.holding, rel=1e-12)
    assert found.lift_off == pytest.approx(balance(0.1, 100.0, 0.2e-3), rel=CLOSE)
    assert found.holding == pytest.approx(balance(0.1, 100.0, 20e-6), rel=CLOSE)


def test_stiff_spring_lets_the_rod_float(pull):
    """A stiff spring: past lift-off the rod floats stably up to the fold of the balance current,
    where d/dg [(g + G0)² S] = 0: at g + G0 = (2/3) (S/k + g + G0)."""
    preload, stiffness = 0.02, 1500.0
    found = normal_actuator.switching(device(preload, stiffness), pull)
    fold = 2.0 / 3.0 * (preload / stiffness + 0.2e-3 + G0) - G0
    assert 20e-6 < fold < 0.2e-3
    assert found.pull_in == pytest.approx(balance(preload, stiffness, fold), rel=CLOSE)
    assert found.lift_off == pytest.approx(balance(preload, stiffness, 0.2e-3), rel=CLOSE)
    assert found.pull_in > 1.05 * found.lift_off


def test_drop_out_below_holding(pull):
    """With the fold below the lower stop the rod floats near that stop before it falls back."""
    # no preload: the balance current grows from zero at the upper stop, so the rod follows
    found = normal_actuator.switching(device(0.0, 500.0), pull)
    assert found.lift_off == pytest.approx(0.0, abs=1e-9)
    assert found.drop_out == pytest.approx(0.0, abs=1e-9)
    assert found.holding == pytest.approx(balance(0.0, 500.0, 20e-6), rel=CLOSE)


@pytest.mark.parametrize(
    ("preload", "stiffness", "current", "kinds"),
    [
        (0.1, 100.0, 0.0, ["upper stop"]),
        (0.1, 100.0, 0.06, ["upper stop", "unstable", "lower stop"]),
        (0.1, 100.0, 0.2, ["lower stop"]),
        (0.02, 1500.0, 0.045, ["stable"]),
        (0.02, 1500.0, 0.07, ["stable", "unstable", "lower stop"]),
    ],
)
def test_equilibria(pull, preload, stiffness, current, kinds):
    """Where the rod can rest, and how it rests there; floating ones solve S = F."""
    built = device(preload, stiffness)
    found = normal_actuator.equilibria(built, pull, current)
    assert [place.kind for place in found] == kinds
    assert list(found) == sorted(found, key=lambda place: -place.gap)
    for place in found:
        if "stop" not in place.kind:
            assert balance(preload, stiffness, place.gap) == pytest.approx(current, rel=CLOSE)


def test_switching_agrees_with_the_equilibria(pull):
    """Just below and above each switching current, the places to rest differ as they should."""
    built = device(0.02, 1500.0)
    at = normal_actuator.switching(built, pull)

    def kinds(current):
        return [place.kind for place in normal_actuator.equilibria(built, pull, current)]

    a_bit = 1e-4
    assert kinds(at.lift_off * (1 - a_bit))[0] == "upper stop"
    assert kinds(at.lift_off * (1 + a_bit))[0] == "stable"
    assert "stable" in kinds(at.pull_in * (1 - a_bit))
    assert kinds(at.pull_in * (1 + a_bit)) == ["lower stop"]
    assert "lower stop" not in kinds(at.holding * (1 - a_bit))
    assert "lower stop" in kinds(at.holding * (1 + a_bit))


def test_electrical(pull):
    """Inductance from the map, resistance from the wire, time constant from both."""
    built = device(0.1, 100.0, fill_factor=0.4)
    found = normal_actuator.electrical(built, pull, 0.1, 0.1e-3)
    resistance = winding(built.coil).resistance
    assert found.resistance == resistance
    assert found.power == pytest.approx(0.01 * resistance)
    assert found.incremental_inductance == pytest.approx(C / 0.2e-3, rel=CLOSE)
    assert found.apparent_inductance == pytest.approx(C / 0.2e-3, rel=CLOSE)
    assert found.time_constant == pytest.approx(C / 0.2e-3 / resistance, rel=CLOSE)
    # by default at the device's own current and gap
    own = normal_actuator.electrical(built, pull)
    assert own == normal_actuator.electrical(built, pull, built.coil.current, built.gap)


def test_heat_is_judged_in_words():
    """The statement carries the numbers, and its verdict follows them."""
    built = Device()
    rise = normal_actuator.steady_temperature_rise(built, 0.13)
    assert rise == pytest.approx(
        winding(built.coil).power(0.13) / (25.0 * np.pi * (2.3e-3 * 3.6e-3 + 1.15e-3**2))
    )
    text = normal_actuator.thermal_statement(built, 0.13)
    assert "424 A/mm^2" in text
    assert "not plausible" in text
    assert "not plausible" not in normal_actuator.thermal_statement(built, 1e-3)
    assert "inf s" in normal_actuator.thermal_statement(built, 0.0)


def test_refusals(pull):
    """No stroke, or a spring that the coil cannot overcome: one sentence with the remedy."""
    with pytest.raises(InputError, match=r"spring.stop_gap = 0.3 mm leaves no stroke"):
        normal_actuator.switching(Device(spring=Spring(stop_gap=0.3e-3)), pull)
    with pytest.raises(InputError, match=r"preload = 5000 mN .* up to 300 mA"):
        normal_actuator.switching(device(5.0, 100.0), pull)
    with pytest.raises(InputError, match="gap = 5 um lies outside the map"):
        normal_actuator.switching(Device(spring=Spring(stop_gap=5e-6)), pull)


def test_paper_on_the_network():
    """The paper (section 5.1, 2.2): 50 mA holds the rod down, without current the finger feels
    110 mN.  Its 130 mA must pull the rod down; the network, whose force lies above the field's,
    needs less."""
    built = Device()
    pull = fit(network_samples(built, *normal_actuator.map_grid(built)))
    at = normal_actuator.switching(built, pull)
    assert at.drop_out < 50e-3 < at.pull_in < 130e-3
    assert normal_actuator.finger_force(built, pull, 0.0, built.gap) == pytest.approx(110e-3)


def test_a_map_needs_a_current():
    """Either sign spans the same map; no current is refused with the remedy."""
    device = Device()
    turned = device.model_copy(update={"coil": device.coil.model_copy(update={"current": -0.13})})
    np.testing.assert_array_equal(
        normal_actuator.map_grid(turned)[0], normal_actuator.map_grid(device)[0]
    )
    idle = device.model_copy(update={"coil": device.coil.model_copy(update={"current": 0.0})})
    with pytest.raises(InputError, match=r"coil\.current = 0 mA .* set the largest"):
        normal_actuator.map_grid(idle)
