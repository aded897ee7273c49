"""Accuracy of one beam's dynamic stiffness, from 0 Hz to 1 MHz and 0.1 mm to 10 m.

The yardstick is the 60-digit solution, and what the problem itself allows: an entry that
changes by κ relative to itself when Ω changes by one cannot be known better than κ ε.
Measured over the whole range: |error| ≤ 4 ε (G + κ), κ = |Ω dD/dΩ| and G the geometric mean of
the diagonal neighbours.  In numbers: 1e-12 G or better wherever κ < 1000 G; the exceptions are
lossless beams of hundreds of wavelengths and the cut-off frequency (at 5 m within 1 % of it,
κ = 8e6 G and the error 4e-10 G).
"""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
import reference_beam as reference
from hypothesis import given
from hypothesis import strategies as st

from geometry.beam_pieces import Piece
from geometry.parameters import Beam, Device
from tmm.section import Section, section
from tmm.timoshenko import dynamic_stiffness, wavenumbers

EPS = np.finfo(float).eps
#: Roundings between input and result; the worst of 1200 random points took 3.5.
ROUNDINGS = 20

LENGTHS = (1e-4, 1e-3, 5e-3, 14e-3, 20e-3, 0.1, 1.0, 10.0)
#: Both sides of the cut-off of the second spectrum, 860.3 kHz, among them.
FREQUENCIES = (0.0, 1e-6, 1e-2, 1.0, 10.0, 1e2, 1e3, 1e4, 1e5, 3e5, 8.6e5, 8.62e5, 1e6)


def bimorph(*, lossy):
    return section(Piece("bimorph", 20e-3), Device(), Beam(), lossy=lossy)


def means(matrix):
    """Return the geometric means of the two diagonal neighbours of each entry."""
    size = np.sqrt(np.abs(np.diag(matrix)))
    return size[:, None] * size


@cache
def errors(beam, length, frequency):
    """Return |error|, exact D, κ and geometric means, all (5, 5)."""
    omega = 2 * np.pi * frequency
    exact, kappa = reference.stiffness_and_condition(reference.constants(beam), length, omega)
    got = dynamic_stiffness(beam, length, np.array([omega]))[0]
    kappa = np.maximum(kappa, means(kappa))
    return np.abs(got - exact), np.abs(exact), kappa, means(exact)


@pytest.mark.parametrize("lossy", [True, False])
@pytest.mark.parametrize("length", LENGTHS)
def test_accuracy_is_what_the_problem_allows(length, lossy):
    """Every entry is right to a few roundings of its neighbours or of Ω, at any frequency."""
    for frequency in FREQUENCIES:
        error, exact, kappa, mean = errors(bimorph(lossy=lossy), length, frequency)
        assert (error <= ROUNDINGS * EPS * (mean + kappa)).all(), frequency
        # entries that are not a vanishing transmission from end to end, by their own size
        own = exact > 1e-6 * mean
        assert (error[own] <= ROUNDINGS * EPS * (exact + kappa)[own]).all(), frequency


@pytest.mark.parametrize("lossy", [True, False])
@pytest.mark.parametrize("length", LENGTHS)
def test_twelve_digits_where_well_conditioned(length, lossy):
    """1e-12 of the neighbours' geometric mean wherever κ < 1000; always 1e-10."""
    for frequency in FREQUENCIES:
        error, _, kappa, mean = errors(bimorph(lossy=lossy), length, frequency)
        well = (kappa < 1000 * mean).all()
        assert (error <= (1e-12 if well else 1e-10) * mean).all(), frequency


@given(
    length=st.floats(-4, 1), frequency=st.floats(-3, 6), lossy=st.booleans(),
    slenderness=st.floats(-2, 2), inertia=st.floats(-2, 1),
)  # fmt: skip
def test_accuracy_for_other_sections(length, frequency, lossy, slenderness, inertia):
    """The same holds for sections much softer or stiffer in shear, with other rotary inertia."""
    beam = bimorph(lossy=lossy)
    beam = replace(beam, GA=beam.GA * 10**slenderness, rhoI=beam.rhoI * 10**inertia)
    error, _, kappa, mean = errors(beam, 10.0**length, 10.0**frequency)
    assert (error <= ROUNDINGS * EPS * (mean + kappa)).all()


