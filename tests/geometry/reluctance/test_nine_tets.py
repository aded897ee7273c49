"""An eighth of nine actuators: it conforms, ends where it should, and each part has its volume."""

import numpy as np
import pytest

from tactgen.geometry.device.parameters import Bimorph, Device
from tactgen.geometry.device.parts import closed_form_volumes
from tactgen.geometry.meshing.mesh import TET_FACES, jacobian_coefficients
from tactgen.geometry.reluctance.section_grid import actuator_regions, air_radius
from tactgen.geometry.reluctance.sector_tets import COPIES, COUNTS, UNITS, Cell, nine_mesh, part_of

DEVICE, GAP, PITCH = Device(), 0.2e-3, 2.4e-3
OUTER_RADIUS = air_radius(actuator_regions(DEVICE, GAP))


@pytest.fixture(scope="module")
def mesh():
    return nine_mesh(DEVICE, GAP, PITCH, Cell(refinement=0.5, layers=3))


def test_neighbours_share_their_faces(mesh):
    """A face has two cells, or it is in a mirror plane or at the end of the air."""
    faces = np.sort(mesh.cells[:, TET_FACES].reshape(-1, 3), axis=1)
    faces, count = np.unique(faces, axis=0, return_counts=True)
    assert count.max() == 2
    x, y, z = np.moveaxis(mesh.points[faces[count == 1]], -1, 0)
    ends = (y, x - y, x - OUTER_RADIUS, z - z.min(), z - z.max())
    outside = np.any([np.all(np.abs(end) < 1e-12, axis=1) for end in ends], axis=0)
    assert outside.all()


def test_no_cell_folds_and_all_has_its_volume(mesh):
    """Sleeves and windings by unit, and the whole, a box."""
    jacobians = jacobian_coefficients(mesh.points[mesh.cells])
    assert jacobians.min() > 0.0
    volumes = COPIES * jacobians.mean(axis=1) / 6.0
    box = (2.0 * OUTER_RADIUS) ** 2 * float(np.ptp(mesh.points[:, 2]))
    assert volumes.sum() == pytest.approx(box, rel=1e-9)
    expected = closed_form_volumes(Device(bimorph=Bimorph(tab_length=2e-3)))
    for unit in UNITS:
        for part in ("sleeve", "coil"):
            found = volumes[mesh.cells_of(part_of(unit, part))].sum()
            # arcs of up to 21 degrees by parabolas: some 1e-4 of the area
            assert found == pytest.approx(COUNTS[unit] * expected[part], rel=5e-4), unit
