"""Joining elements in wave variables: no digit is lost however many there are."""

import numpy as np
import pytest
from port_distance import distance

from tactgen.geometry.device.parameters import Beam, Bimorph, Device, Support
from tactgen.tmm.beam import transfer_matrix as tmm
from tactgen.tmm.beam.scattering import joined
from tactgen.tmm.beam.span import dynamic_stiffness

FREQUENCIES = np.array([0.0, 1e-3, 10.0, 445.0, 1000.0, 5000.0, 20000.0])
OMEGA = 2.0 * np.pi * FREQUENCIES
SUPPORT = Support()


def beam(length=20e-3, *, lossy=True):
    ((section, l),) = tmm.sections(
        Device(bimorph=Bimorph(length=length)), SUPPORT, Beam(), lossy=lossy
    )
    return section, l


@pytest.mark.parametrize("lossy", [True, False])
@pytest.mark.parametrize("length", [0.2e-3, 20e-3, 5.0])
def test_unequal_segments_equal_the_whole(length, lossy):
    """A thousand segments of different lengths, stubby or slender, from 0 Hz to 20 kHz."""
    section, l = beam(length, lossy=lossy)
    lengths = np.linspace(0.5, 1.5, 1000) * l / 1000
    got = joined([(section, float(part)) for part in lengths], OMEGA[::2])
    # the requirement; a dozen roundings, 3e-15, but for poles of the lossless 5 m beam, a
    # thousand of which lie below 20 kHz: 4e-12
    assert distance(got, dynamic_stiffness(section, l, OMEGA[::2])) < 1e-11


def test_stiff_and_soft_elements():
    """A tab on a rod 60 times stiffer, cut in 300 each, is the same row."""
    device = Device(bimorph=Bimorph(tab_length=2e-3))
    row = tmm.sections(device, Support(kind="rod"), Beam(), lossy=True)
    cut = [
        entry
        for element, length in row
        for entry in ([(element, length / 300)] * 300 if length else [(element, length)])
    ]
    assert distance(joined(cut, OMEGA), joined(row, OMEGA)) < 1e-11
