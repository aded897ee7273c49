"""Support and load as one value, and at the ports: what statics and modes make of them."""

import numpy as np
import pytest

from tactgen.geometry.bimorph.boundary_conditions import Ends, Springs, TipLoad
from tactgen.geometry.device.parameters import Load, Support
from tactgen.tmm.ports import elements as t
from tactgen.tmm.ports.loads import finger_stiffness

SPRINGS = Springs(3e6, 0.24, rotational_damping=4.46e-6, rotational_inertia=1e-12)


@pytest.mark.parametrize(
    ("load", "tip"),
    [
        (Load(kind="none", mass=1.0, stiffness=1.0), TipLoad()),
        (Load(kind="mass", mass=1e-5, stiffness=1.0), TipLoad(mass=1e-5)),
        (
            Load(kind="spring_damper", stiffness=5.0, damping=9.0, mass=1.0),
            TipLoad(stiffness=5.0, damping=9.0),
        ),
        (Load(), finger_stiffness),
    ],
    ids=["none", "mass", "spring_damper", "finger"],
)
def test_only_what_the_kind_reads_is_taken(load, tip):
    """The paper's springs are the support's; of a load the numbers of its kind alone count."""
    assert t.ends_of(Support(), load) == Ends(SPRINGS, tip)


def test_statics_and_modes_leave_damping_and_the_finger_out():
    """The finger has no constant stiffness or mass: static values and modes are the free tip's."""
    held = Springs(3e6, 0.24, rotational_inertia=1e-12)
    assert Ends(SPRINGS, finger_stiffness).lossless == Ends(held)
    loaded = Ends(SPRINGS, TipLoad(stiffness=5.0, damping=9.0, mass=1e-5))
    assert loaded.lossless == Ends(held, TipLoad(stiffness=5.0, mass=1e-5))
    assert Ends().lossless == Ends()


@pytest.mark.parametrize(
    ("ends", "loose"),
    [
        (Ends(), 0),
        (Ends(Springs(0.0, 0.24)), 1),
        (Ends(Springs(3e6, 0.0)), 1),
        (Ends(Springs(0.0, 0.0), finger_stiffness), 2),
        (Ends(Springs(0.0, 0.0), TipLoad(mass=1.0)), 2),
        (Ends(Springs(3e6, 0.0), TipLoad(stiffness=1.0)), 0),
    ],
)
def test_each_spring_stops_one_rigid_motion(ends, loose):
    """Masses, dampers and a load without a constant stiffness stop none."""
    assert ends.rigid_motions == loose


def test_outside_of_the_range_is_reported():
    """The finger says where it was not measured; other loads hold everywhere."""
    f = np.array([0.0, 9.9, 10.0, 500.0, 1000.0, 1000.1])
    expected = [True, True, False, False, False, True]
    assert t.outside_known_range(Load(), f).tolist() == expected
    assert not t.outside_known_range(Load(kind="mass", mass=1e-3), f).any()


def test_a_tip_load_is_spring_damper_and_mass():
    """In the order k + jΩ d − Ω² m."""
    (found,) = t.tip_stiffness(TipLoad(300.0, 0.5, 2e-6), np.array([100.0]))
    omega = 2 * np.pi * 100.0
    assert found == pytest.approx(300.0 + 0.5j * omega - 2e-6 * omega**2)


def test_a_contact_has_no_springs_before_it_is_loaded():
    """Read as any other support it would hold the base rigidly, and nobody would know."""
    with pytest.raises(ValueError, match=r"depend on its load; see tmm\.generator\.equilibrium"):
        t.ends_of(Support(kind="contact"), Load())
