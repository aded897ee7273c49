"""A span's dynamic stiffness, its bounds and derivatives, its 80 digits, and rows of spans.

How far it is from these digits, entry by entry, says the stress run.
"""

from dataclasses import replace

import numpy as np
import pytest
from port_distance import distance

from tactgen.geometry.bimorph.segments import Piece
from tactgen.geometry.device.parameters import Beam, Device
from tactgen.tmm.beam.printed_formulas import from_dynamic_stiffness, matrix_a
from tactgen.tmm.beam.scattering import joined
from tactgen.tmm.beam.sections import section
from tactgen.tmm.beam.span import dynamic_stiffness, rounding
from tactgen.validation.evidence.cases import exact_beam as reference


def bimorph(*, lossy):
    return section(Piece("bimorph", 20e-3), Device(), Beam(), lossy=lossy)


def test_bounds_are_small_where_it_is_used():
    """A device's length and band: thirteen digits of every entry."""
    omega = 2 * np.pi * np.array([10.0, 250.0, 1000.0])
    assert max(rounding(bimorph(lossy=True), 20e-3, at).max() for at in omega) < 1e-13


@pytest.mark.parametrize("name", ["EI", "GA", "m", "rhoI", "K", "C", "length"])
@pytest.mark.parametrize("frequency", [0.0, 300.0, 8.7e5])
def test_analytic_in_every_constant(name, frequency):
    """A derivative by a contour of complex values equals the one by real steps."""
    beam, length, omega = bimorph(lossy=True), 20e-3, 2 * np.pi * frequency

    def d(factor):
        if name == "length":
            return dynamic_stiffness(beam, length * factor, omega)
        return dynamic_stiffness(
            replace(beam, **{name: getattr(beam, name) * factor}), length, omega
        )

    # Cauchy's integral over 8 points; the next term of the Taylor series is radius^8 smaller
    radius, step = 1e-5, 1e-6
    turns = np.exp(2j * np.pi * np.arange(8) / 8)
    contour = sum(d(1 + radius * t) / t for t in turns) / (8 * radius)
    steps = sum(c * d(1 + n * step) for n, c in ((-2, 1), (-1, -8), (1, 8), (2, -1))) / (12 * step)
    # differences over 1e-6 of entries known to 1e-13
    scale = np.abs(d(1.0)) + np.abs(steps)
    assert (np.abs(contour - steps) <= 1e-6 * scale).all()


@pytest.mark.parametrize(("length", "frequency"), [(20e-3, 300.0), (20e-3, 5e3), (3e-3, 1.5e6)])
def test_the_papers_matrix_a_is_the_same_span(length, frequency):
    """Every entry, also above the cut-off, to what its closed form loses."""
    beam, f = bimorph(lossy=True), np.array([frequency])
    found = matrix_a(beam, length, f)
    exact = from_dynamic_stiffness(dynamic_stiffness(beam, length, 2 * np.pi * f), f)
    np.testing.assert_allclose(found, exact, rtol=1e-10)


def test_the_reference_agrees_with_itself():
    """Doubling a short beam and one matrix exponential give the same D to 40 digits."""
    beam = reference.constants(bimorph(lossy=True))
    omega = 2 * np.pi * 1e5
    long, half = (reference.dynamic_stiffness(beam, x, omega) for x in (0.04, 0.02))
    joined = reference.join(half, half)
    with reference.mp.workdps(reference.DIGITS):
        assert max(abs(x) for x in joined - long) < max(abs(x) for x in long) * 1e-40


@pytest.mark.parametrize("lossy", [True, False])
@pytest.mark.parametrize("length", [0.2e-3, 20e-3, 5.0])
def test_unequal_segments_equal_the_whole(length, lossy):
    """A thousand segments of different lengths, stubby or slender, from 0 Hz to 20 kHz."""
    beam, omega = bimorph(lossy=lossy), 2.0 * np.pi * np.array([0.0, 10.0, 1000.0, 20000.0])
    lengths = np.linspace(0.5, 1.5, 1000) * length / 1000
    got = joined([(beam, float(part)) for part in lengths], omega)
    # the requirement; a dozen roundings, 3e-15, but for poles of the lossless 5 m beam, a
    # thousand of which lie below 20 kHz: 4e-12
    assert distance(got, dynamic_stiffness(beam, length, omega)) < 1e-11
