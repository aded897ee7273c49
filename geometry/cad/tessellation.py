"""From fused CAD solids to one triangulated surface and the analytic faces behind it.

Touching solids share faces, so one triangulation serves both sides.  Still in
millimetres, still no volume mesh.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from tactgen.geometry.arrays import Floats, Ints
from tactgen.geometry.errors import InputError

if TYPE_CHECKING:
    import cadquery as cq


def merge_points(points: Floats, within: float) -> tuple[Floats, Ints]:
    """Points (n, 3) that differ, and which of them each of the given ones is.

    Those up to `within` apart are the same, which is far below the distance of any others.
    """
    from scipy.spatial import cKDTree

    pairs = cKDTree(points).query_pairs(within, output_type="ndarray")
    # the pairs are complete within each cluster, so the lowest index names the cluster
    lowest = np.arange(len(points))
    np.minimum.at(lowest, pairs.max(axis=1), pairs.min(axis=1))
    kept, index = np.unique(lowest, return_inverse=True)
    return points[kept], index


#: Name of what surrounds the solids.
OUTSIDE = "outside"

#: Points closer than this (mm) are one point: far above rounding, far below any feature.
_SAME_POINT = 1e-6


@dataclass(frozen=True)
class Plane:
    """An infinite plane: the points with ``normal · p = offset`` (mm)."""

    normal: tuple[float, float, float]
    offset: float

    def distance(self, points: Floats) -> Floats:
        """Signed distance of points (..., 3) in mm."""
        return np.asarray(points @ np.array(self.normal) - self.offset)

    def gradient(self, points: Floats) -> Floats:
        """Gradient (..., 3) of the distance at points (..., 3)."""
        return np.broadcast_to(np.array(self.normal), points.shape)

    def is_like(self, other: Plane) -> bool:
        """Whether two planes are the same but for rounding."""
        own, others = (np.array([*plane.normal, plane.offset]) for plane in (self, other))
        return float(np.abs(own - others).max()) < _SAME_POINT


@dataclass(frozen=True)
class Cylinder:
    """An infinite circular cylinder about the z axis (mm)."""

    radius: float

    def distance(self, points: Floats) -> Floats:
        """Signed distance of points (..., 3) in mm, positive outside."""
        return np.asarray(np.hypot(points[..., 0], points[..., 1]) - self.radius)

    def gradient(self, points: Floats) -> Floats:
        """Gradient (..., 3) of the distance at points (..., 3)."""
        radius = np.hypot(points[..., 0], points[..., 1])
        gradient = np.zeros(points.shape)
        gradient[..., :2] = points[..., :2] / np.maximum(radius, 1e-12)[..., None]
        return gradient


Surface = Plane | Cylinder


@dataclass(frozen=True)
class Face:
    """Piece of CAD boundary: its surface and the regions on both sides.

    Pieces of one surface between the same neighbours count as one face.
    """

    surface: Surface
    sides: frozenset[str]
    area: float


@dataclass(frozen=True)
class Tessellation:
    """A triangulated surface without doubled points, and the faces it came from."""

    points: Floats  #: (n_points, 3) Coordinates (mm)
    triangles: Ints  #: (n_triangles, 3) Corners; a face between two solids is there once
    faces: tuple[Face, ...]  #: The CAD faces


def tessellate(solids: dict[str, cq.Solid], deflection: float, angle: float = 0.5) -> Tessellation:
    """Triangulate fused solids (mm).

    Curved faces and their triangles are apart by `deflection` (mm) at most, neighbouring triangles
    turn by `angle` (rad) at most.
    """
    import cadquery as cq
    from OCP.BRepMesh import BRepMesh_IncrementalMesh

    whole = cq.Compound.makeCompound(list(solids.values()))
    BRepMesh_IncrementalMesh(whole.wrapped, deflection, False, angle, False)
    sides = _sides(solids)
    points, triangles, start = [], [], 0
    for face, _ in sides:
        p, t = _face_triangles(face)
        points.append(p)
        triangles.append(t + start)
        start += len(p)
    merged, index = merge_points(np.concatenate(points), _SAME_POINT)
    return Tessellation(
        points=merged, triangles=index[np.concatenate(triangles)], faces=_collect(sides)
    )


def _sides(solids: dict[str, cq.Solid]) -> list[tuple[cq.Face, frozenset[str]]]:
    """Every face once, with the regions on both sides."""
    seen: dict[cq.Face, set[str]] = {}  # cadquery faces compare as the same piece of CAD
    for name, solid in solids.items():
        for face in solid.Faces():
            seen.setdefault(face, set()).add(name)
    return [
        (face, frozenset(names if len(names) == 2 else names | {OUTSIDE}))
        for face, names in seen.items()
    ]


def _face_triangles(face: cq.Face) -> tuple[Floats, Ints]:
    from OCP.BRep import BRep_Tool
    from OCP.TopLoc import TopLoc_Location

    location = TopLoc_Location()
    mesh = BRep_Tool.Triangulation_s(face.wrapped, location)
    move = location.Transformation()
    nodes = [mesh.Node(i + 1).Transformed(move) for i in range(mesh.NbNodes())]
    points = np.array([(p.X(), p.Y(), p.Z()) for p in nodes])
    corners = [mesh.Triangle(i + 1).Get() for i in range(mesh.NbTriangles())]
    return points, np.array(corners, dtype=np.int64) - 1


def _collect(sides: list[tuple[cq.Face, frozenset[str]]]) -> tuple[Face, ...]:
    areas: dict[tuple[Surface, frozenset[str]], float] = {}
    known: list[Surface] = []
    for face, names in sides:
        surface = _surface(face)
        # sloping faces of one plane differ by rounding
        surface = next((other for other in known if _alike(surface, other)), surface)
        known.append(surface)
        areas[surface, names] = areas.get((surface, names), 0.0) + face.Area()
    return tuple(Face(surface, names, area) for (surface, names), area in areas.items())


def _alike(one: Surface, other: Surface) -> bool:
    if isinstance(one, Plane) and isinstance(other, Plane):
        return one.is_like(other)
    return one == other


def _surface(face: cq.Face) -> Surface:
    """Analytic surface of a face, oriented the same way on all its pieces."""
    from OCP.BRepAdaptor import BRepAdaptor_Surface
    from OCP.GeomAbs import GeomAbs_SurfaceType

    adaptor = BRepAdaptor_Surface(face.wrapped)
    kind = adaptor.GetType()
    if kind == GeomAbs_SurfaceType.GeomAbs_Plane:
        plane = adaptor.Plane()
        direction, origin = plane.Axis().Direction(), plane.Location()
        normal = np.array([direction.X(), direction.Y(), direction.Z()])
        offset = float(normal @ [origin.X(), origin.Y(), origin.Z()])
        sign = np.sign(normal[np.argmax(np.abs(normal))])
        # + 0.0: no negative zero, and rounding far below tolerance: equal planes compare equal
        x, y, z = (float(v) for v in np.round(sign * normal, 12) + 0.0)
        # where several slopes meet, more digits of the offset tell
        digits = 9 if np.count_nonzero((x, y, z)) == 1 else 12
        return Plane((x, y, z), round(float(sign * offset), digits) + 0.0)
    if kind == GeomAbs_SurfaceType.GeomAbs_Cylinder:
        cylinder = adaptor.Cylinder()
        axis, origin = cylinder.Axis().Direction(), cylinder.Location()
        if abs(abs(axis.Z()) - 1.0) < 1e-12 and np.hypot(origin.X(), origin.Y()) < 1e-9:
            return Cylinder(round(cylinder.Radius(), 9))
    raise InputError("a solid has a face that is neither a plane nor a cylinder about the z axis")
