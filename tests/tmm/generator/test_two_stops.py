"""Two stops with contacts of their own: the board above, the sleeve below."""

import numpy as np
import pytest

from tactgen.geometry.device.parameters import Contact, Device
from tactgen.tmm.generator.contact import contact_of, stops_of
from tactgen.tmm.generator.equilibrium import held_support
from tactgen.tmm.reluctance.map_range import network_map

OWN = Device(contact=Contact(lower_decay_ratio=0.5, lower_relaxation_ratio=0.25))


def test_ratios_are_the_lower_stops():
    """Both lengths and times; with ratios of 1 both stops are alike to the last bit."""
    above, below = (contact_of(OWN, stop) for stop in ("upper", "lower"))
    assert above == contact_of(Device(), "upper")
    assert below.decay_length == 0.5 * above.decay_length
    assert below.relaxation_time == 0.25 * above.relaxation_time
    assert contact_of(Device(), "lower") == above


@pytest.mark.parametrize(("end", "shape"), [(0.0, "disc"), (-1.0, "ring")])
def test_slopes_and_losses_are_each_stops_own(end, shape):
    """Against central differences of the forces, near either stop; the loss is its own time's."""
    contact = OWN.contact.model_copy(update={"shape": shape})
    stops = stops_of(OWN.model_copy(update={"contact": contact}))
    law = stops.lower if end else stops.upper
    lift, tilt = end * stops.stroke + 0.3 * law.decay_length, 0.7 * law.decay_length / law.radius
    rate = np.array([[0.2, -30.0]])
    at, *slopes = stops.moving(np.array([lift]), np.array([tilt]), rate)
    stiffness, damping, change = (found[0] for found in slopes)
    np.testing.assert_allclose(at[0], stops.forces(lift, tilt), rtol=1e-13)
    np.testing.assert_allclose(stiffness, stops.tangent(lift, tilt), rtol=1e-13)
    for k, by in enumerate(1e-4 * law.decay_length * np.array([1.0, 1.0 / law.radius])):
        du, dpsi = by * np.eye(2)[k]
        moved = stops.forces(lift + du, tilt + dpsi) - stops.forces(lift - du, tilt - dpsi)
        np.testing.assert_allclose(stiffness[:, k], moved / (2.0 * by), rtol=1e-6)
    time = 1e-4 * law.decay_length / 0.2
    ahead, behind = (
        stops.moving(*(np.array([[lift], [tilt]]) + s * time * rate.T), rate)[2][0] for s in (1, -1)
    )
    np.testing.assert_allclose(change, (ahead - behind) / (2.0 * time), rtol=1e-5)
    # the other stop is hundreds of decay lengths away
    np.testing.assert_allclose(damping, law.relaxation_time * stiffness, rtol=1e-12)


def test_only_a_rod_held_down_feels_the_lower_one():
    """Half the decay length is twice the stiffness there, in any direction, and half the loss."""
    pull = network_map(OWN)
    for device in (Device(), OWN):
        assert stops_of(device).holding(-1e-7) == contact_of(device, "upper")
    assert held_support(OWN, pull, 50e-3, "rising") == held_support(Device(), pull, 50e-3, "rising")
    (place, own), (same, usual) = (
        held_support(device, pull, 50e-3, "falling") for device in (OWN, Device())
    )
    # the surfaces give way by less, so the gap is some nanometres wider and the pull smaller
    assert place.contact_force == pytest.approx(same.contact_force, rel=2e-2)
    load, guide = place.contact_force / same.contact_force, Device().guide
    for name, rest in (("rotational_stiffness", guide.rotational_stiffness),
                       ("lateral_stiffness", guide.lateral_stiffness)):  # fmt: skip
        ratio = (getattr(own, name) - rest) / (getattr(usual, name) - rest)
        assert ratio == pytest.approx(2.0 * load, rel=1e-9)
    assert own.rotational_damping == pytest.approx(0.5 * load * usual.rotational_damping, rel=1e-9)
