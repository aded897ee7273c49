"""The machine in small motions: the paper's support as a limit, reciprocity, passivity, poles."""

import numpy as np
import pytest

from tactgen.geometry.device.parameters import Beam, Device, Spring, Support
from tactgen.geometry.errors import InputError
from tactgen.tmm.beam import transfer_matrix as tmm
from tactgen.tmm.generator.equilibrium import axial_forces, resting_place, resting_places
from tactgen.tmm.generator.small_signal import (
    axial_poles,
    linearised,
    machine,
    resting_tilt,
    rod_ports,
)
from tactgen.tmm.ports.multiport import passivity_margin, reciprocity_error
from tactgen.tmm.reluctance.map_range import network_map

FREQUENCIES = np.array([0.0, 10.0, 100.0, 446.0, 800.0, 1000.0])


def about(current=0.0, history="rising", **groups):
    """Return device, map, place and linearisation at a current."""
    device = Device(**groups)
    pull = network_map(device)
    place = resting_place(axial_forces(device, pull), current, history)
    return device, pull, place, linearised(device, Beam(), place, current, pull)


CASES = [
    (0.0, "rising", {}),
    (50e-3, "rising", {}),
    (50e-3, "falling", {}),
    (50e-3, "falling", {"spring": Spring(eccentricity=0.1e-3)}),
]


@pytest.mark.parametrize(("current", "history", "groups"), CASES)
def test_reciprocal_and_passive(current, history, groups):
    """What the coil does to the tip and the tip to the coil is one number; no port gives power:
    spring, contact and field only store it, the rest takes it."""
    device, *_, linear = about(current, history, **groups)
    whole = machine(tmm.multiport(device, Support(), Beam(), FREQUENCIES), linear)
    assert reciprocity_error(whole).max() < 1e-12
    assert passivity_margin(whole).min() > -1e-12
    assert passivity_margin(rod_ports(linear, FREQUENCIES)).min() > -1e-12


def test_slopes_are_those_of_the_static_balance():
    """Axial stiffness, pull and flux linkage against differences of the map and the stops."""
    device, pull, place, linear = about(50e-3, "falling")
    assert linear.stiffness[2, 2] == pytest.approx(place.stiffness, rel=1e-6)
    gap, step = device.gap + place.lift, 1e-9
    linkage = pull.flux_linkage(50e-3, np.array([gap - step, gap + step]))
    assert linear.motional == pytest.approx(np.diff(linkage)[0] / (2 * step), rel=1e-6)
    step = 1e-6
    force = pull.force(np.array([50e-3 - step, 50e-3 + step]), gap)
    assert linear.motional == pytest.approx(-np.diff(force)[0] / (2 * step), rel=1e-5)


def test_poles_of_the_axial_motion():
    """Free of the stops a mass on a spring; unstable where the pull grows faster; a voltage
    supply's third pole is the coil's."""
    _, _, _, linear = about(0.0)
    poles = axial_poles(linear, voltage=False)
    m, d, k = (a[2, 2] for a in (linear.mass, linear.damping, linear.stiffness))
    assert poles[-1] == pytest.approx(-d / (2 * m) + 1j * np.sqrt(k / m - (d / (2 * m)) ** 2))
    assert (poles.real < 0.0).all()
    three = axial_poles(linear, voltage=True)
    assert three.size == 3
    coil = -linear.resistance / linear.inductance
    assert np.abs(three - coil).min() < 1e-9 * abs(coil)  # no current, no force, no coupling


def test_the_unstable_place_has_a_growing_pole():
    """Between the stops at 50 mA: the static criterion and the poles agree, by either supply."""
    device = Device()
    pull = network_map(device)
    for place in resting_places(axial_forces(device, pull), 50e-3):
        linear = linearised(device, Beam(), place, 50e-3, pull)
        for voltage in (False, True):
            growing = (axial_poles(linear, voltage=voltage).real > 0.0).any()
            assert growing == (place.kind == "unstable")


def test_a_spring_beyond_the_heads_edge_is_refused():
    wide = Device(spring=Spring(eccentricity=1.2e-3))
    with pytest.raises(InputError, match="tips the rod's head"):
        resting_tilt(wide, resting_place(axial_forces(wide, None), 0.0, "rising"))
