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
from tactgen.geometry.cad.tessellation import Plane, Surface, Tessellation
from tactgen.geometry.device.layout import MM
from tactgen.geometry.errors import MeshError
from tactgen.geometry.meshing.mesh import Mesh
from tactgen.geometry.meshing.mesh_check import (
    check_areas,
    check_conformity,
    check_shape,
    check_volumes,
    is_poor,
)
from tactgen.geometry.meshing.quadratic import edges_of_triangles, unique_edges
from tactgen.geometry.meshing.tetwild.relaxing import relaxed
from tactgen.geometry.meshing.tetwild.snapping import bent_middles, is_curved, memberships, snapped
from tactgen.geometry.meshing.tetwild.stretching import UNSTRETCHED, Stretching
from tactgen.geometry.meshing.tetwild.tagging import Skin, region_labels, skin

if TYPE_CHECKING:
    import cadquery as cq


@dataclass(frozen=True)
class NamedFace:
    """A named face: the pieces of a plane (mm) that bound the given regions."""

    plane: Plane
    regions: tuple[str, ...]


@dataclass(frozen=True)
class _Draft:
    """A mesh in the making: all tetrahedra, vertices on their surfaces (mm)."""

    points: Floats
    tets: Ints
    labels: Ints
    skin: Skin


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
    """Return the mesh of the solids.

    Parameters
    ----------
    raw : (n_points, 3) array
        The mesher's points (mm).
    tets : (n_tets, 4) int array
        Its tetrahedra, those outside the solids included.
    solids : dict of str to cadquery.Solid
        Fused solids (mm).
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

    Returns
    -------
    Mesh
        In metres.

    Raises
    ------
    MeshError
        If it does not pass its checks.
    """
    draft = _draft(raw, tets, solids, tessellation, slack, stretching)
    return _finished(draft, solids, tessellation, named, curved, stretching)


def _draft(
    raw: Floats,
    tets: Ints,
    solids: dict[str, cq.Solid],
    tessellation: Tessellation,
    slack: float,
    stretching: Stretching,
) -> _Draft:
    """Tag the tetrahedra and put the vertices on their surfaces, from which they are `slack`."""
    surfaces = list(dict.fromkeys(face.surface for face in tessellation.faces))
    surface_of_face = np.array([surfaces.index(face.surface) for face in tessellation.faces])
    labels = region_labels(raw, tets, solids, surfaces, tolerance=1.5 * slack)
    while True:
        found = skin(raw, tets, labels, tuple(solids), tessellation.faces, 2.0 * slack)
        belongs = memberships(found.triangles, found.face, surface_of_face)
        points = snapped(raw, *belongs, surfaces, reach=5.0 * slack)
        seen = stretching.squeezed(points)
        flat = _flat_on_the_outside(seen, tets, found)
        if not flat.size:
            free = _free_axes(len(points), *belongs, surfaces)
            moved = stretching.restored(relaxed(seen, tets[labels >= 0], free))
            points = np.where(free, moved, points)
            return _Draft(points, tets, labels, found)
        labels[flat] = -1


def _free_axes(n: int, members: Ints, surface_of: Ints, surfaces: Sequence[Surface]) -> Bools:
    """Return along which axes (n, 3) each point can move and stay on its surfaces.

    The device's planes are across an axis; along a cylinder or another plane nothing moves.
    """
    held = np.array(
        [np.abs(s.normal) > 0.0 if _across_an_axis(s) else np.ones(3, bool) for s in surfaces]
    )
    free = np.ones((n, 3), dtype=bool)
    np.logical_and.at(free, members, ~held[surface_of])
    return free


def _across_an_axis(surface: Surface) -> TypeGuard[Plane]:
    return isinstance(surface, Plane) and np.count_nonzero(surface.normal) == 1


def _flat_on_the_outside(points: Floats, tets: Ints, found: Skin) -> Ints:
    """Return the flat tetrahedra that show two faces to the outside on one CAD face.

    Putting vertices back can flatten a tetrahedron on a surface.  Left out, the surface has
    the same shape and only another diagonal.
    """
    shown = np.stack([found.cell, found.face], axis=1)[found.open]
    pairs, count = np.unique(shown, axis=0, return_counts=True)
    cells = np.unique(pairs[count >= 2, 0])
    return np.asarray(cells[is_poor(points, tets[cells])])


def _finished(
    draft: _Draft,
    solids: dict[str, cq.Solid],
    tessellation: Tessellation,
    named: dict[str, NamedFace],
    curved: bool,
    stretching: Stretching,
) -> Mesh:
    """Return the mesh without what is outside, with curved edges, checked, in metres."""
    found, faces = draft.skin, tessellation.faces
    inside = draft.labels >= 0
    used, tets = np.unique(draft.tets[inside], return_inverse=True)
    tets = tets.reshape(-1, 4)
    triangles = np.searchsorted(used, found.triangles)
    points = draft.points[used]
    labels = draft.labels[inside]
    check_shape(stretching.squeezed(points), tets)
    check_conformity(tets, int(found.open.sum()))

    edges, edges_of_cell = unique_edges(tets)
    edges_of_face = edges_of_triangles(triangles, edges)
    surfaces = [face.surface for face in faces]
    cells = np.concatenate([tets, edges_of_cell + len(points)], axis=1)
    belongs = memberships(edges_of_face, found.face, np.arange(len(faces)))
    middles = points[edges].mean(axis=1)
    middles = bent_middles(points, cells, middles, belongs, surfaces)
    nodes = np.concatenate([points, middles])
    six = np.concatenate([triangles, edges_of_face + len(points)], axis=1)
    volumes = {name: solid.Volume() for name, solid in solids.items()}
    check_volumes(nodes, cells, labels, volumes, _bounded_by_planes(tessellation))
    check_areas(nodes, six, found.face, faces)

    curved = curved and is_curved(surfaces)
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
    """Return the CAD faces that make up a named face; there is at least one."""
    pieces = [
        i
        for i, face in enumerate(tessellation.faces)
        if face.surface == named.plane and face.sides & set(named.regions)
    ]
    if not pieces:
        raise MeshError(f"the face {name} is not in the CAD model; round the dimensions to 1 nm")
    return pieces


def _bounded_by_planes(tessellation: Tessellation) -> set[str]:
    """Return the names of the solids without a cylinder."""
    names = {name for face in tessellation.faces for name in face.sides}
    round_ones = {n for f in tessellation.faces if is_curved([f.surface]) for n in f.sides}
    return names - round_ones
