"""Free and forced oscillations with a closed form, or published digits."""

import numpy as np
import pytest

from tactgen.tmm.harmonic_balance.balance import Orbit
from tactgen.tmm.harmonic_balance.steady import Resolution, free_oscillation
from tactgen.validation.evidence.cases import oscillators as cases


@pytest.mark.parametrize(
    ("amplitude", "printed"),
    [(0.1, 1.003741836), (0.5, 1.089158179), (1.0, 1.317776065), (2.0, 1.976016364),
     (5.0, 4.357461857)],
)  # fmt: skip
def test_free_duffing_oscillation(amplitude, printed):
    """x'' + x + x³ = 0: the elliptic integral to rounding, and its printed digits."""
    exact = cases.cubic_frequency(1.0, 1.0, 1.0, amplitude)
    assert exact == pytest.approx(printed, rel=3e-10)  # printed to ten digits
    assert cases.free_on_cubic(1.0, 1.0, 1.0, amplitude).omega == pytest.approx(exact, rel=1e-11)


def test_period_of_a_hardening_spring():
    """VM156: 2 x + 4 x³ under 2588e-6; the manual's 0.1447 s is 0.46 % above the exact period."""
    exact = 2.0 * np.pi / cases.cubic_frequency(2.0, 4.0, 2588e-6, 1.0)
    assert exact == pytest.approx(0.144043869, rel=4e-9)
    assert cases.period_of_vm156() == pytest.approx(exact, rel=1e-11)
    assert pytest.approx(1.0046, abs=5e-5) == 0.1447 / exact


def test_peak_and_folds_of_a_driven_duffing_oscillator():
    """Known to all digits that 7 and 15 harmonics of another program share; folds to six."""
    peak = cases.driven_duffing_peak()
    assert abs(cases.fundamental(peak)) == pytest.approx(2.83019806, abs=5e-9)
    assert peak.omega == pytest.approx(1.26871674, abs=5e-9)
    at = [fold.omega for fold in cases.driven_duffing_folds()]
    assert at == pytest.approx([1.26960, 1.11570], abs=5e-6)


@pytest.mark.parametrize("harmonics", [20, 40])
def test_one_sided_spring(harmonics):
    """The force's kink makes the frequency's error fall at least with the harmonics' third power.

    Estimate 1e-7 at 20 harmonics with a spring eleven times as stiff on one side.
    """
    found = cases.free_on_one_sided(10.0, harmonics)
    guess = Orbit(found.omega, 0.0, found.spectrum)
    system = cases.one_mass(cases.one_sided(10.0), stiffness=1.0)
    exactly = Resolution(missing=0.0, least=harmonics, most=harmonics)
    sharp = free_oscillation(system, -1.0, guess, resolution=exactly)
    bound = 3e-7 * (20.0 / harmonics) ** 3
    assert sharp.omega == pytest.approx(cases.one_sided_frequency(10.0), rel=bound)


@pytest.mark.parametrize("decade", range(-2, 7))
def test_contact_over_eight_decades(decade):
    """From a hundredth to a million times the other spring, where the contact is an impact.

    The bound is what the harmonics left out would move, at most 160 of them; the softer, the less.
    """
    ratio = 10.0**decade
    found = cases.free_on_one_sided(ratio, 160)
    assert found.omega == pytest.approx(cases.one_sided_frequency(ratio), rel=1e-3)
    if decade <= 3:
        assert found.omega == pytest.approx(cases.one_sided_frequency(ratio), rel=1e-5)
