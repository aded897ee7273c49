"""Makes the mesher's raw tetrahedra follow the CAD solids exactly, or refuses them.

Regions, vertices on their surfaces, bent edges, checks and named faces, in that order.
Knows nothing of the device: only solids, their faces and planes that have a name.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, TypeGuard

import numpy as np

from tactgen.geometry.arrays import Bools, Floats, Ints
from tactgen.geometry.cad.tessellation import OUTSIDE, Cylinder, Face, Plane, Surface, Tessellation
from tactgen.geometry.device.parts import MM
from tactgen.geometry.errors import MeshError
from tactgen.geometry.meshing.mesh import (
    TET_FACES,
    Mesh,
    check_areas,
    check_conformity,
    check_shape,
    check_volumes,
    edges_of_triangles,
    is_poor,
    jacobian_coefficients,
    smallest_dihedral_angles,
    tet_volumes,
    unique_edges,
)
from tactgen.geometry.meshing.tetwild.mesher import UNSTRETCHED, Stretching

if TYPE_CHECKING:
    import cadquery as cq


@dataclass(frozen=True)
class Skin:
    """The triangles on which a region ends, each assigned to a CAD face."""

    #: (n_triangles, 3) Corners, seen from the side that the triangle's cell does not fill
    triangles: Ints
    #: (n_triangles,) The tetrahedron behind the triangle; between two regions, the one with the
    #: lower label
    cell: Ints
    face: Ints  #: (n_triangles,) Index of the CAD face
    open: Bools  #: (n_triangles,) Whether the other side is outside


def region_labels(
    points: Floats,
    tets: Ints,
    solids: dict[str, cq.Solid],
    surfaces: list[Surface],
    tolerance: float,
) -> Ints:
    """Index (n_tets,) of the solid that each tetrahedron fills, -1 outside.

    The surfaces, all that bound the solids, cut space into pieces each of which lies in one solid
    or outside.  The CAD kernel classifies one point of each piece, every tetrahedron inherits.  A
    vertex on a surface, up to `tolerance` (mm) away, does not count for the side of its
    tetrahedron, so curved boundaries with straight-edged elements are no exception.

    `points` (n_points, 3) are in mm as the fused solids are, `tets` (n_tets, 4) the corners.
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
    """Index of the solid that holds each point, -1 for none, by the CAD kernel."""
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

    `names` has the region of each label, `faces` are all CAD faces of the fused solids, `tolerance`
    is the largest distance allowed between a triangle's corners and its face (mm).

    Raises MeshError if two regions touch that do not touch in CAD, or a triangle lies on no face.
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
    """Triangles (n, 3), cell behind (n,) and sorted label pairs (n, 2)."""
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


#: Rounds over all flat tetrahedra at most: one helps its neighbours in the next.
_ROUNDS = 4

#: Shares of the way to the middle of its neighbours that a vertex is tried at.
_WAYS = (0.1, 0.3, 0.6, 1.0)


def relaxed(points: Floats, tets: Ints, free: Bools) -> Floats:
    """Points, vertices of flat tetrahedra moved where their worst angle is best.

    `points` (n_points, 3) are coordinates in which the shape of tetrahedra is judged, `tets` the
    corners (n_tets, 4) of all that must keep their volume, `free` (n_points, 3) says along which
    axes each point may be moved.
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
    """Where the worst of the tetrahedra around a vertex is best, along free axes."""
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


#: Newton steps at most: planes need one, a cylinder with planes across it two or three.
_STEPS = 8

#: Distance (mm) below which a point is on its surfaces: rounding.
_ON = 1e-10

#: A bent element's Jacobian stays above this share of the straight one's.
_ROOM = 0.1


def snapped(
    points: Floats, members: Ints, surface_of: Ints, surfaces: Sequence[Surface], reach: float
) -> Floats:
    """Points (n_points, 3) moved onto all the surfaces that each belongs to, `reach` at most (mm).

    Point or points ``members[i]``, (n,) or (n, k), belong to ``surfaces[surface_of[i]]``.

    Raises MeshError if a point cannot be on all its surfaces or would have to move too far.
    """
    belongs = np.zeros((len(points), len(surfaces)), dtype=bool)
    belongs[members.T, surface_of] = True
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
    """Points (n, 3) moved the shortest way onto all surfaces (Newton)."""
    points = points.copy()
    for _ in range(_STEPS):
        distance = np.stack([s.distance(points) for s in surfaces], axis=1)
        if np.abs(distance).max() < _ON:
            return points
        gradient = np.stack([s.gradient(points) for s in surfaces], axis=1)
        points -= (np.linalg.pinv(gradient, rcond=1e-6) @ distance[..., None])[..., 0]
    raise MeshError("a vertex belongs to faces that do not meet; choose a smaller edge length")


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
    """Mid-edge nodes moved onto the surfaces, except where an element would fold.

    `points` (n_points, 3) are the vertices (mm), `cells` (n_cells, 10) have these first, then
    mid-edge nodes numbered from ``n_points``; `middles` (n_edges, 3) are the midpoints of the
    straight edges (mm), `on_surface` edges and the surfaces they lie on, as :func:`snapped` wants
    them.
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


@dataclass(frozen=True)
class NamedFace:
    """A named face: the pieces of some planes (mm) that bound the given regions."""

    planes: tuple[Plane, ...]
    regions: tuple[str, ...]


