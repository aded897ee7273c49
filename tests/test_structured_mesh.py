"""The structured mesh is the device: volumes, faces and names."""

import numpy as np
import pytest

from geometry.parameters import Bimorph, Device
from geometry.structured import LEVELS, hexahedral


def box_volumes(mesh):
    corners = mesh.points[mesh.cells]
    return np.prod(np.ptp(corners, axis=1), axis=1)


@pytest.mark.parametrize("tab", [0.0, 1.6e-3])
@pytest.mark.parametrize("level", [0, 2])
def test_region_volumes_are_exact(tab, level):
    """Each layer has the volume of the box it stands for; the tab belongs to the shim."""
    b = Bimorph(tab_length=tab)
    mesh = hexahedral(Device(bimorph=b), LEVELS[level])
    volumes = box_volumes(mesh)
    ceramic = b.length * b.width * b.piezo_thickness
    shim = (b.length + tab) * b.width * b.shim_thickness
    expected = {"piezo_top": ceramic, "piezo_bottom": ceramic, "shim": shim}
    for region, volume in expected.items():
        assert volumes[mesh.cells_of(region)].sum() == pytest.approx(volume, rel=1e-12)


@pytest.mark.parametrize("tab", [0.0, 1.6e-3])
def test_named_faces_have_the_right_areas(tab):
    """Electrodes cover the ceramic only; the base is the whole section or the tab's end."""
    b = Bimorph(tab_length=tab)
    mesh = hexahedral(Device(bimorph=b), LEVELS[1])
    areas = {}
    for name, quads in mesh.faces.items():
        extent = np.sort(np.ptp(mesh.points[quads], axis=1), axis=1)
        areas[name] = (extent[:, 1] * extent[:, 2]).sum()
    electrode = b.length * b.width
    for name in ("top_outer", "top_inner", "bottom_inner", "bottom_outer"):
        assert areas[f"electrode_{name}"] == pytest.approx(electrode, rel=1e-12)
    assert areas["tip"] == pytest.approx(b.width * b.thickness, rel=1e-12)
    base = b.shim_thickness if tab else b.thickness
    assert areas["base"] == pytest.approx(b.width * base, rel=1e-12)


def test_elements_are_positively_oriented():
    """VTK order: the Jacobian of every box is positive."""
    mesh = hexahedral(Device(), LEVELS[0])
    p = mesh.points[mesh.cells]
    edges = np.stack([p[:, i] - p[:, 0] for i in (1, 3, 4)], axis=1)
    assert (np.linalg.det(edges) > 0.0).all()


def test_family_gets_finer():
    """Every level of the family has more elements than the one before."""
    counts = [hexahedral(Device(), level).cells.shape[0] for level in LEVELS]
    assert counts == sorted(set(counts))
