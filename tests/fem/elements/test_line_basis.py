"""Polynomials of an axis in a hierarchy are those of its nodes, in other combinations."""

import numpy as np
import pytest
from scipy import sparse

from tactgen.fem.elements.line_basis import line_matrices, line_weights, nodal_values
from tactgen.geometry.bimorph.bricks import Axis

BREAKS = np.array([0.0, 0.3, 0.35, 2.0])


def dense(axis, *span):
    lines = line_matrices(axis, *span)
    shape = 2 * (axis.nodes.size,)
    at = (lines.rows, lines.columns)
    return [[sparse.csr_matrix((v, at), shape).toarray() for v in row] for row in lines.integrals]


@pytest.mark.parametrize("degree", [1, 2, 3, 5, 7])
@pytest.mark.parametrize("span", [(), (1, 3)])
def test_integrals_are_those_of_nodes_in_other_combinations(degree, span):
    """∫ ∂^a N ∂^b N, over all of the axis and over a part of it."""
    nodal, hierarchic = (Axis(BREAKS, degree, hierarchic=h) for h in (False, True))
    values = nodal_values(hierarchic)
    found, known = dense(hierarchic, *span), dense(nodal, *span)
    for a in range(2):
        for b in range(2):
            expected = values.T @ known[a][b] @ values
            # rounding
            assert np.abs(found[a][b] - expected).max() < 1e-12 * np.abs(known[a][b]).max()


@pytest.mark.parametrize("hierarchic", [False, True])
def test_one_and_position_are_what_they_say(hierarchic):
    """At the nodes, in the weights of a line, and without any strain of the first."""
    axis = Axis(BREAKS, 4, hierarchic=hierarchic)
    values = nodal_values(axis)
    assert values @ axis.one == pytest.approx(np.ones(axis.nodes.size), abs=1e-15)
    assert values @ axis.position == pytest.approx(axis.nodes, abs=1e-15)
    plain, levered = line_weights(axis)
    assert plain @ axis.one == pytest.approx(2.0)
    assert plain @ axis.position == pytest.approx(2.0)
    assert levered @ axis.position == pytest.approx(8.0 / 3.0)
    assert np.abs(dense(axis)[1][1] @ axis.one).max() == 0.0
