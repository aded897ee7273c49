"""Springs and masses at the ports: closed forms, and invariants of whatever they join."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from port_distance import distance

from tactgen.geometry.bimorph.boundary_conditions import Ends, Springs
from tactgen.geometry.device.parameters import Beam, Device, Support
from tactgen.tmm.beam import transfer_matrix as tmm
from tactgen.tmm.ports.elements import attach, spring
from tactgen.tmm.ports.multiport import (
    AXIAL,
    LATERAL,
    ROTATION,
    Multiport,
    Port,
    connect,
    hold,
    passivity_margin,
    reciprocity_error,
    reduce,
)

FREQUENCIES = np.array([0.0, 10.0, 500.0, 2e4])
OMEGA = 2.0 * np.pi * FREQUENCIES


def bimorph(frequencies=FREQUENCIES, *, lossy=True):
    return tmm.multiport(Device(), Support(), Beam(), frequencies, lossy=lossy)


def test_springs_to_the_ground_are_the_paper_support():
    """Springs joined to the base by name are what the ends attach."""
    springs = Springs(3e6, 0.24, rotational_damping=4.46e-6)
    lateral = spring(FREQUENCIES, LATERAL, stiffness=3e6, ends=("wall", "w"))
    turning = spring(FREQUENCIES, ROTATION, stiffness=0.24, damping=4.46e-6, ends=("floor", "psi"))
    machine = connect(connect(bimorph(), lateral, {"w_base": "w"}), turning, {"psi_base": "psi"})
    found = hold(machine, "wall", "floor")
    expected = attach(bimorph(), Ends(springs))
    assert found.ports == expected.ports
    assert distance(found.stiffness, expected.stiffness) < 1e-15


@given(st.floats(1e-2, 1e8), st.floats(1e-2, 1e8), st.floats(0.0, 1.0))
def test_springs_in_series(first, second, damping):
    """Compliances add, dampers and all; force goes through unchanged."""
    a = spring(FREQUENCIES, AXIAL, stiffness=first, damping=damping)
    b = spring(FREQUENCIES, AXIAL, stiffness=second, ends=("low", "top"))
    chain = reduce(connect(a, b.renamed({"low": "middle"}), {"high": "middle"}), ["low", "top"])
    one = first + 1j * OMEGA * damping
    expected = one * second / (one + second)
    np.testing.assert_allclose(chain["top", "low"], -expected, rtol=1e-14)
    # what the stiff end of a soft chain answers is the small difference of its own stiffness
    lost = np.abs(chain["low", "low"] - expected)
    assert (lost < 4.0 * np.finfo(float).eps * np.abs(one)).all()
    assert chain.names == ("low", "top")


def test_a_mass_on_a_spring_resonates():
    """It has Ω² = k/m, and there the damper alone answers."""
    stiffness, mass = 2e5, 1e-3
    f = np.sqrt(stiffness / mass) / (2.0 * np.pi) * np.array([1.0 - 1e-9, 1.0, 1.0 + 1e-9])
    held = hold(spring(f, AXIAL, stiffness=stiffness, damping=0.3), "low")
    inertia = -((2.0 * np.pi * f[:, None, None]) ** 2) * mass + 0j
    moving = Multiport(f, inertia, (Port("mass", AXIAL),))
    force = connect(held, moving, {"high": "mass"})["high", "high"]
    assert force.real[0] > 0.0 > force.real[2]
    assert force[1].imag == pytest.approx(2.0 * np.pi * f[1] * 0.3, rel=1e-15)


@given(st.floats(0.0, 1e9), st.floats(0.0, 1e3))
def test_every_spring_is_reciprocal_and_passive(stiffness, damping):
    """Whatever its values, it takes in no negative power, and 0 Hz is finite."""
    element = spring(FREQUENCIES, LATERAL, stiffness=stiffness, damping=damping)
    assert np.isfinite(element.stiffness).all()
    assert (reciprocity_error(element) == 0.0).all()
    # a pair of equal and opposite entries has an eigenvalue 0, found to a rounding
    assert (passivity_margin(element) >= -1e-15).all()
