"""Support and load as one value: what statics, modes and other masses make of it."""

import pytest

from tactgen.geometry.bimorph.boundary_conditions import Ends, Springs, TipLoad
from tactgen.geometry.device.parameters import Load, Support
from tactgen.tmm.ports.elements import ends_of
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
    assert ends_of(Support(), load) == Ends(SPRINGS, tip)


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
        (Ends(SPRINGS, TipLoad(stiffness=1.0)), 0),
    ],
)
def test_each_spring_stops_one_rigid_motion(ends, loose):
    """Masses, dampers and a load without a constant stiffness stop none."""
    assert ends.rigid_motions == loose