def conform(
    raw: Floats,
    tets: Ints,
    solids: dict[str, cq.Solid],
    tessellation: Tessellation,
    slack: float,
    named: dict[str, NamedFace],
    curved: bool,
    stretching: Stretching = UNSTRETCHED,
) -> Mesh:
    """Mesh of the solids (mm), in metres.

    Parameters
    ----------
    raw, tets : (n_points, 3) and (n_tets, 4) int array
        The mesher's points (mm) and tetrahedra, those outside the solids included.
    tessellation : Tessellation
        The surface that was meshed, and its CAD faces.
    slack : float
        How far raw points may be from the CAD surfaces they stand for (mm).
    named : dict of str to NamedFace
        Faces to name.
    curved : bool
        Whether curved boundaries get curved elements.
    stretching : Stretching
        Under which the mesher saw the solids: the elements' shape is judged there.

    Raises MeshError if it does not pass its checks.
    """
    surfaces = list(dict.fromkeys(face.surface for face in tessellation.faces))
    surface_of_face = np.array([surfaces.index(face.surface) for face in tessellation.faces])
    labels = region_labels(raw, tets, solids, surfaces, tolerance=1.5 * slack)
    while True:
        found = skin(raw, tets, labels, tuple(solids), tessellation.faces, 2.0 * slack)
        belongs = found.triangles, surface_of_face[found.face]
        points = snapped(raw, *belongs, surfaces, reach=5.0 * slack)
        seen = stretching.squeezed(points)
        flat = _flat_on_the_outside(seen, tets, found)
        if not flat.size:
            break
        labels[flat] = -1
    free = _free_axes(len(points), *belongs, surfaces)
    moved = stretching.restored(relaxed(seen, tets[labels >= 0], free))
    points = np.where(free, moved, points)
    curved = curved and is_curved(surfaces)
    return _finished(points, tets, labels, found, solids, tessellation, named, curved, stretching)


def _free_axes(n: int, members: Ints, surface_of: Ints, surfaces: Sequence[Surface]) -> Bools:
    """Along which axes (n, 3) each point can move and stay on its surfaces.

    The device's planes are across an axis; along a cylinder or another plane nothing moves.
    """
    held = np.array(
        [np.abs(s.normal) > 0.0 if _across_an_axis(s) else np.ones(3, bool) for s in surfaces]
    )
    free = np.ones((n, 3), dtype=bool)
    np.logical_and.at(free, members.T, ~held[surface_of])
    return free


def _across_an_axis(surface: Surface) -> TypeGuard[Plane]:
    return isinstance(surface, Plane) and np.count_nonzero(surface.normal) == 1


def _flat_on_the_outside(points: Floats, tets: Ints, found: Skin) -> Ints:
    """Flat tetrahedra that show two faces to the outside on one CAD face.

    Putting vertices back can flatten a tetrahedron on a surface.  Left out, the surface has
    the same shape and only another diagonal.
    """
    shown = np.stack([found.cell, found.face], axis=1)[found.open]
    pairs, count = np.unique(shown, axis=0, return_counts=True)
    cells = np.unique(pairs[count >= 2, 0])
    return np.asarray(cells[is_poor(points, tets[cells])])


def _finished(
    points: Floats,
    tets: Ints,
    labels: Ints,
    found: Skin,
    solids: dict[str, cq.Solid],
    tessellation: Tessellation,
    named: dict[str, NamedFace],
    curved: bool,
    stretching: Stretching,
) -> Mesh:
    """Checked mesh of the inside, in metres, its edges curved if wanted."""
    faces = tessellation.faces
    used, tets = np.unique(tets[labels >= 0], return_inverse=True)
    points, tets, labels = points[used], tets.reshape(-1, 4), labels[labels >= 0]
    triangles = np.searchsorted(used, found.triangles)
    check_shape(stretching.squeezed(points), tets)
    check_conformity(tets, int(found.open.sum()))

    edges, edges_of_cell = unique_edges(tets)
    edges_of_face = edges_of_triangles(triangles, edges)
    surfaces = [face.surface for face in faces]
    cells = np.concatenate([tets, edges_of_cell + len(points)], axis=1)
    middles = points[edges].mean(axis=1)
    middles = bent_middles(points, cells, middles, (edges_of_face, found.face), surfaces)
    nodes = np.concatenate([points, middles])
    six = np.concatenate([triangles, edges_of_face + len(points)], axis=1)
    volumes = {name: solid.Volume() for name, solid in solids.items()}
    check_volumes(nodes, cells, labels, volumes, _bounded_by_planes(tessellation))
    check_areas(nodes, six, found.face, faces)

    return Mesh(
        points=(nodes if curved else points) / MM,
        cells=cells if curved else tets,
        kind="tetra10" if curved else "tetra",
        region_of_cell=labels,
        regions=tuple(solids),
        faces={
            name: triangles[np.isin(found.face, _pieces(name, face, tessellation))]
            for name, face in named.items()
        },
    )


def _pieces(name: str, named: NamedFace, tessellation: Tessellation) -> list[int]:
    """CAD faces that make up a named face; there is at least one."""
    pieces = [
        i
        for i, face in enumerate(tessellation.faces)
        if face.sides & set(named.regions)
        and isinstance(face.surface, Plane)
        and any(face.surface.is_like(plane) for plane in named.planes)
    ]
    if not pieces:
        raise MeshError(f"the face {name} is not in the CAD model; round the dimensions to 1 nm")
    return pieces


def _bounded_by_planes(tessellation: Tessellation) -> set[str]:
    """Names of the solids without a cylinder."""
    names = {name for face in tessellation.faces for name in face.sides}
    round_ones = {n for f in tessellation.faces if is_curved([f.surface]) for n in f.sides}
    return names - round_ones
