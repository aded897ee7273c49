"""Springs and masses at the ports: closed forms, and invariants of whatever they join."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from port_distance import distance

from tactgen.geometry.bimorph.boundary_conditions import Ends, Springs
from tactgen.geometry.device.parameters import Beam, Device, Support
from tactgen.tmm.beam import transfer_matrix as tmm
from tactgen.tmm.ports.elements import attach, spring
from tactgen.tmm.ports.multiport import AXIAL, LATERAL, ROTATION, connect, hold, reduce

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
