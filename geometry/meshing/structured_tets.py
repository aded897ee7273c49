"""Curved tetrahedra swept about an axis: for bodies turned about z, of which a sector will do.

The boxes of a grid in (r, φ, z), cut as :mod:`geometry.meshing.structured_tets` cuts them, are bent
into the sector; those that touch the axis become wedges.  Mid-edge nodes are halfway in r,
φ and z, so every cylinder about z and every plane of the grid is met.  Knows the half
section's rectangles and region numbers, not what they mean.
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np

from tactgen.geometry.arrays import Bools, Floats, Ints
from tactgen.geometry.meshing.mesh import TET_FACES, Mesh, unique_edges

#: Names of the six outer sides, in the order of axis and end.
SIDES = ("x_low", "x_high", "y_low", "y_high", "z_low", "z_high")

#: Points by which the sizes along an axis are summed: of the interval it is 1e-6.
_SAMPLES = 2001


def box_tetrahedra(
    x: Floats, y: Floats, z: Floats, region_of_box: Ints, regions: tuple[str, ...]
) -> Mesh:
    """Straight tetrahedra in all boxes between the grid planes.

    `x` (nx,), `y` (ny,), `z` (nz,) are increasing (m), `region_of_box` (nx - 1, ny - 1, nz - 1) the
    index into `regions`.  The mesh's faces are the outer sides named in `SIDES`.
    """
    sizes = (x.size, y.size, z.size)
    index = np.arange(x.size * y.size * z.size).reshape(sizes)
    points = np.stack(np.meshgrid(x, y, z, indexing="ij"), axis=-1).reshape(-1, 3)
    cells = []
    for order in itertools.permutations(range(3)):
        corner = np.zeros(3, dtype=int)
        path = [_corner(index, corner)]
        for axis in order:
            corner[axis] = 1
            path.append(_corner(index, corner))
        if np.linalg.det(np.eye(3)[list(order)]) < 0.0:
            path[2], path[3] = path[3], path[2]  # keep the volume positive
        cells.append(np.stack(path, axis=1))
    tets = np.stack(cells, axis=1).reshape(-1, 4)
    return Mesh(
        points=points,
        cells=tets,
        kind="tetra",
        region_of_cell=np.repeat(region_of_box.ravel(), len(cells)),
        regions=regions,
        faces=_sides(tets, sizes),
    )


def _corner(index: Ints, corner: Ints) -> Ints:
    """Vertex of each box at the low (0) or high (1) end of each axis."""
    cut = tuple(slice(c, n - 1 + c) for c, n in zip(corner, index.shape, strict=True))
    return np.asarray(index[cut].ravel())


def _sides(tets: Ints, sizes: tuple[int, int, int]) -> dict[str, Ints]:
    """Triangles on each outer side."""
    triangles = np.concatenate([tets[:, face] for face in TET_FACES])
    along = np.stack(np.unravel_index(triangles, sizes))
    faces = {}
    for name, (axis, end) in zip(SIDES, itertools.product(range(3), (0, 1)), strict=True):
        plane = end * (sizes[axis] - 1)
        faces[name] = triangles[np.all(along[axis] == plane, axis=1)]
    return faces


def graded_planes(stops: Sequence[tuple[float, float]], growth: float) -> Floats:
    """Grid planes through all stops, intervals growing away from each stop.

    `stops` are increasing positions (m) that must be planes, each with the length (m) wanted of the
    intervals beside it.  `growth` is how much longer an interval may be per distance from a stop:
    neighbours then differ by a factor of about exp(growth).  A family of alike meshes scales it as
    the sizes.
    """
    planes = [stops[0][0]]
    for (low, first), (high, last) in itertools.pairwise(stops):
        planes.extend(low + _divided(high - low, first, last, growth)[1:])
    return np.array(planes)


def _divided(length: float, first: float, last: float, growth: float) -> Floats:
    """Divide [0, length]: intervals near `first` and `last` at the ends, growing inwards.

    The size wanted at distance s from one end is size + growth s; the number of intervals
    is the integral of its inverse, and the planes divide that integral evenly.
    """
    s = np.linspace(0.0, length, _SAMPLES)
    size = np.minimum(first + growth * s, last + growth * (length - s))
    count = np.concatenate([[0.0], np.cumsum(0.5 * (1.0 / size[1:] + 1.0 / size[:-1]))]) * s[1]
    number = max(1, round(float(count[-1])))
    inner = np.interp(np.linspace(0.0, count[-1], number + 1), count, s)
    inner[[0, -1]] = 0.0, length
    return np.asarray(inner)


#: Sides of the box in (r, φ, z) that stay sides of the sector, and their names there.
_SIDES = {"x_high": "mantle", "y_low": "start", "y_high": "end", "z_low": "bottom", "z_high": "top"}


def swept_tetrahedra(
    r: Floats, z: Floats, angles: Floats, region_of_cell: Ints, regions: tuple[str, ...]
) -> Mesh:
    """Sector as ten-node tetrahedra; sides ``mantle``, ``start``, ``end``, ``bottom`` and ``top``.

    `r` (nr,), from 0, and `z` (nz,) are increasing grid lines of the half section (m); `angles`
    (na,) increasing angles (rad) of the half planes that bound the layers of cells, from the x-axis
    towards y; `region_of_cell` (nr - 1, nz - 1) is the index into `regions`.
    """
    layers = np.repeat(np.asarray(region_of_cell)[:, None, :], angles.size - 1, axis=1)
    box = box_tetrahedra(r, angles, z, layers, regions)
    same = _one_node_per_height(box.points)
    # a cell that ran along the axis's own turn has lost its volume
    corners = np.sort(same[box.cells], axis=1)
    kept = np.flatnonzero(np.all(corners[:, 1:] > corners[:, :-1], axis=1))
    used, cells = np.unique(same[box.cells[kept]], return_inverse=True)
    polar, cells = box.points[used], cells.reshape(-1, 4)
    edges, edge_of_cell = unique_edges(cells)
    number = np.full(same.size, -1)
    number[used] = np.arange(used.size)
    return Mesh(
        points=_cartesian(np.concatenate([polar, _middles(polar, edges)])),
        cells=np.hstack([cells, used.size + edge_of_cell]),
        kind="tetra10",
        region_of_cell=box.region_of_cell[kept],
        regions=regions,
        faces={name: _whole(number[same[box.faces[side]]]) for side, name in _SIDES.items()},
    )


def _one_node_per_height(polar: Floats) -> Ints:
    """For each node of the box the node that stands for it: one per height on the axis."""
    stands = np.arange(polar.shape[0])
    axis = np.flatnonzero(polar[:, 0] == 0.0)
    _, first, height = np.unique(polar[axis, 2], return_index=True, return_inverse=True)
    stands[axis] = axis[first][height]
    return stands


def _whole(triangles: Ints) -> Ints:
    """Drop triangles two of whose corners became one."""
    corners = np.sort(triangles, axis=1)
    return triangles[np.all(corners[:, 1:] > corners[:, :-1], axis=1)]


def _middles(polar: Floats, edges: Ints) -> Floats:
    """Middle (r, φ, z) of each edge; a node on the axis has the other end's angle."""
    ends = polar[edges]
    for one, other in ((0, 1), (1, 0)):
        on_axis = ends[:, one, 0] == 0.0
        ends[on_axis, one, 1] = ends[on_axis, other, 1]
    return np.asarray(ends.mean(axis=1))


