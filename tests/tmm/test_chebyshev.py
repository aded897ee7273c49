"""Products of Chebyshev polynomials, against numpy's and against differences."""

import numpy as np
import pytest
from numpy.polynomial import chebyshev

from tactgen.tmm.chebyshev import Products, weighted_powers

LOW, HIGH = np.array([-1.0, 0.5, 2.0]), np.array([1.0, 4.0, 3.0])
PRODUCTS = Products(LOW, HIGH, weighted_powers((1.0, 1.5, 1.0), 4.0))
INSIDE = LOW + (HIGH - LOW) * np.random.default_rng(1).random((7, 3))


def test_terms_are_numpys():
    unit = 2.0 * (INSIDE - LOW) / (HIGH - LOW) - 1.0
    for powers, term in zip(PRODUCTS.powers, PRODUCTS(INSIDE).T, strict=True):
        by_variable = [
            chebyshev.chebval(unit[:, k], np.eye(1, n + 1, n)[0]) for k, n in enumerate(powers)
        ]
        np.testing.assert_allclose(term, np.prod(by_variable, axis=0), atol=1e-13)


@pytest.mark.parametrize("variable", [0, 1, 2])
def test_slopes_are_those_of_differences(variable):
    """At the ends of the range, too, where the angle's sine vanishes."""
    points, step = np.concatenate([INSIDE, [LOW + 1e-6, HIGH - 1e-6]]), np.zeros(3)
    step[variable] = 1e-7
    by_difference = (PRODUCTS(points + step) - PRODUCTS(points - step)) / 2e-7
    np.testing.assert_allclose(PRODUCTS.slope(points, variable), by_difference, atol=1e-5)


def test_beyond_the_range_its_end_counts():
    beyond = np.array([5.0, 2.0, 2.5])
    np.testing.assert_allclose(PRODUCTS(beyond), PRODUCTS(np.array([1.0, 2.0, 2.5])))
    assert PRODUCTS.outside(beyond) == (0,)
    assert not PRODUCTS.slope(beyond, 0).any()


def test_degrees_by_weight():
    """All products within the degree, none twice; an infinite weight leaves a variable out."""
    found = weighted_powers((1.0, 2.0, np.inf), 4.0)
    expected = {(i, j, 0) for i in range(5) for j in range(3) if i + 2 * j <= 4}
    assert {tuple(row) for row in found.tolist()} == expected
    assert len(found) == len(expected)
