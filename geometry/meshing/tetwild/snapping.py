"""Moves vertices onto the exact surfaces they belong to, and bends edges to follow them.

Knows planes and cylinders by distance and gradient only.  Which vertex belongs to
which surface is decided elsewhere, by the triangles that meet in it.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from tactgen.geometry.arrays import Floats, Ints
from tactgen.geometry.cad.tessellation import Cylinder, Surface
from tactgen.geometry.errors import MeshError
from tactgen.geometry.meshing.quadratic import jacobian_coefficients, tet_volumes

#: Newton steps at most: planes need one, a cylinder with planes across it two or three.
_STEPS = 8

#: Distance (mm) below which a point is on its surfaces: rounding.
_ON = 1e-10

#: A bent element's Jacobian stays above this share of the straight one's.
_ROOM = 0.1


def snapped(
    points: Floats, members: Ints, surface_of: Ints, surfaces: Sequence[Surface], reach: float
) -> Floats:
    """Return the points moved onto all the surfaces that each belongs to.

    Parameters
    ----------
    points : (n_points, 3) array
        Coordinates (mm).
    members, surface_of : (n_memberships,) int arrays
        Point ``members[k]`` belongs to ``surfaces[surface_of[k]]``.
    surfaces : sequence of Surface
        The surfaces.
    reach : float
        Longest way a point may be moved (mm).

    Raises
    ------
    MeshError
        If a point cannot be on all its surfaces or would have to move too far.
    """
    belongs = np.zeros((len(points), len(surfaces)), dtype=bool)
    belongs[members, surface_of] = True
    moved = points.copy()
    combinations, which = np.unique(belongs, axis=0, return_inverse=True)
    which = which.ravel()
    for i, combination in enumerate(combinations):
        if combination.any():
            rows = np.flatnonzero(which == i)
            chosen = [surfaces[int(k)] for k in np.flatnonzero(combination)]
            moved[rows] = _onto(points[rows], chosen)
    way = np.linalg.norm(moved - points, axis=1)
    if (way > reach).any():
        raise MeshError(
            f"a vertex would have to move {way.max() * 1e3:.3g} um to reach the faces it "
            "lies on; choose a smaller edge length"
        )
    return moved


def _onto(points: Floats, surfaces: list[Surface]) -> Floats:
    """Return points (n, 3) moved the shortest way onto all surfaces (Newton)."""
    points = points.copy()
    for _ in range(_STEPS):
        distance = np.stack([s.distance(points) for s in surfaces], axis=1)
        if np.abs(distance).max() < _ON:
            return points
        gradient = np.stack([s.gradient(points) for s in surfaces], axis=1)
        points -= (np.linalg.pinv(gradient, rcond=1e-6) @ distance[..., None])[..., 0]
    raise MeshError("a vertex belongs to faces that do not meet; choose a smaller edge length")


def memberships(triangles: Ints, face: Ints, surface_of_face: Ints) -> tuple[Ints, Ints]:
    """Return which vertices belong to which surfaces, given triangles on CAD faces.

    Parameters
    ----------
    triangles : (n_triangles, k) int array
        Points of each triangle (corners or edge numbers).
    face : (n_triangles,) int array
        CAD face of each triangle.
    surface_of_face : (n_faces,) int array
        Surface of each CAD face.
    """
    members = triangles.ravel()
    return members, np.repeat(surface_of_face[face], triangles.shape[1])


def is_curved(surfaces: Sequence[Surface]) -> bool:
    """Say whether any surface is curved."""
    return any(isinstance(surface, Cylinder) for surface in surfaces)


def bent_middles(
    points: Floats,
    cells: Ints,
    middles: Floats,
    on_surface: tuple[Ints, Ints],
    surfaces: Sequence[Surface],
) -> Floats:
    """Return mid-edge nodes moved onto the surfaces, except where an element would fold.

    Parameters
    ----------
    points : (n_points, 3) array
        Vertices (mm).
    cells : (n_cells, 10) int array
        Nodes: vertices first, then mid-edge nodes numbered from ``n_points``.
    middles : (n_edges, 3) array
        Midpoints of the straight edges (mm).
    on_surface : two (n_memberships,) int arrays
        Edges and the surfaces they lie on, as :func:`memberships` gives them.
    surfaces : sequence of Surface
        The surfaces.
    """
    bent = snapped(middles, *on_surface, surfaces, reach=np.inf)
    moved = (bent != middles).any(axis=1)
    edges_of_cell = cells[:, 4:] - len(points)
    concerned = np.flatnonzero(moved[edges_of_cell].any(axis=1))
    for _ in range(_STEPS):
        nodes = np.concatenate([points, bent])[cells[concerned]]
        coefficients = jacobian_coefficients(nodes)
        folded = coefficients.min(axis=1) < _ROOM * 6.0 * tet_volumes(nodes[:, :4])
        straight = edges_of_cell[concerned[folded]].ravel()
        if (bent[straight] == middles[straight]).all():
            break
        bent[straight] = middles[straight]
    return bent
