"""The centre line between ends that move as given."""

import numpy as np

from tactgen.geometry.device.parameters import Beam, Bimorph, Device, Support
from tactgen.tmm.beam import port_quantities as shapes
from tactgen.tmm.beam import transfer_matrix
from tactgen.tmm.ports.excitation import PortState


def test_ends_that_move_rigidly_move_the_whole_line_so():
    """A row that nobody bends is straight, and ends where it was put; each counts (w' = -ψ)."""
    device, clamped = Device(bimorph=Bimorph(tab_length=1.5e-3)), Support(kind="clamped")
    row = transfer_matrix.sections(device, clamped, Beam(), lossy=False)
    height = sum(float(length) for _, length in row)
    base, turned = 3e-6, 2e-4
    ports = np.array([base, turned, base - turned * height, turned, 0.0])
    line = shapes.line_between(row, PortState(1.0, ports, 0.0), inertia=False)
    np.testing.assert_allclose(line.w, base - turned * line.z, rtol=1e-9)
    np.testing.assert_allclose(line.psi, turned, rtol=1e-9)
    ports = np.array([base, turned, -2.0 * base, -3.0 * turned, 7.0])
    line = shapes.line_between(row, PortState(1.0, ports, 0.0))
    ends = [line.w[0], line.psi[0], line.w[-1], line.psi[-1], line.voltage]
    np.testing.assert_allclose(ends, ports, rtol=1e-14)
