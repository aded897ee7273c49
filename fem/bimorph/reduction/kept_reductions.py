"""Reductions kept in the store, so that another support, finger or voltage factorises nothing."""

from __future__ import annotations

import numpy as np

from tactgen.fem.bimorph.reduction.krylov import ReducedSolid, reduce_to_ports
from tactgen.fem.bimorph.solid import assemble
from tactgen.fem.bimorph.system import materials
from tactgen.geometry.arrays import Floats
from tactgen.geometry.bimorph.brick_parts import BrickParts
from tactgen.geometry.bimorph.bricks import Bricks
from tactgen.geometry.device.parameters import Device
from tactgen.geometry.meshing.mesh import Mesh
from tactgen.geometry.store.store import kept
from tactgen.geometry.store.values import fingerprint

#: What makes a reduction.
_MADE_OF = ("tactgen.fem.bimorph.reduction.kept_reductions",)


def reduced_solid(
    device: Device, mesh: Mesh | Bricks | BrickParts, frequencies: Floats, *, tolerance: float
) -> ReducedSolid:
    """Return the lossy solid reduced to its ports, from the store if it was reduced before.

    One that was reduced for these frequency limits serves all frequencies between them, as
    far as its error estimate holds there too.
    """
    frequencies = np.atleast_1d(np.asarray(frequencies, dtype=float))
    bounds = float(frequencies.min()), float(frequencies.max())

    def serves(found: ReducedSolid) -> bool:
        # one that did not reach the tolerance would not reach it again
        return bool(found.error_estimate(frequencies).max() <= max(tolerance, found.error))

    return kept(
        "reduction",
        (made_from(device, mesh), bounds, tolerance),
        _MADE_OF,
        lambda: reduce_to_ports(
            assemble(device, mesh, lossy=True), frequencies, tolerance=tolerance
        ),
        serves=serves,
    )


def made_from(device: Device, mesh: Mesh | Bricks | BrickParts) -> str:
    """Return what stands for the solid: tensors, poling, all that is in the mesh."""
    return fingerprint(materials(device, mesh.regions, device.piezo.ceramic(), lossy=True), mesh)
