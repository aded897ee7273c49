"""Swept curved tetrahedra: volumes, orientation, conformity."""

import numpy as np
import pytest

from tactgen.geometry.meshing.mesh import check_conformity, jacobian_coefficients
from tactgen.geometry.meshing.structured_tets import swept_tetrahedra

R = np.array([0.0, 0.3, 0.5, 0.51, 1.0])
Z = np.array([-1.0, 0.0, 0.02, 1.5])
REGION = np.arange(12).reshape(4, 3) % 3
NAMES = ("one", "two", "three")


def swept(turn, layers):
    return swept_tetrahedra(R, Z, np.linspace(0.0, turn, layers + 1), REGION, NAMES)


def volumes(mesh):
    return jacobian_coefficients(mesh.points[mesh.cells]).mean(axis=1) / 6.0


@pytest.mark.parametrize("layer", [np.pi / 4, np.pi / 8, np.pi / 16])
def test_regions_have_their_volume(layer):
    """Each region's volume is that of its rings, with an error of fourth order in the angle.

    Estimate 9e-5 of the volume at 22.5 degrees, 16 times less at half of that.
    """
    turn = np.pi / 2
    mesh = swept(turn, round(turn / layer))
    rings = np.diff(R**2)[:, None] * np.diff(Z) * turn / 2.0
    for number, name in enumerate(NAMES):
        exact = rings[number == REGION].sum()
        found = volumes(mesh)[mesh.cells_of(name)].sum()
        assert found == pytest.approx(exact, rel=1e-4 * (layer / (np.pi / 8)) ** 4)


def test_cells_are_positive_and_conforming():
    """Jacobians are positive everywhere; a face is shared by two cells or is on a named side."""
    mesh = swept(np.pi / 2, 4)
    assert jacobian_coefficients(mesh.points[mesh.cells]).min() > 0.0
    check_conformity(mesh.cells[:, :4], sum(len(faces) for faces in mesh.faces.values()))
