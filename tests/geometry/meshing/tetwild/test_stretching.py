"""Squeezing along z: how long elements become, and that it is undone exactly."""

import numpy as np
import pytest

from tactgen.geometry.meshing.tetwild.mesher import Stretching


def test_elements_grow_away_from_the_stops_up_to_the_most():
    """What the mesher makes one wide is put back 1 + growth times the distance, at most 3."""
    law = Stretching(low=0.0, high=20.0, most=3.0, growth=0.5)
    for z, longer in ((1.0, 1.5), (2.0, 2.0), (10.0, 3.0), (18.0, 2.0), (19.5, 1.25)):
        # central differences over two steps of the table
        pair = np.array([[0.0, 0.0, z - 0.05], [0.0, 0.0, z + 0.05]])
        squeezed = np.ptp(law.squeezed(pair)[:, 2])
        # the table's steps of 0.05 see the growth at their middles
        assert 0.1 / squeezed == pytest.approx(longer, rel=0.02)


def test_it_is_undone_and_leaves_all_else():
    """Beyond the stops lengths stay as they are, and so do x and y."""
    law = Stretching(low=1.0, high=9.0, most=4.0, growth=1.0)
    points = np.random.default_rng(1).uniform(-3.0, 14.0, (200, 3))
    seen = law.squeezed(points)
    np.testing.assert_allclose(law.restored(seen), points, atol=1e-12)
    np.testing.assert_array_equal(seen[:, :2], points[:, :2])
    below = points[:, 2] < 1.0
    np.testing.assert_allclose(seen[below, 2], points[below, 2], atol=1e-12)
