"""Structured tetrahedra: boxes, swept sections, and quarters mirrored to the whole."""

from dataclasses import replace

import numpy as np
import pytest

from tactgen.geometry.meshing.mesh import (
    TET_EDGES,
    Mesh,
    check_conformity,
    jacobian_coefficients,
    tet_volumes,
    unique_edges,
)
from tactgen.geometry.meshing.structured_tets import (
    MIRRORS,
    box_tetrahedra,
    graded_planes,
    mirror_axes,
    swept_tetrahedra,
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


X, Y, HEIGHTS = (
    np.array([0.0, 1.0, 3.0]),
    np.array([-1.0, 0.0, 0.5, 2.0]),
    np.array([0.0, 0.1, 4.0]),
)


@pytest.fixture(scope="module")
def boxes():
    region = np.arange(12).reshape(2, 3, 2)
    return box_tetrahedra(X, Y, HEIGHTS, region, tuple(f"box{i}" for i in range(12)))


def test_every_box_keeps_its_volume_and_all_cells_are_positive(boxes):
    """Six positive tetrahedra of equal volume fill each box."""
    volumes = tet_volumes(boxes.points[boxes.cells])
    sizes = np.einsum("i,j,k->ijk", np.diff(X), np.diff(Y), np.diff(HEIGHTS)).ravel()
    for number, size in enumerate(sizes):
        np.testing.assert_allclose(volumes[boxes.cells_of(f"box{number}")], size / 6.0, rtol=1e-12)


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
