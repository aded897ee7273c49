"""An eighth of a ball inside a concentric shell, in straight or curved tetrahedra.

Built on the octant of a cube whose shells |q|_max = s are mapped to spheres; inside
s = CORE the map is the identity.  Quadratic nodes take the same map, so curved cells lie on
the sphere at their mid-edge nodes too.
"""

from __future__ import annotations

import itertools
from dataclasses import replace

import numpy as np

from tactgen.geometry.arrays import Floats, Ints
from tactgen.geometry.meshing.mesh import Mesh
from tactgen.geometry.meshing.quadratic import unique_edges

RADIUS, OUTER, CORE = 1.0, 3.0, 0.4


def sphere_mesh(n: int, *, curved: bool, shells: Floats | None = None) -> Mesh:
    """Return the mesh with `n` intervals along each edge of the core and of the ball's shell.

    Regions ball, air and far, the outermost layer of cells; faces x_low, y_low, z_low, outer.
    `shells` are the radii of the layers around the ball, from RADIUS; to OUTER by default.
    """
    if shells is None:
        shells = np.asarray(np.geomspace(RADIUS, OUTER, 2 * n + 1))
    q, hexes = _cube_octant(n, shells)
    tets, q = _split(hexes, q)
    depth = np.max(q[tets].mean(axis=1), axis=1)
    beyond = q[tets].max(axis=2).min(axis=1) > shells[-2] * (1.0 - 1e-9)
    faces = np.concatenate([tets[:, f] for f in itertools.combinations(range(4), 3)])
    on = {
        name: faces[np.all(np.abs(q[faces, axis]) < 1e-12, axis=1)]
        for axis, name in enumerate(("x_low", "y_low", "z_low"))
    }
    on["outer"] = faces[np.all(np.abs(q[faces].max(axis=2) / shells[-1] - 1.0) < 1e-12, axis=1)]
    points, cells = _mapped(q), tets
    if curved:
        edges, of_cell = unique_edges(tets)
        cells = np.hstack([tets, len(q) + of_cell])
        points = np.concatenate([points, _mapped(q[edges].mean(axis=1))])
    return Mesh(
        points=points,
        cells=cells,
        kind="tetra10" if curved else "tetra",
        region_of_cell=(depth > RADIUS).astype(int) + beyond,
        regions=("ball", "air", "far"),
        faces=on,
    )


def mirrored(mesh: Mesh, axis: int) -> Mesh:
    """Return the mesh and its image at the plane through the origin as one, outer faces kept."""
    image = mesh.points.copy()
    image[:, axis] *= -1.0
    off = np.abs(mesh.points[:, axis]) > 1e-12
    number = np.arange(len(mesh.points))
    number[off] = len(mesh.points) + np.arange(off.sum())
    # swapping corners 0 and 1 keeps volumes positive; their edges' middles go along
    swapped = [1, 0, 2, 3] + ([4, 6, 5, 8, 7, 9] if mesh.kind == "tetra10" else [])
    return replace(
        mesh,
        points=np.concatenate([mesh.points, image[off]]),
        cells=np.concatenate([mesh.cells, number[mesh.cells][:, swapped]]),
        region_of_cell=np.tile(mesh.region_of_cell, 2),
        faces={
            name: np.concatenate([faces, number[faces]])
            for name, faces in mesh.faces.items()
            if name != ("x_low", "y_low", "z_low")[axis]
        },
    )


def _mapped(q: Floats) -> Floats:
    """Move straight from the core's surface to the ball's along each ray; spheres beyond."""
    s = q.max(axis=1)
    away = s > CORE
    ray = q[away] / s[away, None]
    unit = ray / np.linalg.norm(ray, axis=1, keepdims=True)
    t = np.clip((s[away] - CORE) / (RADIUS - CORE), 0.0, 1.0)[:, None]
    p = q.copy()
    p[away] = (1.0 - t) * CORE * ray + t * np.maximum(s[away, None], RADIUS) * unit
    return p


def _cube_octant(n: int, shells: Floats) -> tuple[Floats, Ints]:
    """Return points and hexahedra of an inner cube and of three blocks around it, merged."""
    across = np.tan(0.25 * np.pi * np.linspace(0.0, 1.0, n + 1))
    layers = np.concatenate([np.linspace(CORE, RADIUS, n + 1), shells[1:]])
    blocks = [np.stack(np.meshgrid(*[CORE * across] * 3, indexing="ij"), axis=-1)]
    s, a, b = np.meshgrid(layers, across, across, indexing="ij")
    blocks += [np.roll(np.stack([s, s * a, s * b], axis=-1), k, axis=-1) for k in range(3)]
    points, hexes, start = [], [], 0
    for grid in blocks:
        index: Ints = start + np.arange(grid[..., 0].size).reshape(grid.shape[:3])
        corners = [
            index[
                i : index.shape[0] - 1 + i, j : index.shape[1] - 1 + j, k : index.shape[2] - 1 + k
            ]
            for i, j, k in itertools.product((0, 1), repeat=3)
        ]
        hexes.append(np.stack([c.ravel() for c in corners], axis=1))
        points.append(grid.reshape(-1, 3))
        start += index.size
    _, first, same = np.unique(
        np.round(np.concatenate(points), 9), axis=0, return_index=True, return_inverse=True
    )
    return np.concatenate(points)[first], same.reshape(-1)[np.concatenate(hexes)]


def _split(hexes: Ints, q: Floats) -> tuple[Ints, Floats]:
    """Return twelve tetrahedra around each centre, and the points with the centres.

    Faces cut from their lowest vertex match between neighbours.
    """
    centre = len(q) + np.arange(len(hexes))
    q = np.concatenate([q, q[hexes].mean(axis=1)])
    corners = []
    for quad in (
        [0, 1, 3, 2],
        [4, 5, 7, 6],
        [0, 1, 5, 4],
        [2, 3, 7, 6],
        [0, 2, 6, 4],
        [1, 3, 7, 5],
    ):
        face = hexes[:, quad]
        lowest = np.argmin(face, axis=1)
        face = np.take_along_axis(face, (lowest[:, None] + np.arange(4)) % 4, axis=1)
        corners += [np.column_stack([face[:, pick], centre]) for pick in ([0, 1, 2], [0, 2, 3])]
    tets = np.concatenate(corners)
    p = _mapped(q)[tets]
    wrong = np.linalg.det(p[:, 1:] - p[:, :1]) < 0.0
    tets[wrong] = tets[wrong][:, [1, 0, 2, 3]]
    return tets, q
