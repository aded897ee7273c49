"""Quarters of symmetric bodies and the whole that they stand for."""

from dataclasses import replace

import numpy as np
import pytest

from tactgen.geometry.meshing.mesh import (
    TET_EDGES,
    Mesh,
    jacobian_coefficients,
    tet_volumes,
    unique_edges,
)
from tactgen.geometry.meshing.structured_tets import (
    MIRRORS,
    box_tetrahedra,
    mirror_axes,
    whole_mesh,
)
from tactgen.geometry.meshing.tetwild.conform import TET_FACES


def quarter():
    """A quarter of a box of two layers: 0 ≤ x, y ≤ 1 mm, 3 mm long."""
    planes = np.linspace(0.0, 1e-3, 3)
    region = np.broadcast_to(np.array([0, 1])[:, None, None], (2, 2, 3))
    box = box_tetrahedra(planes, planes, np.linspace(0.0, 3e-3, 4), region, ("shim", "piezo_top"))
    faces = {
        "mirror_x": box.faces["x_low"],
        "mirror_y": box.faces["y_low"],
        "electrode_top_outer": box.faces["x_high"],
        "base": box.faces["z_low"],
    }
    return replace(box, faces=faces)


def with_middles(mesh):
    """The same in ten-node tetrahedra, straight."""
    edges, of_cell = unique_edges(mesh.cells)
    points = np.concatenate([mesh.points, mesh.points[edges].mean(axis=1)])
    cells = np.concatenate([mesh.cells, of_cell + len(mesh.points)], axis=1)
    return Mesh(points, cells, "tetra10", mesh.region_of_cell, mesh.regions, mesh.faces)


def test_a_mesh_without_cuts_is_the_whole():
    """Named faces tell a quarter; anything else comes back as it is."""
    mesh = quarter()
    assert mirror_axes(mesh) == (0, 1)
    cut_once = replace(mesh, faces={"mirror_x": mesh.faces["mirror_x"]})
    assert not mirror_axes(cut_once)
    assert whole_mesh(cut_once) is cut_once


@pytest.mark.parametrize("make", [quarter, lambda: with_middles(quarter())], ids=["4", "10"])
def test_whole_is_conforming_upright_and_named(make):
    """Four times the volume, no cell inside out, faces shared, layers and electrodes on both."""
    part = make()
    whole = whole_mesh(part)
    corners = whole.cells[:, :4]
    assert tet_volumes(whole.points[corners]).min() > 0.0
    assert tet_volumes(whole.points[corners]).sum() == pytest.approx(12e-9, rel=1e-12)
    _, count = np.unique(
        np.sort(corners[:, TET_FACES].reshape(-1, 3), axis=1), axis=0, return_counts=True
    )
    assert set(count) == {1, 2}
    ends, sides = 2 * 4 * 4, 4 * 4 * 3
    assert np.count_nonzero(count == 1) == 2 * (ends + sides)
    assert whole.regions == ("shim", "piezo_top", "piezo_bottom")
    centres = whole.points[corners].mean(axis=1)
    for name, side in (("piezo_top", 1.0), ("piezo_bottom", -1.0)):
        assert (side * centres[whole.cells_of(name), 0] > 0.5e-3).all()
    assert set(whole.faces) == {"electrode_top_outer", "electrode_bottom_outer", "base"}
    assert not set(whole.faces) & set(MIRRORS)
    for name, side in (("electrode_top_outer", 1.0), ("electrode_bottom_outer", -1.0)):
        a, b, c = np.moveaxis(whole.points[whole.faces[name]], 1, 0)
        normal = np.cross(b - a, c - a)
        assert (side * normal[:, 0] > 0.0).all()
        assert np.linalg.norm(normal, axis=1).sum() / 2.0 == pytest.approx(6e-6, rel=1e-12)
    if whole.kind == "tetra10":
        ends = whole.points[corners][:, TET_EDGES].mean(axis=2)
        assert whole.points[whole.cells[:, 4:]] == pytest.approx(ends, abs=1e-15)
        assert jacobian_coefficients(whole.points[whole.cells]).min() > 0.0
