"""Tetrahedra on graded grids: volumes, conformity, planes and sides."""

import numpy as np
import pytest

from tactgen.geometry.meshing.mesh import tet_volumes
from tactgen.geometry.meshing.structured_tets import box_tetrahedra, graded_planes

X, Y, Z = np.array([0.0, 1.0, 3.0]), np.array([-1.0, 0.0, 0.5, 2.0]), np.array([0.0, 0.1, 4.0])


@pytest.fixture(scope="module")
def mesh():
    region = np.arange(12).reshape(2, 3, 2)
    return box_tetrahedra(X, Y, Z, region, tuple(f"box{i}" for i in range(12)))


def test_every_box_keeps_its_volume_and_all_cells_are_positive(mesh):
    """Six positive tetrahedra of equal volume fill each box."""
    volumes = tet_volumes(mesh.points[mesh.cells])
    boxes = np.einsum("i,j,k->ijk", np.diff(X), np.diff(Y), np.diff(Z)).ravel()
    for number, box in enumerate(boxes):
        np.testing.assert_allclose(volumes[mesh.cells_of(f"box{number}")], box / 6.0, rtol=1e-12)


@pytest.mark.parametrize(("side", "axis", "at"), [("x_low", 0, 0.0), ("y_high", 1, 2.0)])
def test_sides_lie_on_their_planes(mesh, side, axis, at):
    """A side's triangles are on its plane and cover it."""
    corners = mesh.points[mesh.faces[side]]
    np.testing.assert_array_equal(corners[..., axis], at)
    a, b = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    area = 0.5 * np.linalg.norm(np.cross(a, b), axis=1).sum()
    extent = np.delete([np.ptp(v) for v in (X, Y, Z)], axis)
    assert area == pytest.approx(np.prod(extent))


def test_graded_planes_pass_through_all_stops_and_grow_gently():
    """Stops are kept to the last digit; sizes at them and growth are about what was asked."""
    stops = [(0.0, 1.0), (10.0, 0.25), (10.7, 0.25), (60.0, 20.0)]
    planes = graded_planes(stops, growth=1.0)
    assert all(at in planes for at, _ in stops)
    steps = np.diff(planes)
    assert np.all(steps > 0.0)
    outer = steps[planes[:-1] >= 10.7]
    # e for growth 1, and up to 4.5 intervals may have been rounded to 4
    assert np.max(outer[1:] / outer[:-1]) < np.exp(4.5 / 4.0)
    assert steps[np.searchsorted(planes, 10.0)] <= 0.35
