"""Which solid each tetrahedron fills, and which CAD face each triangle between two lies on.

Works on the raw output of the mesher, before any vertex is moved.  Nothing here moves
a vertex.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from tactgen.geometry.arrays import Floats, Ints
from tactgen.geometry.cad.tessellation import OUTSIDE, Face, Surface
from tactgen.geometry.errors import MeshError
from tactgen.geometry.meshing.mesh import TET_FACES

if TYPE_CHECKING:
    import cadquery as cq


@dataclass(frozen=True)
class Skin:
    """The triangles on which a region ends, each assigned to a CAD face.

    Attributes
    ----------
    triangles : (n_triangles, 3) int array
        Corners, seen from the side that the triangle's cell does not fill.
    cell : (n_triangles,) int array
        The tetrahedron behind the triangle; between two regions, the one with the
        lower label.
    face : (n_triangles,) int array
        Index of the CAD face.
    open : (n_triangles,) bool array
        Whether the other side is outside.
    """

    triangles: Ints
    cell: Ints
    face: Ints
    open: NDArray[np.bool_]


def region_labels(
    points: Floats,
    tets: Ints,
    solids: dict[str, cq.Solid],
    surfaces: list[Surface],
    tolerance: float,
) -> Ints:
    """Return the index of the solid that each tetrahedron fills, -1 outside.

    The surfaces cut space into pieces each of which lies in one solid or outside.  The
    CAD kernel classifies one point of each piece, every tetrahedron inherits.  A vertex
    on a surface does not count for the side of its tetrahedron, so curved boundaries
    with straight-edged elements are no exception.

    Parameters
    ----------
    points : (n_points, 3) array
        Coordinates (mm).
    tets : (n_tets, 4) int array
        Corners.
    solids : dict of str to cadquery.Solid
        Fused solids (mm).
    surfaces : list of Surface
        All surfaces that bound the solids.
    tolerance : float
        Distance up to which a vertex counts as on a surface (mm).
    """
    centroids = points[tets].mean(axis=1)
    # weighing the tetrahedra in the device's box only: the mesher fills a larger one
    low, high = _bounds(solids)
    near = np.flatnonzero(((centroids > low) & (centroids < high)).all(axis=1))
    above = np.empty((len(near), len(surfaces)), dtype=bool)
    clearance = np.full(len(near), np.inf)
    for i, surface in enumerate(surfaces):
        distance = surface.distance(points)[tets[near]]
        off = np.where(np.abs(distance) < tolerance, 0.0, distance).sum(axis=1)
        above[:, i] = np.where(off == 0.0, distance.sum(axis=1), off) > 0.0
        own = surface.distance(centroids[near])
        # a centroid on the wrong side (under an arc) must not speak for the piece
        clearance = np.minimum(clearance, np.where(above[:, i], own, -own))
    _, piece = np.unique(np.packbits(above, axis=1), axis=0, return_inverse=True)
    piece = piece.ravel()
    order = np.lexsort((-clearance, piece))
    speakers = order[np.unique(piece[order], return_index=True)[1]]
    label_of_piece = _classify(centroids[near[speakers]], solids)
    labels = np.full(len(tets), -1, dtype=np.int64)
    labels[near] = label_of_piece[piece]
    return labels


def _bounds(solids: dict[str, cq.Solid]) -> tuple[Floats, Floats]:
    boxes = [solid.BoundingBox() for solid in solids.values()]
    low = np.min([(b.xmin, b.ymin, b.zmin) for b in boxes], axis=0)
    high = np.max([(b.xmax, b.ymax, b.zmax) for b in boxes], axis=0)
    return low, high


def _classify(points: Floats, solids: dict[str, cq.Solid]) -> Ints:
    """Return the index of the solid that holds each point, -1 for none, by the CAD kernel."""
    from OCP.BRepClass3d import BRepClass3d_SolidClassifier
    from OCP.gp import gp_Pnt
    from OCP.TopAbs import TopAbs_State

    labels = np.full(len(points), -1, dtype=np.int64)
    for index, solid in enumerate(solids.values()):
        low, high = _bounds({"": solid})
        classifier = BRepClass3d_SolidClassifier(solid.wrapped)
        for i in np.flatnonzero(((points > low) & (points < high)).all(axis=1)):
            classifier.Perform(gp_Pnt(*(float(v) for v in points[i])), 1e-9)
            if classifier.State() == TopAbs_State.TopAbs_IN:
                labels[i] = index
    return labels


def skin(
    points: Floats,
    tets: Ints,
    labels: Ints,
    names: tuple[str, ...],
    faces: tuple[Face, ...],
    tolerance: float,
) -> Skin:
    """Find the triangles between regions and assign each to the CAD face it lies on.

    Parameters
    ----------
    points, tets, labels
        As in :func:`region_labels`.
    names : tuple of str
        Region of each label.
    faces : tuple of Face
        All CAD faces of the fused solids.
    tolerance : float
        Largest distance allowed between a triangle's corners and its face (mm).

    Raises
    ------
    MeshError
        If two regions touch that do not touch in CAD, or a triangle lies on no face.
    """
    triangles, cell, pairs = _between_regions(tets, labels)
    face = np.full(len(triangles), -1, dtype=np.int64)
    distance = np.full(len(triangles), np.inf)
    label_of = {name: i for i, name in enumerate(names)} | {OUTSIDE: -1}
    for i, candidate in enumerate(faces):
        sides = sorted(label_of[name] for name in candidate.sides)
        rows = np.flatnonzero((pairs == sides).all(axis=1))
        off = np.abs(candidate.surface.distance(points))[triangles[rows]].max(axis=1)
        closer = rows[off < distance[rows]]
        face[closer] = i
        distance[closer] = off[off < distance[rows]]
    lost = np.flatnonzero(distance > tolerance)
    if lost.size:
        first, second = ((*names, OUTSIDE)[i] for i in pairs[lost[0]])
        raise MeshError(
            f"{lost.size} triangles between {first} and {second} lie on no face of the CAD model; "
            "choose a smaller edge length"
        )
    return Skin(triangles=triangles, cell=cell, face=face, open=pairs[:, 0] < 0)


def _between_regions(tets: Ints, labels: Ints) -> tuple[Ints, Ints, Ints]:
    """Return triangles (n, 3), cell behind (n,) and sorted label pairs (n, 2)."""
    triangles = tets[:, TET_FACES].reshape(-1, 3)
    cell = np.repeat(np.arange(len(tets)), 4)
    key = np.sort(triangles, axis=1)
    order = np.lexsort(key.T)
    same = (key[order[1:]] == key[order[:-1]]).all(axis=1)
    first, second = order[:-1][same], order[1:][same]
    differ = labels[cell[first]] != labels[cell[second]]
    first, second = first[differ], second[differ]
    # the triangle is seen from the lower of two regions, but never from outside
    swap = (labels[cell[first]] > labels[cell[second]]) & (labels[cell[second]] >= 0)
    swap |= labels[cell[first]] < 0
    behind = np.where(swap, second, first)
    pairs = np.sort(np.stack([labels[cell[first]], labels[cell[second]]], axis=1), axis=1)
    return triangles[behind], cell[behind], pairs
