"""Reductions kept in the store, so that another support, finger or voltage factorises nothing."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from tactgen.fem.bimorph.reduction.krylov import ReducedSolid, reduce_to_ports
from tactgen.fem.bimorph.solid import assemble
from tactgen.fem.bimorph.system import SolidSystem, Surplus, materials
from tactgen.geometry.arrays import Floats
from tactgen.geometry.bimorph.bimorph_bricks import BrickParts
from tactgen.geometry.bimorph.bricks import Bricks
from tactgen.geometry.device.parameters import Device
from tactgen.geometry.meshing.mesh import Mesh
from tactgen.geometry.store.store import kept
from tactgen.geometry.store.values import fingerprint

#: What makes a reduction.
_MADE_OF = (
    "tactgen.fem.bimorph.reduction.kept_reductions",
    "tactgen.fem.bimorph.error_estimate.brick_surplus",
)


def reduced_solid(
    device: Device,
    mesh: Mesh | Bricks | BrickParts,
    frequencies: Floats,
    *,
    tolerance: float,
    lossless: SolidSystem | None = None,
    lacking: Callable[[], Surplus] | None = None,
) -> ReducedSolid:
    """Return the lossy solid reduced to its ports, from the store if it was reduced before.

    One that was reduced for these frequency limits serves all frequencies between them, as
    far as its error estimate holds there too.  Who has the `lossless` system already may save
    assembling anew what losses do not change.  With what is `lacking` the reduction
    is judged by it, too.
    """
    frequencies = np.atleast_1d(np.asarray(frequencies, dtype=float))
    bounds = float(frequencies.min()), float(frequencies.max())

    def serves(found: ReducedSolid) -> bool:
        if lacking is not None and found.missing is None:
            return False
        # one that did not reach the tolerance would not reach it again
        return bool(found.error_estimate(frequencies).max() <= max(tolerance, found.error))

    def work() -> ReducedSolid:
        if lossless is not None and lossless.with_losses is not None:
            system = lossless.with_losses()
        else:
            system = assemble(device, mesh, lossy=True)
        surplus = None if lacking is None else lacking()
        return reduce_to_ports(system, frequencies, tolerance=tolerance, surplus=surplus)

    inputs = (made_from(device, mesh), bounds, tolerance)
    return kept("reduction", inputs, _MADE_OF, work, serves=serves)


def made_from(device: Device, mesh: Mesh | Bricks | BrickParts) -> str:
    """Return what stands for the solid: tensors, poling, all that is in the mesh."""
    return fingerprint(materials(device, mesh.regions, device.piezo.ceramic(), lossy=True), mesh)