def _cartesian(polar: Floats) -> Floats:
    r, angle, z = polar.T
    return np.stack([r * np.cos(angle), r * np.sin(angle), z], axis=1)


#: Named faces of a quarter: on x = 0 and on y = 0; half of a body has the latter only.
MIRRORS = ("mirror_x", "mirror_y")

#: Distance (m) up to which a point lies on a plane of symmetry.
_ON_PLANE = 1e-10

#: The parts: which of x and y are turned round.  The first is the one that was meshed.
_TURNS = ((False, False), (True, False), (False, True), (True, True))

#: Nodes of a cell or triangle seen in the mirror, so that it is not inside out, by their number.
_REFLECTED = {3: [1, 0, 2], 4: [1, 0, 2, 3], 10: [1, 0, 2, 3, 4, 6, 5, 8, 7, 9]}


@dataclass(frozen=True)
class MirroredPoints:
    """The points of the whole body, those that were meshed first and in their order."""

    points: Floats  #: (n_whole, 3) Coordinates (m)
    source: Ints  #: (n_whole,) The meshed point that each is or mirrors
    turned: Bools  #: (n_whole, 2) Whether it lies beyond x = 0, and beyond y = 0
    #: (2 or 4, n) The points that stand for those that were meshed in each of the parts
    images: Ints


