"""The quadrature rule on tetrahedra: exactness, sign, place."""

import itertools
from math import factorial

import numpy as np
import pytest

from tactgen.fem.elements.skfem_mesh import tet_rule


@pytest.mark.parametrize("degree", range(7))
def test_integrates_all_monomials_to_degree_five(degree):
    """∫ x^i y^j z^k = i! j! k! / (i + j + k + 3)!, to rounding up to degree 5 and not at 6."""
    points, weights = tet_rule()
    powers = [p for p in itertools.product(range(7), repeat=3) if sum(p) == degree]
    worst = max(
        abs(
            weights @ np.prod(points.T ** np.array(p), axis=1)
            * factorial(degree + 3) / np.prod([float(factorial(k)) for k in p])
            - 1.0
        )
        for p in powers
    )  # fmt: skip
    assert (worst < 1e-13) == (degree <= 5)


def test_weights_are_positive_and_points_inside():
    """So that a sum of convex densities is convex, and no point lies on an interface."""
    points, weights = tet_rule()
    assert weights.min() > 0.0
    assert points.min() > 0.04
    assert points.sum(axis=0).max() < 0.96