def test_series_and_products_agree_where_they_meet():
    """D is smooth across the switch from series to products (near 1.1 kHz at 14 mm)."""
    frequencies = np.linspace(500.0, 4000.0, 4001)
    d = dynamic_stiffness(bimorph(lossy=True), 14e-3, 2 * np.pi * frequencies)
    second = np.abs(np.diff(d, n=2, axis=0))
    # curvature per step² plus four roundings; a mismatch of 1e-13 would stand out by far
    smooth = np.median(second, axis=0) * 30
    assert (second <= smooth + 16 * EPS * np.abs(d[1:-1])).all()


def test_static_limit_is_timoshenkos_element():
    """At 0 Hz D is finite and equal to the closed-form static element."""
    beam, l = bimorph(lossy=True), 20e-3
    d = dynamic_stiffness(beam, l, np.zeros(1))[0]
    phi = 12 * beam.EI / (beam.GA * l**2)
    unit = beam.EI / (l**3 * (1 + phi))
    assert d[0, 0] == pytest.approx(12 * unit, rel=1e-14)
    assert d[0, 1] == pytest.approx(-6 * l * unit, rel=1e-14)
    assert d[1, 1] == pytest.approx((4 + phi) * l**2 * unit, rel=1e-14)
    assert d[1, 3] == pytest.approx((2 - phi) * l**2 * unit, rel=1e-14)
    assert (d[1, 4], d[3, 4], d[4, 4]) == (beam.K, -beam.K, beam.C * l)


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


def test_exactly_at_the_cut_off():
    """Where λ₁ vanishes, ρI Ω² = GA, D equals its neighbours."""
    beam = Section(EI=1.0, GA=1.0, m=1.0, rhoI=1.0)
    d = dynamic_stiffness(beam, 3.0, np.array([1 - 1e-8, 1.0, 1 + 1e-8]))
    np.testing.assert_allclose(d[1], 0.5 * (d[0] + d[2]), rtol=1e-12, atol=1e-12)


def test_frequencies_are_independent():
    """A sweep gives at each frequency what that frequency gives alone, bit for bit."""
    omega = 2 * np.pi * np.geomspace(1e-3, 1e6, 50)
    together = dynamic_stiffness(bimorph(lossy=True), 20e-3, omega)
    alone = [dynamic_stiffness(bimorph(lossy=True), 20e-3, omega[i : i + 1])[0] for i in range(50)]
    np.testing.assert_allclose(together, alone, rtol=4 * EPS, atol=0.0)


def test_wavenumbers_solve_the_dispersion_relation():
    """λ² = −λ₁², λ₂² are the roots of EI GA k⁴ − … = 0 of the beam's equations."""
    beam, l = bimorph(lossy=False), 20e-3
    omega = 2 * np.pi * np.array([1e2, 1e4, 8e5, 2e6])
    first, second = wavenumbers(beam, l, omega)
    ei, o2 = beam.EI.real, omega**2
    for k2, sign in ((second / l, 1.0), (first / l, np.where(beam.rhoI * o2 > beam.GA, 1.0, -1.0))):
        k2 = sign * k2**2
        residual = (beam.GA * k2 - beam.m * o2) * (ei * k2 + beam.GA - beam.rhoI * o2)
        residual -= beam.GA**2 * k2
        assert (np.abs(residual) < 1e-12 * (beam.GA**2 * np.abs(k2) + ei * beam.GA * k2**2)).all()


def test_the_reference_agrees_with_itself():
    """Doubling a short beam and one matrix exponential give the same D to 40 digits."""
    beam = reference.constants(bimorph(lossy=True))
    omega = 2 * np.pi * 1e5
    long, half = (reference.dynamic_stiffness(beam, x, omega) for x in (0.04, 0.02))
    joined = reference.join(half, half)
    with reference.mp.workdps(reference.DIGITS):
        assert max(abs(x) for x in joined - long) < max(abs(x) for x in long) * 1e-40
