"""The fit's own numerics on a resonator in closed form: misfits, starts, bounds, intervals."""

from dataclasses import dataclass
from itertools import product
from types import SimpleNamespace

import numpy as np
import pytest

from tactgen.validation.studies.identification import curve_fit
from tactgen.validation.studies.identification.curve_fit import Misfit
from tactgen.validation.studies.identification.measured_curve import MeasuredCurve

TRUTH = np.array([3.0, 40.0, 5.0])


@dataclass(frozen=True)
class Resonator:
    """A/(k − f² + i d f) of amplitude, stiffness and damping."""

    frequencies: np.ndarray

    def __call__(self, values):
        a, k, d = values
        return a / (k - self.frequencies**2 + 1j * d * self.frequencies)

    def thinned(self, most):
        at = np.arange(0, self.frequencies.size, 1 + self.frequencies.size // most)
        return Resonator(self.frequencies[at]), at


def sensitivities(model, values):
    _, k, d = values
    f = model.frequencies
    whole = k - f**2 + 1j * d * f
    return np.stack([np.ones(f.shape), -k / whole, -1j * d * f / whole], axis=1)


@pytest.fixture(autouse=True)
def closed_form(monkeypatch):
    monkeypatch.setattr(curve_fit, "sensitivities", sensitivities)


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
    misfit = Misfit(measured(phase=phase), noise)
    found = misfit.jacobian(MODEL(TRUTH), sensitivities(MODEL, TRUTH))
    assert found.shape == ((46 if phase else 23), 3)
    for i in range(3):
        step = np.where(np.arange(3) == i, 1e-5, 0.0)
        up, down = (misfit.residuals(MODEL(TRUTH * np.exp(s * step))) for s in (1.0, -1.0))
        assert found[:, i] == pytest.approx((up - down) / 2e-5, rel=1e-6, abs=1e-9)  # its square


def test_starts_are_the_best_that_differ():
    """The user's own first; what is no number never; none within a factor of two of another."""
    nodes = np.array([[1.0, 1.0], [4.0, 1.0], [7.9, 1.0], [4.0, 3.0], [64.0, 1.0], [512.0, 1.0]])
    costs = np.array([9.0, 1.0, 2.0, 3.0, np.nan, 5.0])
    assert curve_fit._starts(costs, nodes) == [0, 1, 3]
    assert curve_fit._starts(np.array([9.0, 9.0, 1.0, 2.0, np.inf, 0.5]), nodes) == [0, 5, 2]
    assert curve_fit._starts(np.array([0.5, 1.0, 2.0, 3.0, 4.0, 5.0]), nodes) == [0, 1]


def test_a_value_is_at_a_bound_if_the_data_push_it_there():
    """Towards it, from within a hundredth; negative values by their magnitude."""
    values = np.array([1.0, 1.0, -9.0, 9.0, 3.0, 1.02, 8.95])
    parameters = [SimpleNamespace(low=np.sign(v), high=np.sign(v) * 9.0) for v in values]
    slopes = np.array([0.5, -0.5, -0.5, 0.5, 0.5, 0.5, -0.5])
    misfit = SimpleNamespace(
        jacobian=lambda now, by: np.diag(slopes), residuals=lambda now: np.ones(7)
    )
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(curve_fit, "sensitivities", lambda *_: None)
        found = curve_fit._at_bounds(lambda v: v, misfit, parameters, values, list(range(7)))
        assert found == {0: "low", 2: "high", 6: "high"}
        some = curve_fit._at_bounds(lambda v: v, misfit, parameters, values, [1, 6])
    assert some == {6: "high"}
