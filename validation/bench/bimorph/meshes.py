"""Meshes of the benchmark's bimorph: our own families."""

from __future__ import annotations

import numpy as np

from tactgen.geometry.arrays import Ints
from tactgen.geometry.bimorph.bimorph_bricks import LEVELS, BrickMeshing, bimorph_bricks
from tactgen.geometry.bimorph.bricks import Bricks
from tactgen.geometry.bimorph.tets import TetMeshing, tetrahedralise
from tactgen.geometry.device.parameters import Device
from tactgen.geometry.meshing.mesh import Mesh
from tactgen.validation.bench.bimorph.peers.grid import LAYERS, bricks
from tactgen.validation.bench.bimorph.peers.job import Job

#: Six tetrahedra of a brick, all around its diagonal from corner 0 to corner 6.
_TETS = [[0, 1, 2, 6], [0, 2, 3, 6], [0, 3, 7, 6], [0, 7, 4, 6], [0, 4, 5, 6], [0, 5, 1, 6]]


def high_order(device: Device, level: int) -> Bricks:
    """Return the bricks of high order of a level of the solid model's own family."""
    return bimorph_bricks(device, LEVELS[level])


def second_order(
    device: Device, through: int, side: float, smallest: float, longest: float
) -> Bricks:
    """Return bricks of degree 2, which are hexahedra of 27 nodes, on the quarter.

    `through` a ceramic layer; `side`, `smallest` and `longest` as of a BrickMeshing.
    """
    layers = (1.0 / through,) * through
    meshing = BrickMeshing(
        (2, 2, 2), layers, side=side, smallest=smallest, tip=smallest, longest=longest,
        pieces=(10.0, 1e3), growth=3.0,
    )  # fmt: skip
    return bimorph_bricks(device, meshing)


def scout(device: Device) -> Bricks:
    """Return so few bricks that asking them which modes are the lowest costs next to nothing.

    Two along the length, of degree 5: two percent off, where its modes lie tens apart.
    """
    whole = 1e3  # so long at both ends that nothing is left between them
    return bimorph_bricks(device, BrickMeshing((2, 2, 5), smallest=whole, tip=whole))


def hexahedra(job: Job) -> Mesh:
    """Return the job's grid of bricks as hexahedra."""
    grid = bricks(job)
    faces: dict[str, list[Ints]] = {}
    for face in grid.faces():
        if face.name != "side" and face.quads.size:
            name = face.name
            if name in ("outer", "inner"):
                name = f"electrode_{LAYERS[face.layer].removeprefix('piezo_')}_{name}"
            faces.setdefault(name, []).append(face.quads)
    return Mesh(
        points=grid.points,
        cells=grid.cells,
        kind="hexahedron",
        region_of_cell=grid.layer,
        regions=LAYERS,
        faces={name: np.concatenate(parts) for name, parts in faces.items()},
    )


def structured_tetrahedra(job: Job) -> Mesh:
    """Return the job's grid with every brick cut into six tetrahedra."""
    mesh = hexahedra(job)
    return Mesh(
        points=mesh.points,
        cells=mesh.cells[:, _TETS].reshape(-1, 4),
        kind="tetra",
        region_of_cell=np.repeat(mesh.region_of_cell, len(_TETS)),
        regions=mesh.regions,
        faces={name: _triangles(quads) for name, quads in mesh.faces.items()},
    )


def _triangles(quads: Ints) -> Ints:
    """Cut quadrilaterals as the tetrahedra do: along lowest to highest corner."""
    start = np.argmin(quads, axis=1)
    a, b, c, d = (quads[np.arange(len(quads)), (start + turn) % 4] for turn in range(4))
    return np.concatenate([np.stack([a, b, c], axis=1), np.stack([a, c, d], axis=1)])


def free_tetrahedra(device: Device, root: float, far: float) -> Mesh:
    """Return the tetwild mesh with edges of `root` at the clamp and `far` elsewhere (m)."""
    options = TetMeshing(edge_length=far, root_edge_length=root)
    return tetrahedralise(device, "alone", LAYERS, options)
