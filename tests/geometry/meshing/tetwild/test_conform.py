"""What the mesher leaves made to follow CAD: raw meshes drawn by hand, off by a known distance."""

import numpy as np
import pytest

from tactgen.geometry.cad.tessellation import Cylinder, Plane, tessellate
from tactgen.geometry.errors import MeshError
from tactgen.geometry.meshing.mesh import (
    TET_FACES,
    jacobian_coefficients,
    tet_volumes,
    unique_edges,
)
from tactgen.geometry.meshing.structured_tets import box_tetrahedra
from tactgen.geometry.meshing.tetwild.conform import NamedFace, bent_middles, conform, relaxed

#: How far raw points are from where they belong, and may be (mm).
OFF, SLACK = 0.01, 0.02


def outer(tets):
    """Return the triangles that belong to one tetrahedron alone, seen from outside."""
    triangles = tets[:, TET_FACES].reshape(-1, 3)
    _, first, count = np.unique(
        np.sort(triangles, axis=1), axis=0, return_index=True, return_counts=True
    )
    return triangles[first[count == 1]]


def upright(points, tets):
    """Return tetrahedra of which none is inside out."""
    turned = tet_volumes(points[tets]) < 0.0
    return np.where(turned[:, None], tets[:, [1, 0, 2, 3]], tets)


def in_air(points, inside):
    """Return a raw mesh: a tetrahedron of air with a point of its own on each open triangle."""
    shown = outer(inside)
    a, b, c = np.moveaxis(points[shown], 1, 0)
    normal = np.cross(b - a, c - a)
    apexes = (a + b + c) / 3.0 + normal / np.linalg.norm(normal, axis=1)[:, None]
    air = np.column_stack([shown, len(points) + np.arange(len(shown))])
    return np.concatenate([points, apexes]), np.concatenate([inside, air])


def shaken(points, by=OFF):
    """Return points moved by up to `by` along each axis."""
    return points + np.random.default_rng(3).uniform(-by, by, points.shape)


def grid(*axes):
    """Return the points of a grid and its tetrahedra, six a cell."""
    cells = np.zeros([len(axis) - 1 for axis in axes], dtype=int)
    mesh = box_tetrahedra(*map(np.array, axes), cells, ("",))
    return mesh.points, mesh.cells


def disc(corners=16, radius=1.0, height=1.0):
    """Return points and tetrahedra of a prism with so many corners about the z axis."""
    angles = 2.0 * np.pi * np.arange(corners) / corners
    ring = radius * np.column_stack([np.cos(angles), np.sin(angles)])
    plan = np.concatenate([[[0.0, 0.0]], ring])
    points = np.concatenate([np.column_stack([plan, np.full(len(plan), z)]) for z in (0, height)])
    wedges = [(0, 1 + k, 1 + (k + 1) % corners) for k in range(corners)]
    tets = []
    for wedge in wedges:
        # cut by the order of the corners' numbers: neighbours share the diagonal
        low = sorted(wedge)
        high = [corner + len(plan) for corner in low]
        tets += [(*low[: i + 1], *high[i:]) for i in range(3)]
    return points, upright(points, np.array(tets))


@pytest.fixture(scope="module")
def pair():
    """Return two boxes one on the other, and their surface."""
    import cadquery as cq

    from tactgen.geometry.cad.solids import fuse

    solids = fuse(
        {
            "below": cq.Solid.makeBox(1.0, 1.0, 1.0),
            "above": cq.Solid.makeBox(1.0, 1.0, 2.0, cq.Vector(0.0, 0.0, 1.0)),
        }
    )
    return solids, tessellate(solids, 0.1, 0.5)


@pytest.fixture(scope="module")
def cylinder():
    """Return a cylinder, and its surface."""
    import cadquery as cq

    solids = {"disc": cq.Solid.makeCylinder(1.0, 1.0)}
    return solids, tessellate(solids, 0.01, 0.2)


def box_points():
    return grid([0.0, 1.0], [0.0, 1.0], [0.0, 1.0, 3.0])


