"""A quadrature rule on tetrahedra, exact to degree 5, all weights positive, points inside.

Positive weights keep a convex energy convex when it is summed; scikit-fem's rule of
degree 4 has a negative one, and its rules from degree 5 on (version 12.0.2) do not
integrate polynomials of their degree.
"""

from __future__ import annotations

import itertools

import numpy as np

from tactgen.geometry.arrays import Floats

#: Barycentric coordinate that three corners share, and weight (N. J. Walkington, Quadrature
#: on simplices of arbitrary dimension, Carnegie Mellon University 2000; 14 points).
_THREE_ALIKE = (
    (0.31088591926330060980, 0.11268792571801585080),
    (0.092735250310891226402, 0.073493043116361949544),
)
#: Barycentric coordinate that two corners share, the others sharing the rest, and weight.
_TWO_ALIKE = (0.045503704125649649492, 0.042546020777081466438)


def tet_rule() -> tuple[Floats, Floats]:
    """Return points (3, 14) on the reference tetrahedron and weights (14,), their sum 1/6."""
    barycentric, weights = [], []
    for shared, weight in _THREE_ALIKE:
        for corner in range(4):
            barycentric.append(np.where(np.arange(4) == corner, 1.0 - 3.0 * shared, shared))
            weights.append(weight)
    shared, weight = _TWO_ALIKE
    for pair in itertools.combinations(range(4), 2):
        barycentric.append(np.where(np.isin(np.arange(4), pair), shared, 0.5 - shared))
        weights.append(weight)
    return np.array(barycentric).T[1:], np.array(weights) / 6.0
