"""Edge lengths asked of the mesher: those given along the device, longer away from it."""

import numpy as np

from tactgen.geometry.meshing.mesh import tet_volumes
from tactgen.geometry.meshing.tetwild import mesher as run


def test_lengths_along_z_hold_beside_the_device_and_grow_outside():
    """Inside its box as asked, beyond by the way to it; the field's cells fill the larger box."""
    points = np.array([[0.0, 0.0, 0.0], [1.0, 2.0, 5.0]])
    field = run.sizing_along_z(points, lambda z: 0.1 + 0.01 * np.abs(z))
    away = np.maximum(np.maximum(-field.points, field.points - points[1]), 0.0).max(axis=1)
    asked = 0.1 + 0.01 * np.abs(field.points[:, 2])
    np.testing.assert_allclose(field.lengths, asked + run._GROWTH_OUTSIDE * away, rtol=1e-14)
    margin = run._MARGIN * np.sqrt(30.0)
    box = points + np.array([[-margin], [margin]])
    np.testing.assert_allclose([field.points.min(axis=0), field.points.max(axis=0)], box)
    for axis in (0, 1):  # its own sides are grid planes
        assert set(points[:, axis]) < set(field.points[:, axis])
    volumes = np.abs(tet_volumes(field.points[field.tets]))
    assert np.isclose(volumes.sum(), np.prod(box[1] - box[0]), rtol=1e-12)