def test_points_off_their_planes_are_put_back(pair):
    """Each region has its volume, and a named face is where it is named, to rounding."""
    points, tets = box_points()
    raw, cells = in_air(shaken(points), tets)
    named = {
        "between": NamedFace((Plane((0.0, 0.0, 1.0), 1.0),), ("below",)),
        "end": NamedFace((Plane((0.0, 0.0, 1.0), 3.0),), ("above",)),
        "side": NamedFace((Plane((1.0, 0.0, 0.0), 1.0),), ("above",)),
    }
    mesh = conform(raw, cells, *pair, SLACK, named, curved=True)
    assert (mesh.kind, mesh.regions) == ("tetra", ("below", "above"))
    np.testing.assert_allclose(1e3 * mesh.points, points, rtol=1e-14, atol=1e-14)
    volumes = np.bincount(mesh.region_of_cell, tet_volumes(mesh.points[mesh.cells]))
    np.testing.assert_allclose(volumes, [1e-9, 2e-9], rtol=1e-12)
    for name, z in (("between", 1e-3), ("end", 3e-3)):
        assert mesh.faces[name].shape == (2, 3)
        np.testing.assert_allclose(mesh.points[mesh.faces[name], 2], z, rtol=1e-12)
    side = mesh.points[mesh.faces["side"]]  # of the upper box alone, though both end there
    assert (side[..., 0].min(), side[..., 2].min(), len(side)) == (1e-3, 1e-3, 2)


def test_a_mesh_that_stays_off_by_more_than_twice_the_slack_is_refused(pair):
    """The raw mesh is no mesh of these solids there; up to that it is put back."""
    points, tets = box_points()
    top = points[:, 2] == 3.0
    points[top, 2] += 1.99 * SLACK
    mesh = conform(*in_air(points, tets), *pair, SLACK, {}, curved=True)
    assert mesh.points[:, 2].max() == pytest.approx(3e-3, rel=1e-12)
    points[top, 2] += 0.02 * SLACK
    with pytest.raises(MeshError, match="2 triangles between outside and above lie on no face"):
        conform(*in_air(points, tets), *pair, SLACK, {}, curved=True)


def test_a_tetrahedron_that_putting_back_flattens_is_left_out(pair):
    """On the outside two triangles stand for it; the surface has another diagonal there."""
    points, tets = box_points()
    points[:, 2] += np.where(points[:, 2] == 3.0, -OFF, 0.0)
    top = np.flatnonzero(points[:, 2] == 3.0 - OFF)
    raw, cells = in_air(points, tets)
    plain = conform(raw, cells, *pair, SLACK, {}, curved=True)
    low, high = ([top[0], top[3]], [top[1], top[2]])  # the grid's diagonal, and the other
    points[high, 2] += 1.5 * OFF
    flat = upright(points, np.array([[*low, *high]]))
    raw, cells = in_air(points, np.concatenate([tets, flat]))
    mesh = conform(raw, cells, *pair, SLACK, {}, curved=True)
    for name in ("points", "cells", "region_of_cell"):
        np.testing.assert_allclose(getattr(mesh, name), getattr(plain, name), atol=1e-15)


def test_a_mesh_that_is_torn_is_refused(pair):
    """A face that neither another element nor the air shares is no part of the surface."""
    raw, cells = in_air(*box_points())
    with pytest.raises(MeshError, match="do not share their faces"):
        conform(raw, cells[:-1], *pair, SLACK, {}, curved=True)


def test_a_flat_element_that_nothing_cures_is_refused(pair):
    """Between the two boxes, whose diagonals differ: its corners are theirs, and cannot move."""
    points, tets = box_points()
    below = tets[(tets % 3).max(axis=1) == 1]
    above = tets[(tets % 3).min(axis=1) == 1]
    turned = (above + 6) % 12  # to the other side along x, which turns them inside out
    between = points[:, 2] == 1.0
    first, second = np.flatnonzero(between)[[0, 3]], np.flatnonzero(between)[[1, 2]]
    points[first, 2] -= 0.5 * OFF
    points[second, 2] += 0.5 * OFF
    flat = upright(points, np.array([[*first, *second]]))
    raw, cells = in_air(points, np.concatenate([below, turned[:, [1, 0, 2, 3]], flat]))
    with pytest.raises(MeshError, match="1 elements have angles below 3 degrees"):
        conform(raw, cells, *pair, SLACK, {}, curved=True)


