"""B-spline bases: against SciPy's, and their exact integrals."""

import numpy as np
import pytest
from scipy.interpolate import BSpline

from tactgen.tmm.reluctance.coenergy_map import b_splines

BREAKS = np.array([0.0, 0.1, 0.15, 0.5, 1.2])
POINTS = np.linspace(0.0, 1.2, 61)


@pytest.mark.parametrize("degree", [1, 2, 3])
def test_values_and_derivatives_are_scipys(degree):
    """Another implementation gives the same functions and derivatives."""
    knots = np.concatenate([np.repeat(0.0, degree), BREAKS, np.repeat(1.2, degree)])
    basis = b_splines(BREAKS, degree)
    scipys = BSpline(knots, np.eye(len(BREAKS) - 1 + degree), degree)
    for derivative in range(degree):
        expected = scipys(POINTS, derivative)
        # rounding of polynomials whose coefficients go with the inverse powers of the spans
        np.testing.assert_allclose(basis(POINTS, derivative), expected, rtol=1e-9, atol=1e-9)


def test_integral_starts_at_zero_and_undoes_the_derivative():
    """∫ from the first break, continuous, and its derivative is the function."""
    basis = b_splines(BREAKS, 2)
    once = basis.integral()
    twice = once.integral()
    assert not once(np.array(0.0)).any()
    np.testing.assert_allclose(once(POINTS, 1), basis(POINTS), atol=1e-12)
    np.testing.assert_allclose(twice(POINTS, 2), basis(POINTS), atol=1e-12)
    left, right = once(BREAKS[1:-1] - 1e-12), once(BREAKS[1:-1] + 1e-12)
    np.testing.assert_allclose(left, right, atol=1e-11)  # the functions are at most 1
