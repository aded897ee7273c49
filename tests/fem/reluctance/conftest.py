"""A Hall probe for the tests: the solid's field at chosen points."""

import numpy as np
import pytest


@pytest.fixture(scope="session")
def flux_density_at():
    """Return the function that reads B (n, 3) in T of a field at points (n, 3) in m.

    On a straight cell curl A is linear, and so is grad φ; the values at the quadrature points
    determine it.  On curved cells, and where T0 bends within a cell, the linear fit in
    reference coordinates is an approximation of the same order as the field itself.
    """

    def linear(points):
        return np.concatenate([np.ones((1, points.shape[1])), points]).T

    def probe(field, points):
        solid = field.solid
        cells = solid.domain.element_finder(mapping=solid.mapping)(*points.T)
        local = solid.mapping.invF(points.T[:, :, None], tind=cells)[:, :, 0]
        fit = np.linalg.pinv(linear(solid.reference_points))
        coefficients = np.einsum("kq,cqa->cka", fit, field.flux_density[cells])
        return np.einsum("ck,cka->ca", linear(local), coefficients)

    return probe
