"""Which currents and gaps a map covers: what switching asks of it, and the device's own current."""

import numpy as np
import pytest
from scipy.optimize import brentq

from tactgen.geometry.device.parameters import Coil, Device, Spring
from tactgen.geometry.errors import InputError
from tactgen.tmm.reluctance import map_range
from tactgen.tmm.reluctance.map_range import map_grid
from tactgen.tmm.reluctance.network import network_samples
from tactgen.validation.evidence.cases.actuator import collared


def device(current=0.13, **spring):
    return Device(coil=Coil(current=current), spring=Spring(**spring))


def balance(built):
    """The network's balance current at the upper stop, from the network itself."""

    def missing(current):
        samples = network_samples(built, np.array([current]), np.array([built.gap]))
        return samples.force[0, 0] - built.spring.preload

    return brentq(missing, 0.0, 300.0, xtol=1e-6)


@pytest.mark.parametrize(
    ("current", "spring"),
    [
        pytest.param(current, spring, marks=[] if (m - n) % 5 in (0, 3) else [pytest.mark.heavy])
        for n, spring in enumerate(({}, {"preload": 1e-3, "stiffness": 0.0}, {"preload": 0.3}))
        for m, current in enumerate((0.0, -0.13, 0.01, 20.0, 1e3))
    ],
)
def test_switching_is_resolved_whatever_the_current(current, spring):
    """The currents at which the rod moves lie inside the map, above its third sample, and the
    device's own current lies inside, too."""
    built = device(current, **spring)
    currents, _ = map_grid(built)
    needed = balance(built)
    assert currents[0] == 0.0
    assert (np.diff(currents) > 0.0).all()
    assert currents[3] < needed < 0.75 * currents[12]
    assert abs(current) < 0.8 * currents[-1]
    assert currents.size < 40


def test_the_current_does_not_move_the_switching_range():
    """A larger current of the device adds samples beyond; those of the switching range stay."""
    few, many = map_grid(device(0.0))[0], map_grid(device(5.0))[0]
    np.testing.assert_array_equal(few, many[: few.size])
    outer = many[few.size - 1 :]
    assert (outer[1:] / outer[:-1]).max() <= 1.6 * (1.0 + 1e-12)


@pytest.mark.parametrize(
    ("gap", "sleeve", "limit"),
    [
        (0.2e-3, {}, 0.25e-3),
        # the coil's top is level with the sleeve's at 0.5 mm, which is no limit
        (0.45e-3, {}, 0.5625e-3),
        # the flange meets the collar at 2.4 mm
        (2.2e-3, {}, 2.3e-3),
        # the coil, as wide as the collar's bore, meets its lower face at 0.3 mm
        (0.28e-3, {"collar_radius": 0.87e-3}, 0.29e-3),
    ],
)
def test_gaps_stay_where_a_model_can_go(gap, sleeve, limit):
    """From a fifth below the lower stop to a quarter beyond the upper, or half the way to where
    parts meet."""
    built = collared(sleeve=sleeve).model_copy(update={"gap": gap})
    _, gaps = map_grid(built)
    assert gaps[0] == pytest.approx(0.8 * built.spring.stop_gap, rel=1e-9)
    assert gaps[-1] == pytest.approx(limit, rel=1e-9)


@pytest.mark.parametrize(
    ("built", "needed"),
    [
        (collared(coil={"position": -0.2e-3}), 0.105),
        # the network takes no flange above the collar
        (collared(sleeve={"collar_radius": 0.95e-3}).model_copy(update={"gap": 5e-3}), 0.5),
    ],
)
def test_unusual_coils_and_gaps_have_a_range(built, needed):
    """A range by the one-gap formula: about the network's, here of the coil in its usual place."""
    currents, gaps = map_grid(built)
    assert needed < currents[-1] < 40.0 * needed
    assert gaps[-1] > built.gap


@pytest.mark.parametrize("near", [{"current": 0.1, "preload": 0.105, "stop_gap": 21e-6}, {}])
def test_devices_that_differ_a_little_share_their_range(near):
    """The same currents and gaps to the last bit, which hold what each asks for alone."""
    one, other = (map_grid(d, shared=True) for d in (device(), device(**near)))
    alone = map_grid(device(**near))
    for ours, theirs, needed in zip(one, other, alone, strict=True):
        np.testing.assert_array_equal(ours, theirs)
        assert ours[0] <= needed[0] * (1.0 + 1e-9)
        assert ours[-1] >= needed[-1] * (1.0 - 1e-9)
        assert ours[-1] <= 1.5 * needed[-1]


def test_a_shared_range_ends_before_parts_meet():
    """The flange meets the collar at 2.4 mm: no rounding across."""
    built = collared().model_copy(update={"gap": 2.2e-3})
    assert map_grid(built, shared=True)[1][-1] == pytest.approx(2.3e-3, rel=1e-9)


def test_no_spring_is_no_obstacle():
    """Without a spring some range is still chosen."""
    currents, _ = map_grid(device(0.0, preload=0.0, stiffness=0.0))
    assert 0.0 < currents[-1] < 10.0


def test_a_circuit_that_the_network_does_not_know_has_a_map(monkeypatch):
    """From the one-gap formula alone, with room for what it leaves out."""

    def unknown(*_, **__):
        raise InputError("unknown")

    known = map_grid(device())[0][12]
    monkeypatch.setattr(map_range, "network_samples", unknown)
    assert 0.5 * known < map_grid(device())[0][12] < 5.0 * known
