"""Where the rod rests: the ideal gap's closed form, hysteresis, and what holds it."""

import math
from types import SimpleNamespace

import numpy as np
import pytest
from ideal_gap import IdealGap

from tactgen.geometry.device.magnetisation import MU0
from tactgen.geometry.device.parameters import Contact, Device, Spring
from tactgen.tmm.generator.equilibrium import (
    axial_forces,
    position_loop,
    resting_place,
    resting_places,
    settled_place,
)

GAP, STIFFNESS, STRENGTH = 0.2e-3, 100.0, MU0 * 500.0**2 * 4e-6
#: I² = 8 k g0³ / (27 µ0 N² A), the electrostatic or magnetic gap on a spring; at g0/3 of travel.
PULL_IN = math.sqrt(8.0 * STIFFNESS * GAP**3 / (27.0 * STRENGTH))


def ideal(preload=0.0, **more):
    """A spring that is loose at the top; stops so hard that they are felt only when touched."""
    spring = Spring(preload=preload, stiffness=STIFFNESS, stop_gap=20e-6)
    contact = Contact(decay_length=1e-10)
    return axial_forces(Device(gap=GAP, spring=spring, contact=contact, **more), IdealGap(STRENGTH))


@pytest.mark.parametrize("share", [0.3, 0.7, 0.95])
def test_floating_places_are_the_roots_of_the_cubic(share):
    """k x (g0 − x)² = µ0 N² I² A / 2: the smaller root is stable, the next is not."""
    current = share * PULL_IN
    cubic = [STIFFNESS, -2 * STIFFNESS * GAP, STIFFNESS * GAP**2]
    roots = np.sort(np.roots([*cubic, -0.5 * STRENGTH * current**2]).real)[:2]
    found = {p.kind: p for p in resting_places(ideal(), current) if "stop" not in p.kind}
    # brackets end at rounding of the lift; np.roots at that of the cubic near its double root
    assert found["floating"].lift == pytest.approx(-roots[0], rel=1e-9)
    assert found["unstable"].lift == pytest.approx(-roots[1], rel=1e-9)
    x = roots[0]
    slope = STIFFNESS - 2.0 * IdealGap(STRENGTH).force(current, GAP - x) / (GAP - x)
    assert found["floating"].stiffness == pytest.approx(slope, rel=1e-6)
    assert found["unstable"].stiffness < 0.0


def test_hysteresis():
    """Up it stays while the current rises, down while it falls: one loop, no place between."""
    forces = ideal(preload=20e-3)
    lift_off = math.sqrt(2.0 * 20e-3 / STRENGTH) * GAP
    stop = forces.device.spring.stop_gap
    spring_down = 20e-3 + STIFFNESS * (GAP - stop)
    drop_out = math.sqrt(2.0 * spring_down / STRENGTH) * stop
    currents = np.array([0.5 * drop_out, 1.01 * drop_out, 0.99 * lift_off, 1.01 * lift_off])
    loop = position_loop(forces, currents)
    down = -(GAP - stop)
    rising, falling = ([p.lift for p in way] for way in (loop.rising, loop.falling))
    np.testing.assert_allclose(rising, [0.0, 0.0, 0.0, down], atol=1e-8)
    np.testing.assert_allclose(falling, [0.0, down, down, down], atol=1e-8)
    # between two stable places there is one from which it falls either way
    np.testing.assert_array_equal(loop.unstable[:, 0], currents[1:3])
    assert ((loop.unstable[:, 1] > down) & (loop.unstable[:, 1] < 0.0)).all()


def test_forces_at_rest():
    """The stop carries what is left of the spring; a finger takes its share from it."""
    device = Device()
    up = resting_place(axial_forces(device, None), 0.0, "rising")
    assert up.kind == "upper stop"
    assert up.contact_force == pytest.approx(up.finger_force, rel=1e-9)
    # the spring has given way by the approach of the surfaces, k times 29 nm
    assert up.finger_force == pytest.approx(device.spring.preload, rel=1e-4)
    under = resting_place(axial_forces(device, None, pressed=40e-3), 0.0, "rising")
    assert under.contact_force == pytest.approx(under.finger_force - 40e-3, rel=1e-9)
    pushed = resting_place(axial_forces(device, None, pressed=0.2), 0.0, "rising")
    assert pushed.kind == "lower stop"  # 110 mN and 100 N/m over 180 um are less than 200 mN


def test_a_place_settles_where_the_forces_of_now_balance():
    """By a little more current, or none more; not beyond pull-in, nor from where nothing stays."""
    places = {p.kind: p for p in resting_places(ideal(), 0.7 * PULL_IN)}
    near = places["floating"]
    for share in (0.7, 0.7001, 0.71):
        found = settled_place(ideal(), share * PULL_IN, near)
        there = resting_place(ideal(), share * PULL_IN, "rising")
        assert found.kind == "floating"
        assert found.lift == pytest.approx(there.lift, rel=1e-9)
    # what is missing may be so small that its square is 0
    hardly = SimpleNamespace(total=lambda *_: 1e-200, stiffness=lambda *_: 1.0)
    assert settled_place(hardly, 0.0, near) is None
    below = resting_place(ideal(), 0.97 * PULL_IN, "rising")
    assert settled_place(ideal(), 1.02 * PULL_IN, below) is None
    assert settled_place(ideal(), 0.7 * PULL_IN, places["unstable"]) is None
