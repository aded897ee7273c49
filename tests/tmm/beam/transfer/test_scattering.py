"""Joining elements in wave variables: no digit is lost however many there are."""

import numpy as np
import pytest
from port_distance import distance

from tactgen.geometry.device.parameters import Beam, Bimorph, Device, Support
from tactgen.tmm.beam import transfer_matrix as tmm
from tactgen.tmm.beam.scattering import joined
from tactgen.tmm.beam.sections import Joint
from tactgen.tmm.beam.span import dynamic_stiffness
from tactgen.tmm.ports.multiport import passivity_margin, reciprocity_error

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


def test_order_matters_and_grouping_does_not():
    """Tab and ceramic are not ceramic and tab; a chain's middle may be joined first."""
    device = Device(bimorph=Bimorph(tab_length=2e-3))
    tab, active = tmm.sections(device, SUPPORT, Beam(), lossy=True)
    assert distance(joined([tab, active], OMEGA), joined([active, tab], OMEGA)) > 0.1
    halves = [(active[0], 0.5 * active[1])] * 2
    one, other = joined([tab, active, tab], OMEGA), joined([tab, *halves, tab], OMEGA)
    # roundings, magnified by the ratio of the ceramic's to the tab's bending stiffness, 14, and
    # by the nearness of a pole of the row
    assert distance(one, other) < 1e-12


@pytest.mark.parametrize("lossy", [True, False])
def test_invariants(lossy):
    """A stepped, tapered, partly bare, glued row is reciprocal and passive; lossless it is real."""
    device = Device(
        bimorph=Bimorph(
            tab_length=2e-3, bare_below=1e-3, bare_above=3e-3, glue_thickness=10e-6,
            width_profile=((0, 2.1e-3), (8e-3, 2e-3), (8e-3, 1e-3), (20e-3, 0.8e-3)),
            piezo_thickness_profile=((0, 0.26e-3), (20e-3, 0.15e-3)),
        )
    )  # fmt: skip
    port = tmm.multiport(device, Support(kind="rod"), Beam(), FREQUENCIES, lossy=lossy)
    assert reciprocity_error(port).max() < 1e-12
    if lossy:
        assert passivity_margin(port).min() > -1e-12
    else:
        assert np.all(port.stiffness.imag == 0.0)


def test_a_joint_adds_its_compliance():
    """At rest a cantilever on an elastic joint is softer by exactly the joint."""
    section, l = beam(lossy=False)
    joint = Joint(np.array([[1e-8, -2e-6], [-2e-6, 1.0]]))
    soft, stiff = (
        np.linalg.inv(joined(row, np.zeros(1))[0, 2:4, 2:4])
        for row in ([(joint, 0.0), (section, l)], [(section, l)])
    )
    lever = np.array([[1.0, -l], [0.0, 1.0]])
    np.testing.assert_allclose(soft - stiff, lever @ joint.compliance @ lever.T, rtol=1e-11)
