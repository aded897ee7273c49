"""Accuracy of the dynamic stiffness, entry by entry, from 0 Hz to 1 MHz and 0.1 mm to 10 m.

The yardstick is an independent solution with 80 digits, every entry judged by its own size.
"""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tactgen.geometry.bimorph.segments import Piece
from tactgen.geometry.device.parameters import Beam, Device
from tactgen.tmm.beam.sections import Section, section
from tactgen.tmm.beam.span import dynamic_stiffness, rounding
from tactgen.validation.evidence.cases import exact_beam as reference


def bimorph(*, lossy):
    return section(Piece("bimorph", 20e-3), Device(), Beam(), lossy=lossy)


def assert_accurate(beam, length, omega):
    """Every entry is within its bound."""
    exact = reference.dynamic_stiffness(reference.constants(beam), length, omega)
    got, bound = dynamic_stiffness(beam, length, omega), rounding(beam, length, omega)
    for i in range(5):
        for j in range(5):
            if 4 in (i, j) and {i, j} & {0, 2}:
                assert got[i, j] == 0.0
                continue
            size = abs(exact[i, j])
            if size < 1e-290:  # a transmission that leaves the range of doubles
                assert abs(got[i, j]) < 1e-280
                continue
            error = reference.relative_error(got[i, j], exact[i, j])
            at = (i, j, length, omega / (2 * np.pi))
            assert error <= bound[i, j], at


@settings(max_examples=12)
@given(
    length=st.floats(-4, 1), frequency=st.floats(-3, 6), lossy=st.booleans(),
    slenderness=st.floats(-2, 2), inertia=st.floats(-2, 1),
)  # fmt: skip
def test_accuracy_for_other_sections(length, frequency, lossy, slenderness, inertia):
    """Also of sections much softer or stiffer in shear, and of other rotary inertia."""
    beam = bimorph(lossy=lossy)
    beam = replace(beam, GA=beam.GA * 10**slenderness, rhoI=beam.rhoI * 10**inertia)
    assert_accurate(beam, 10.0**length, 2 * np.pi * 10.0**frequency)


@pytest.mark.parametrize("frequency", [10.0, 250.0, 1000.0])
def test_bounds_are_small_where_it_is_used(frequency):
    """A device's length and band: thirteen digits of every entry."""
    assert rounding(bimorph(lossy=True), 20e-3, 2 * np.pi * frequency).max() < 1e-13


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


def test_euler_bernoulli_limit():
    """Rigid in shear and without rotary inertia, D has the classical clamped-free resonance."""
    # cosh λ cos λ = −1 at λ = 1.8751040687119611 (classical)
    beam = Section(EI=2.0, GA=1e25, m=3.0, rhoI=0.0)
    omega = 1.8751040687119611**2 * np.sqrt(2.0 / 3.0)
    d = dynamic_stiffness(beam, 1.0, omega * np.array([1 - 1e-9, 1 + 1e-9]))[:, 2:4, 2:4]
    below, above = np.linalg.det(d).real
    assert below > 0.0 > above
    # the root to 1e-14 by linear interpolation
    assert abs((below + above) / (below - above)) * 1e-9 < 1e-14


def test_huge_arguments_stay_finite():
    """No overflow, no NaN, no warning (warnings are errors here) far beyond any use."""
    d = dynamic_stiffness(bimorph(lossy=True), 1e3, 2 * np.pi * np.array([1e-9, 1e3, 1e6, 1e9]))
    assert np.isfinite(d).all()


def test_the_reference_agrees_with_itself():
    """Doubling a short beam and one matrix exponential give the same D to 40 digits."""
    beam = reference.constants(bimorph(lossy=True))
    omega = 2 * np.pi * 1e5
    long, half = (reference.dynamic_stiffness(beam, x, omega) for x in (0.04, 0.02))
    joined = reference.join(half, half)
    with reference.mp.workdps(reference.DIGITS):
        assert max(abs(x) for x in joined - long) < max(abs(x) for x in long) * 1e-40
