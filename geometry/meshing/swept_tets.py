"""Curved tetrahedra swept about an axis: for bodies turned about z, of which a sector will do.

The boxes of a grid in (r, φ, z), cut as :mod:`geometry.meshing.tensor_tets` cuts them, are bent
into the sector; those that touch the axis become wedges.  Mid-edge nodes are halfway in r,
φ and z, so every cylinder about z and every plane of the grid is met.  Knows the half
section's rectangles and region numbers, not what they mean.
"""

from __future__ import annotations

import numpy as np

from tactgen.geometry.arrays import Floats, Ints
from tactgen.geometry.meshing.mesh import Mesh
from tactgen.geometry.meshing.quadratic import unique_edges
from tactgen.geometry.meshing.tensor_tets import box_tetrahedra

#: Sides of the box in (r, φ, z) that stay sides of the sector, and their names there.
_SIDES = {
    "x_high": "mantle",
    "y_low": "start",
    "y_high": "end",
    "z_low": "bottom",
    "z_high": "top",
}


def swept_tetrahedra(
    r: Floats, z: Floats, angles: Floats, region_of_cell: Ints, regions: tuple[str, ...]
) -> Mesh:
    """Return the sector's mesh of ten-node tetrahedra.

    Parameters
    ----------
    r, z : (nr,), (nz,) float
        Increasing grid lines of the half section (m); r from 0.
    angles : (na,) float
        Increasing angles (rad) of the half planes that bound the layers of cells, from the
        x-axis towards y.
    region_of_cell : (nr - 1, nz - 1) int
        Index into `regions`.
    regions : tuple of str
        Region names.

    Returns
    -------
    Mesh
        With the outer sides ``mantle``, ``start``, ``end``, ``bottom`` and ``top``.
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
    """Return for each node of the box the node that stands for it: one per height on the axis."""
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
    """Return the middle (r, φ, z) of each edge; a node on the axis has the other end's angle."""
    ends = polar[edges]
    for one, other in ((0, 1), (1, 0)):
        on_axis = ends[:, one, 0] == 0.0
        ends[on_axis, one, 1] = ends[on_axis, other, 1]
    return np.asarray(ends.mean(axis=1))


def _cartesian(polar: Floats) -> Floats:
    r, angle, z = polar.T
    return np.stack([r * np.cos(angle), r * np.sin(angle), z], axis=1)
