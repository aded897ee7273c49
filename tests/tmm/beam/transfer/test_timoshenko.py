"""Accuracy of the dynamic stiffness, entry by entry, from 0 Hz to 1 MHz and 0.1 mm to 10 m.

The yardstick is an independent solution with 80 digits, every entry judged by its own size.
"""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tactgen.geometry.bimorph.segments import Piece
from tactgen.geometry.device.parameters import Beam, Device
from tactgen.tmm.beam.sections import Section, section
from tactgen.tmm.beam.span import condition, dynamic_stiffness, error_bound, wavenumbers
from tactgen.validation.evidence.cases import exact_beam as reference
from tactgen.validation.evidence.stress_beam import CONDITION_LIMIT

EPS = np.finfo(float).eps

LENGTHS = (1e-4, 5e-3, 20e-3, 1.0, 10.0)
#: Both sides of the cut-off of the second spectrum, 860.3 kHz, among them.
FREQUENCIES = (0.0, 1e-6, 1.0, 1e2, 1e3, 1e4, 1e5, 8.6e5, 8.62e5, 1e6)


def bimorph(*, lossy):
    return section(Piece("bimorph", 20e-3), Device(), Beam(), lossy=lossy)


def assert_accurate(beam, length, omega):
    """Every entry is within the promised bound, and within 1e-12 where that is promised."""
    exact = reference.dynamic_stiffness(reference.constants(beam), length, omega)
    got, kappa = dynamic_stiffness(beam, length, omega), condition(beam, length, omega)
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
            assert error <= error_bound(kappa[i, j]), at
            if kappa[i, j] < CONDITION_LIMIT:
                assert error <= 1e-12, at


@pytest.mark.parametrize("lossy", [True, False])
@pytest.mark.parametrize("length", LENGTHS)
def test_every_entry_to_twelve_digits(length, lossy):
    """1e-12 of each entry's own size, exponentially small transmissions included."""
    for frequency in FREQUENCIES:
        assert_accurate(bimorph(lossy=lossy), length, 2 * np.pi * frequency)


@given(
    length=st.floats(-4, 1), frequency=st.floats(-3, 6), lossy=st.booleans(),
    slenderness=st.floats(-2, 2), inertia=st.floats(-2, 1),
)  # fmt: skip
def test_accuracy_for_other_sections(length, frequency, lossy, slenderness, inertia):
    """The same holds for sections much softer or stiffer in shear, with other rotary inertia."""
    beam = bimorph(lossy=lossy)
    beam = replace(beam, GA=beam.GA * 10**slenderness, rhoI=beam.rhoI * 10**inertia)
    assert_accurate(beam, 10.0**length, 2 * np.pi * 10.0**frequency)


@pytest.mark.parametrize("step", [1e-3, 1e-6, 1e-9, 1e-12, 0.0])
@pytest.mark.parametrize("length", [20e-3, 10.0])
def test_at_the_cut_off(length, step):
    """Around ρI Ω² = GA, to the last bit and over 1e4 wavelengths of the second spectrum."""
    beam = bimorph(lossy=False)
    assert_accurate(beam, length, np.sqrt(beam.GA / beam.rhoI) * (1.0 + step))


def test_condition_is_the_distance_to_a_pole():
    """Halving the distance to a resonance of the held beam doubles the condition number."""
    beam, pole = bimorph(lossy=False), 2 * np.pi * 6535.0
    # the pole by Newton's iteration on 1/D
    for _ in range(20):
        a, b = (1.0 / dynamic_stiffness(beam, 20e-3, pole * (1 + s))[0, 0].real for s in (0, 1e-7))
        pole -= a / ((b - a) / (1e-7 * pole))
    near, nearer = (condition(beam, 20e-3, pole * (1 + s))[0, 0] for s in (2e-5, 1e-5))
    assert nearer / near == pytest.approx(2.0, rel=1e-2)
    assert nearer > 1e4


def test_inputs_broadcast():
    """Arrays of sections, lengths and frequencies give what each combination gives alone."""
    one = bimorph(lossy=True)
    moduli = one.EI * np.array([0.5, 1.0, 2.0])[:, None, None]
    lengths, omega = np.array([1e-3, 20e-3])[:, None], 2 * np.pi * np.array([0.0, 1e2, 1e4, 1e6])
    d = dynamic_stiffness(replace(one, EI=moduli), lengths, omega)
    assert d.shape == (3, 2, 4, 5, 5)
    for i, j, k in np.ndindex(3, 2, 4):
        beam = replace(one, EI=moduli[i, 0, 0])
        alone = dynamic_stiffness(beam, lengths[j, 0], omega[k])
        np.testing.assert_allclose(d[i, j, k], alone, rtol=4 * EPS, atol=0.0)


@pytest.mark.parametrize("name", ["EI", "GA", "m", "rhoI", "K", "C", "length"])
@pytest.mark.parametrize("frequency", [0.0, 300.0, 2e4, 8.7e5])
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
