"""TEAM problem 20: volumes of the steel, current of the coil."""

import numpy as np
import pytest

from tactgen.geometry.meshing.mesh import tet_volumes
from tactgen.geometry.reluctance.team20 import Team20Meshing, team20_mesh, team20_source

COARSE = team20_mesh(Team20Meshing(scale=4.0))


def test_steel_has_its_volume():
    """Grid planes honour every steel face: a quarter of the exact volume (mm³), to rounding."""
    for region, volume in (
        ("pole", 25.0 * 10.0 * 98.5),
        ("yoke", 25.0 * (127.0 * 150.0 - 77.0 * 100.0 - 27.0 * 25.0)),
    ):
        found = tet_volumes(COARSE.points[COARSE.cells[COARSE.cells_of(region)]]).sum() * 1e9
        assert 4.0 * found == pytest.approx(volume, rel=1e-12), region


def curl(points, step=1e-6):
    slope = np.zeros((3, *points.shape))
    for axis in range(3):
        shift = step * np.eye(3)[axis]
        ahead, behind = team20_source(points + shift), team20_source(points - shift)
        slope[axis] = (ahead - behind) / (2.0 * step)
    return np.stack(
        [
            slope[1][..., 2] - slope[2][..., 1],
            slope[2][..., 0] - slope[0][..., 2],
            slope[0][..., 1] - slope[1][..., 0],
        ],
        axis=-1,
    )


@pytest.mark.parametrize(
    ("at", "along"),
    [((28.0, 3.0), (0.0, 1.0)), ((4.0, 28.0), (-1.0, 0.0)), ((24.5, 22.0), (-0.6, 0.8))],
    ids=["side x", "side y", "round corner"],
)
def test_source_is_the_uniform_current_of_the_winding(at, along):
    """curl T0 = 1 / (18 mm x 96.6 mm) anticlockwise everywhere in the coil, corners included."""
    point = np.array([[*at, 70.0]]) * 1e-3
    expected = np.array([*along, 0.0]) / (18e-3 * 96.6e-3)
    # differences over 2 µm of fields rounded to 1e-15 of 10 A/m
    np.testing.assert_allclose(curl(point)[0], expected, rtol=1e-6, atol=1e-4)


def test_source_has_no_current_outside_the_coil():
    """No curl in the bore, beside the coil and above it."""
    points = np.array([[5.0, 2.0, 60.0], [45.0, 3.0, 60.0], [28.0, 0.0, 130.0]]) * 1e-3
    np.testing.assert_allclose(curl(points), 0.0, atol=1e-9)


def test_source_vanishes_where_the_pole_moves():
    """In pole and shell T0 = 0 exactly, so moving the pole moves no current."""
    for region in ("pole", "shell"):
        corners = COARSE.points[COARSE.cells[COARSE.cells_of(region)]]
        assert not np.any(team20_source(corners.mean(axis=1)))