#: Axes along which a mesh is mirrored: of a quarter, of half a body, of a whole one.
MirrorAxes: TypeAlias = tuple[int, ...]


def mirror_axes(mesh: Mesh) -> MirrorAxes:
    """Axes along which a mesh is mirrored to give the whole body: (0, 1), (1,) or ()."""
    there = tuple(axis for axis, name in enumerate(MIRRORS) if name in mesh.faces)
    return there if 1 in there else ()


def _turns(axes: MirrorAxes) -> list[tuple[bool, bool]]:
    return [t for t in _TURNS if all(axis in axes for axis in range(2) if t[axis])]


def mirrored_points(points: Floats, axes: MirrorAxes = (0, 1)) -> MirroredPoints:
    """Points (n, 3) in m with their images along some axes; those on a plane are their own."""
    n, turns = len(points), _turns(axes)
    on_plane = np.abs(points[:, :2]) <= _ON_PLANE
    images = np.empty((len(turns), n), dtype=np.int64)
    source, turned, count = [], [], 0
    for k, turn in enumerate(turns):
        new = np.flatnonzero(~(on_plane & np.array(turn)).any(axis=1))
        images[k, new] = count + np.arange(new.size)
        count += new.size
        source.append(new)
        turned.append(np.tile(np.array(turn), (new.size, 1)))
        for axis in range(2):  # a point on a plane is where the unturned one is
            if turn[axis]:
                other = turns.index((turn[0] and axis != 0, turn[1] and axis != 1))
                images[k, on_plane[:, axis]] = images[other, on_plane[:, axis]]
    sources, beyond = np.concatenate(source), np.concatenate(turned)
    whole = points[sources].copy()
    whole[:, :2] *= np.where(beyond, -1.0, 1.0)
    return MirroredPoints(whole, sources, beyond, images)


def whole_mesh(mesh: Mesh) -> Mesh:
    """Whole body's mesh; one that is whole already is returned as it is.

    What is ``top`` in the name of a region or face lies at x > 0; beyond, it is ``bottom``.
    """
    axes = mirror_axes(mesh)
    if not axes:
        return mesh
    mirrored, turns = mirrored_points(mesh.points, axes), _turns(axes)
    names = [[_seen(name, turn) for name in mesh.regions] for turn, _ in turns]
    regions = tuple(dict.fromkeys(name for row in names for name in row))
    cells, labels = [], []
    faces: dict[str, list[Ints]] = {}
    for image, turn, row in zip(mirrored.images, turns, names, strict=True):
        seen = reflected if turn[0] != turn[1] else np.asarray
        cells.append(seen(image[mesh.cells]))
        labels.append(np.array([regions.index(name) for name in row])[mesh.region_of_cell])
        for name, triangles in mesh.faces.items():
            if name not in MIRRORS:
                faces.setdefault(_seen(name, turn[0]), []).append(seen(image[triangles]))
    return Mesh(
        points=mirrored.points,
        cells=np.concatenate(cells),
        kind=mesh.kind,
        region_of_cell=np.concatenate(labels),
        regions=regions,
        faces={name: np.concatenate(parts) for name, parts in faces.items()},
    )


def reflected(nodes: Ints) -> Ints:
    """Cells or triangles (n, 3 | 4 | 10) as seen in a mirror, so that none is inside out."""
    return nodes[:, _REFLECTED[nodes.shape[1]]]


def _seen(name: str, beyond: bool) -> str:
    return name.replace("top", "bottom") if beyond else name