def sector(h):
    """Return the area of a sector of angle `h` whose arc is the parabola through its middle."""
    return 0.5 * np.sin(h) + 4.0 / 3.0 * np.sin(h / 2.0) * (1.0 - np.cos(h / 2.0))


@pytest.mark.parametrize(("curved", "area"), [(True, sector), (False, lambda h: 0.5 * np.sin(h))])
def test_edges_on_a_cylinder_are_parabolas_or_chords(cylinder, curved, area):
    """Sixteen corners, off by what the mesher may: the volume is that of the exact corners."""
    points, tets = disc(16)
    raw, cells = in_air(points * [1.0 + OFF, 1.0 + OFF, 1.0], tets)
    mesh = conform(raw, cells, *cylinder, SLACK, {}, curved=curved)
    assert mesh.kind == ("tetra10" if curved else "tetra")
    nodes = 1e3 * mesh.points[mesh.cells]
    volumes = jacobian_coefficients(nodes).mean(axis=1) / 6.0 if curved else tet_volumes(nodes)
    assert volumes.sum() == pytest.approx(16.0 * area(2.0 * np.pi / 16.0), rel=1e-12)


@pytest.mark.parametrize(("away", "bent"), [(0.35, True), (0.05, False)])
def test_an_edge_stays_straight_where_its_element_would_fold(away, bent):
    """Around a bore the arc bows into the element: by 0.134 of the radius over a sixth of it.

    A second element beside the first, which shares only a vertex with it, is bent as it would be
    alone; edges on no surface stay where they are.
    """
    c, s = np.cos(np.pi / 6.0), np.sin(np.pi / 6.0)
    tet = np.array([[c, s, 0.0], [c, -s, 0.0], [c + away, 0.0, 0.5], [c + away, 0.0, -0.5]])
    roomy = np.array([[-0.5, c * 3.0, 0.5], [-s, c, 0.0]])
    points = np.concatenate([tet, [[0.0, 1.0, 0.0], *roomy, [0.5, 3.0, -0.5]]])
    tets = upright(points, np.array([[0, 1, 2, 3], [4, 6, 5, 7]]))
    edges, edges_of_cell = unique_edges(tets)
    middles = points[edges].mean(axis=1)
    cells = np.concatenate([tets, edges_of_cell + len(points)], axis=1)
    on = np.flatnonzero([edge.tolist() in ([0, 1], [4, 6]) for edge in edges])
    found = bent_middles(points, cells, middles, (on, np.zeros(2, int)), [Cylinder(1.0)])
    radius = np.hypot(*found[on, :2].T)
    np.testing.assert_allclose(radius, [1.0 if bent else c, 1.0], rtol=1e-12)
    others = np.setdiff1d(np.arange(len(edges)), on)
    np.testing.assert_array_equal(found[others], middles[others])


#: A cube about a vertex, from which twelve tetrahedra go to its faces.
CUBE, BOX = grid([-1.0, 1.0], [-1.0, 1.0], [-1.0, 1.0])
STAR = np.column_stack([outer(BOX)[:, [0, 2, 1]], np.full(12, 8)])


@pytest.mark.parametrize("start", [(0.99, 0.0, 0.0), (0.2, -0.995, 0.1), (1.4, 0.0, 0.3)])
def test_a_vertex_without_room_goes_to_the_middle_of_its_neighbours(start):
    """Also one that has left the cube, and turned tetrahedra inside out."""
    points = np.concatenate([CUBE, [start]])
    free = np.zeros((9, 3), dtype=bool)
    np.testing.assert_array_equal(relaxed(points, STAR, free), points)
    free[8] = True
    moved = relaxed(points, STAR, free)
    np.testing.assert_allclose(moved[8], 0.0, atol=1e-15)
    np.testing.assert_array_equal(moved[:8], CUBE)
    free[8, 0] = False
    assert relaxed(points, STAR, free)[8, 0] == start[0]
