"""What is seen of a mesh: a closed surface, its cells' edges, both sides where layers touch."""

import numpy as np
import pytest

from tactgen.geometry.meshing.mesh import Mesh, surface_of

POINTS = np.array([[x, y, z] for x in (0, 1.0, 2) for y in (0, 1.0) for z in (0, 1.0)])
BOX = np.array([[0, 4, 6, 2, 1, 5, 7, 3], [4, 8, 10, 6, 5, 9, 11, 7]])


def box(cells, regions, points=POINTS):
    return Mesh(points, cells, "hexahedron", np.array(regions), ("a", "b"), {})


def enclosed(mesh, triangles):
    """Volume by Gauss's theorem: positive if the triangles are seen from outside."""
    a, b, c = mesh.points[triangles].transpose(1, 0, 2)
    return np.einsum("ni,ni->", a, np.cross(b, c)) / 6.0


def test_two_bricks_share_a_face_that_is_not_seen():
    mesh = box(BOX, [0, 1])
    surface = surface_of(mesh)
    assert len(surface.triangles) == 2 * 10
    assert enclosed(mesh, surface.triangles) == pytest.approx(2.0)
    assert len(surface.edges) == 20


def test_layers_with_points_of_their_own_show_both_sides():
    mesh = box(np.array([BOX[0], BOX[1] - 4 + 12]), [0, 1], np.vstack([POINTS, POINTS[4:]]))
    surface = surface_of(mesh)
    assert len(surface.triangles) == 2 * 12
    for number in (0, 1):
        part = surface.triangles[surface.region_of_triangle == number]
        assert enclosed(mesh, part) == pytest.approx(1.0)


def test_a_curved_tetrahedron_shows_its_mid_edge_nodes():
    corners = np.vstack([np.zeros(3), np.eye(3)])
    pairs = [(0, 1), (1, 2), (2, 0), (0, 3), (1, 3), (2, 3)]
    points = np.vstack([corners, [0.5 * (corners[i] + corners[j]) for i, j in pairs]])
    mesh = Mesh(points, np.arange(10)[None], "tetra10", np.array([0]), ("a",), {})
    surface = surface_of(mesh)
    assert len(surface.triangles) == 16
    assert len(surface.edges) == 12
    assert enclosed(mesh, surface.triangles) == pytest.approx(1.0 / 6.0)


def test_two_straight_tetrahedra_show_all_edges_but_not_the_face_between_them():
    """Six triangles and nine edges, seen from outside, each of its own tetrahedron."""
    points = np.vstack([np.zeros(3), np.eye(3), np.ones(3)])
    cells = np.array([[0, 1, 2, 3], [1, 2, 3, 4]])
    mesh = Mesh(points, cells, "tetra", np.array([0, 1]), ("a", "b"), {})
    surface = surface_of(mesh)
    assert list(np.bincount(surface.region_of_triangle)) == [3, 3]
    assert len(surface.edges) == 9
    assert [0, 4] not in surface.edges.tolist()
    assert enclosed(mesh, surface.triangles) == pytest.approx(1.0 / 6.0 + 1.0 / 3.0)
