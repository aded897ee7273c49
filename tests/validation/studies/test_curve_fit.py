"""The fit's own numerics on a resonator in closed form: misfits, starts, bounds, intervals."""

from dataclasses import dataclass
from itertools import product

import numpy as np
import pytest

from tactgen.validation.studies.curve_fit import Fit, Misfit, starts
from tactgen.validation.studies.measured_data import MeasuredCurve

TRUTH = np.array([3.0, 40.0, 5.0])


@dataclass(frozen=True)
class Resonator:
    """A/(k − f² + i d f) of amplitude, stiffness and damping."""

    frequencies: np.ndarray

    def __call__(self, values):
        a, k, d = values
        return a / (k - self.frequencies**2 + 1j * d * self.frequencies)

    def sensitivities(self, values):
        _, k, d = values
        f = self.frequencies
        whole = k - f**2 + 1j * d * f
        return np.stack([np.ones(f.shape), -k / whole, -1j * d * f / whole], axis=1)


MODEL = Resonator(np.linspace(1.0, 12.0, 23))


def measured(*, phase=True, off=0.1):
    """Return the resonator's curve, a little off, with weights and uncertainties that differ."""
    f = MODEL.frequencies
    values = MODEL(TRUTH) * np.exp(off * np.cos(3.0 * f) + 0.7j * off * np.sin(5.0 * f))
    size = np.abs(values)
    return MeasuredCurve(
        "made", "velocity", f, values if phase else size, 0.05 * size + 1e-3, 1.0 + 0.1 * f
    )


MISFITS = list(product(("relative", "constant", "stated"), (True, False)))


@pytest.mark.parametrize(("noise", "phase"), MISFITS)
def test_slopes_of_a_misfit_are_those_of_its_residuals(noise, phase):
    """By central differences over ln p; of a magnitude the real part alone."""
    fit = Fit(MODEL, Misfit(measured(phase=phase), noise), TRUTH / 9.0, TRUTH * 9.0)
    slopes = fit.jacobian(TRUTH)
    assert slopes.shape == ((46 if phase else 23), 3)
    for i in range(3):
        step = np.where(np.arange(3) == i, 1e-5, 0.0)
        up, down = (fit.residuals(TRUTH * np.exp(s * step)) for s in (1.0, -1.0))
        assert slopes[:, i] == pytest.approx((up - down) / 2e-5, rel=1e-6, abs=1e-9)  # its square


def test_starts_are_the_best_that_differ():
    """The user's own first; what is no number never; none within a factor of two of another."""
    nodes = np.array([[1.0, 1.0], [4.0, 1.0], [7.9, 1.0], [4.0, 3.0], [64.0, 1.0], [512.0, 1.0]])
    assert starts(np.array([9.0, 1.0, 2.0, 3.0, np.nan, 5.0]), nodes) == [0, 1, 3]
    assert starts(np.array([9.0, 9.0, 1.0, 2.0, np.inf, 0.5]), nodes) == [0, 5, 2]
    assert starts(np.array([0.5, 1.0, 2.0, 3.0, 4.0, 5.0]), nodes) == [0, 1]


@pytest.mark.parametrize("noise", ["relative", "constant", "stated"])
def test_profile_and_bounds(noise):
    """A profile ends where the refitted sum of squares has risen, or openly at a bound.

    Ends are located to two hundredths of their distance, so a rise to some 4 % of itself.
    """
    fit = Fit(MODEL, Misfit(measured(), noise), TRUTH / 9.0, TRUTH * 9.0)
    least, best = fit.descend(TRUTH, [0, 1, 2], most=100)
    rise = 0.3 * least
    low, high, opened = fit.profile(best, 2, rise, np.nan)
    assert low < best[2] < high
    assert not opened
    for end in (low, high):
        risen, _ = fit.descend(np.array([best[0], best[1], end]), [0, 1], most=100)
        assert risen - least == pytest.approx(rise, rel=0.05)
    tight = Fit(
        MODEL, fit.misfit, best / 9.0, np.array([best[0] * 9.0, best[1] * 9.0, best[2] * 0.9])
    )
    assert tight.at_bounds(np.array([best[0], best[1], best[2] * 0.9]), [0, 1, 2]) == {2: "high"}
    assert not fit.at_bounds(best, [0, 1, 2])
    narrow = Fit(MODEL, fit.misfit, best * 0.999, best * 1.001)
    assert narrow.profile(best, 2, 1e3 * least, np.nan)[2] == ("low", "high")
