"""A quarter of a body that is symmetric about the planes x = 0 and y = 0, and the whole of it.

A mesh of a quarter (x ≥ 0, y ≥ 0) has its cuts as named faces, `MIRRORS`.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tactgen.geometry.arrays import Bools, Floats, Ints
from tactgen.geometry.meshing.mesh import Mesh

#: Named faces of a quarter: on x = 0 and on y = 0.
MIRRORS = ("mirror_x", "mirror_y")

#: Distance (m) up to which a point lies on a plane of symmetry.
_ON_PLANE = 1e-10

#: The four quarters: which of x and y are turned round.  The first is the one that was meshed.
_TURNS = ((False, False), (True, False), (False, True), (True, True))

#: Nodes of a cell or triangle seen in the mirror, so that it is not inside out, by their number.
_REFLECTED = {
    3: [1, 0, 2],
    4: [1, 0, 2, 3],
    10: [1, 0, 2, 3, 4, 6, 5, 8, 7, 9],
}


@dataclass(frozen=True)
class MirroredPoints:
    """The points of the whole body, those of the quarter first and in their order.

    Attributes
    ----------
    points : (n_whole, 3) array
        Coordinates (m).
    source : (n_whole,) int array
        The point of the quarter that each is or mirrors.
    turned : (n_whole, 2) bool array
        Whether it lies beyond x = 0, and beyond y = 0.
    images : (4, n) int array
        The points that stand for those of the quarter in each of the four quarters.
    """

    points: Floats
    source: Ints
    turned: Bools
    images: Ints


def is_quarter(mesh: Mesh) -> bool:
    """Return whether a mesh stands for a body of which it is a quarter."""
    return all(name in mesh.faces for name in MIRRORS)


def mirrored_points(points: Floats) -> MirroredPoints:
    """Return points (n, 3) of a quarter in m with their images; those on a plane are their own."""
    n = len(points)
    on_plane = np.abs(points[:, :2]) <= _ON_PLANE
    images = np.empty((4, n), dtype=np.int64)
    source, turned, count = [], [], 0
    for k, turn in enumerate(_TURNS):
        new = np.flatnonzero(~(on_plane & np.array(turn)).any(axis=1))
        images[k, new] = count + np.arange(new.size)
        count += new.size
        source.append(new)
        turned.append(np.tile(np.array(turn), (new.size, 1)))
        for axis in range(2):  # a point on a plane is where the unturned one is
            if turn[axis]:
                unturned = k - (1 << axis)
                images[k, on_plane[:, axis]] = images[unturned, on_plane[:, axis]]
    sources, turns = np.concatenate(source), np.concatenate(turned)
    whole = points[sources].copy()
    whole[:, :2] *= np.where(turns, -1.0, 1.0)
    return MirroredPoints(whole, sources, turns, images)


def whole_mesh(mesh: Mesh) -> Mesh:
    """Return the whole body's mesh; one that is whole already is returned as it is.

    What is ``top`` in the name of a region or face lies at x > 0; beyond, it is ``bottom``.
    """
    if not is_quarter(mesh):
        return mesh
    mirrored = mirrored_points(mesh.points)
    names = [[_seen(name, turn) for name in mesh.regions] for turn, _ in _TURNS]
    regions = tuple(dict.fromkeys(name for row in names for name in row))
    cells, labels = [], []
    faces: dict[str, list[Ints]] = {}
    for image, turn, row in zip(mirrored.images, _TURNS, names, strict=True):
        odd = turn[0] != turn[1]
        cells.append(_turned(image[mesh.cells], reflect=odd))
        labels.append(np.array([regions.index(name) for name in row])[mesh.region_of_cell])
        for name, triangles in mesh.faces.items():
            if name not in MIRRORS:
                seen = _turned(image[triangles], reflect=odd)
                faces.setdefault(_seen(name, turn[0]), []).append(seen)
    return Mesh(
        points=mirrored.points,
        cells=np.concatenate(cells),
        kind=mesh.kind,
        region_of_cell=np.concatenate(labels),
        regions=regions,
        faces={name: np.concatenate(parts) for name, parts in faces.items()},
    )


def reflected(nodes: Ints) -> Ints:
    """Return cells or triangles (n, 3 | 4 | 10) as seen in a mirror, so that none is inside out."""
    return nodes[:, _REFLECTED[nodes.shape[1]]]


def _turned(nodes: Ints, *, reflect: bool) -> Ints:
    return reflected(nodes) if reflect else nodes


def _seen(name: str, beyond: bool) -> str:
    return name.replace("top", "bottom") if beyond else name
