"""Cures flat tetrahedra by moving their vertices, those on a plane within it.

Putting vertices on their surfaces can leave a tetrahedron without room.  A vertex inside a
region is free to give it some; one on a face, or on an edge between two, can slide along it.
"""

from __future__ import annotations

import numpy as np

from tactgen.geometry.arrays import Bools, Floats, Ints
from tactgen.geometry.meshing.mesh_check import is_poor
from tactgen.geometry.meshing.quadratic import smallest_dihedral_angles, tet_volumes

#: Rounds over all flat tetrahedra at most: one helps its neighbours in the next.
_ROUNDS = 4

#: Shares of the way to the middle of its neighbours that a vertex is tried at.
_WAYS = (0.1, 0.3, 0.6, 1.0)


def relaxed(points: Floats, tets: Ints, free: Bools) -> Floats:
    """Return the points, vertices of flat tetrahedra moved where their worst angle is best.

    Parameters
    ----------
    points : (n_points, 3) array
        Coordinates, in which the shape of tetrahedra is judged.
    tets : (n_tets, 4) int array
        Corners of all tetrahedra that must keep their volume.
    free : (n_points, 3) bool array
        Along which axes each point may be moved.
    """
    points = points.copy()
    for _ in range(_ROUNDS):
        flat = is_poor(points, tets) | (tet_volumes(points[tets]) <= 0.0)
        movable = np.unique(tets[flat])
        movable = movable[free[movable].any(axis=1)]
        if not movable.size:
            return points
        near = tets[np.isin(tets, movable).any(axis=1)]
        for vertex in movable:
            around = near[(near == vertex).any(axis=1)]
            points[vertex] = _best_place(points, around, int(vertex), free[vertex])
    return points


def _best_place(points: Floats, around: Ints, vertex: int, free: Bools) -> Floats:
    """Return where the worst of the tetrahedra around a vertex is best, along free axes."""
    here = points[vertex]
    ring = np.setdiff1d(around, [vertex])
    middle = np.where(free, points[ring].mean(axis=0), here)
    places = [here, *(here + way * (middle - here) for way in _WAYS)]
    merits = []
    for place in places:
        corners = np.where((around == vertex)[:, :, None], place, points[around])
        # an inverted tetrahedron has the angles of its mirror image
        upright = np.sign(tet_volumes(corners))
        merits.append((upright * smallest_dihedral_angles(corners)).min())
    return np.asarray(places[int(np.argmax(merits))])
