"""A mesh and its image at a plane of symmetry."""

from dataclasses import replace

import numpy as np


def mirrored(mesh, axis):
    """Mesh and its image at the plane through the origin as one, outer faces kept."""
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
