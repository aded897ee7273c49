"""The field along a dimension: one grid that moves, no noise of meshes, starts from neighbours."""

from functools import cache

import numpy as np
import pytest

from tactgen.fem.magnetics.axisymmetric import FieldPath, solve_point
from tactgen.geometry.device.parameters import Device

PLACES = np.linspace(-1.0, 1.0, 7)
THICKNESSES = 0.5e-3 + 0.1e-3 * PLACES


def device(thickness):
    return Device.model_validate({"rod": {"head_thickness": thickness}})


@cache
def along():
    path = FieldPath(Device(), 0.2e-3, order=3, refinement=0.5)
    middle_first = sorted(range(7), key=lambda n: abs(n - 3))
    found = {
        n: path.solved(device(THICKNESSES[n]), 0.13, 0.2e-3, PLACES[n : n + 1])
        for n in middle_first
    }
    return [found[n] for n in range(7)]


@cache
def apart():
    return [solve_point(device(t), 0.13, 0.2e-3, order=3, refinement=0.5) for t in THICKNESSES]


@pytest.mark.parametrize("name", ["force", "flux_linkage", "coenergy"])
def test_no_noise_of_the_mesh(name):
    """What is left of a smooth curve is a thousandth of the bar, and far less than with own grids.

    There the number of lines jumps with the thickness.
    """

    def noise(points):
        values = [getattr(point, name) for point in points]
        smooth = np.polynomial.Chebyshev.fit(PLACES, values, 4)
        return np.abs(smooth(PLACES) - values).max()

    bar = min(getattr(point.errors, name) for point in along())
    assert noise(along()) <= 1e-3 * bar
    assert noise(along()) <= 0.1 * noise(apart())


def test_neighbours_make_good_starts():
    """All but the first few take fewer Newton steps than from nothing."""
    moved, fresh = (sum(point.iterations for point in points) for points in (along(), apart()))
    assert moved <= 0.75 * fresh


def test_out_of_reach_is_told():
    """The flange cannot grow past the coil's outer edge on the same lines."""
    path = FieldPath(Device(), 0.2e-3, order=2, refinement=0.5)
    assert path.solved(Device(), 0.0, 0.15e-3, np.zeros(1)) is not None
    thin = Device.model_validate({"rod": {"flange_radius": 0.85e-3}})
    assert path.solved(thin, 0.0, 0.2e-3, np.zeros(1)) is None
