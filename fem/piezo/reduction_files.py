"""Reduced solids as files (npz): small matrices that answer for a mesh of any size."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np

from tactgen.fem.piezo.brick_error import MotionEstimator
from tactgen.fem.piezo.krylov import ReducedSolid, reduce_to_ports
from tactgen.fem.piezo.solid import assemble
from tactgen.fem.piezo.system import materials
from tactgen.geometry.arrays import Floats
from tactgen.geometry.bimorph.bricks import Bricks
from tactgen.geometry.device.parameters import Device
from tactgen.geometry.files import written_whole
from tactgen.geometry.meshing.mesh import Mesh
from tactgen.geometry.store.store import cached_result
from tactgen.geometry.store.values import fingerprint

#: What the entry `title` says.
TITLE = "piezoelectric solid reduced to its ports"
#: What the matrices mean, for who opens the file without this package.
_CONVENTIONS = (
    "SI; unknowns [q, w_base, psi_base, U]; (stiffness - Omega^2 mass) x = "
    "[q: 0, base force, base moment, -charge] + tip @ [tip force, tip moment]; "
    "tip.T @ x = [w_tip, psi_tip]; time factor exp(+j Omega t); losses in stiffness"
)
_MATRICES = ("stiffness", "mass", "tip")


def write_ports(path: str | Path, reduced: ReducedSolid, *, made_from: str) -> None:
    """Write a reduced solid, whole or not at all; `made_from` stands for device and mesh.

    Raises InputError if the file cannot be written.
    """
    arrays = {
        f"{level} {name}": getattr(getattr(reduced, level), name)
        for level in ("fine", "coarse")
        for name in _MATRICES
    }
    with written_whole(path) as temporary:
        np.savez_compressed(
            temporary,
            title=TITLE,
            conventions=_CONVENTIONS,
            made_from=made_from,
            range=reduced.range,
            error=reduced.error,
            unknowns=reduced.unknowns,
            **arrays,
        )


#: What makes a reduction.
_MADE_OF = ("tactgen.fem.piezo.reduction_files",)


def reduced_solid(
    device: Device,
    mesh: Mesh | Bricks,
    frequencies: Floats,
    *,
    tolerance: float,
    lacking: Callable[[], MotionEstimator] | None = None,
) -> ReducedSolid:
    """Lossy solid reduced to its ports, from the store if it was reduced before.

    One that was reduced for these frequency limits serves all frequencies between them, as
    far as its error estimate holds there too.  With what is `lacking` the reduction is judged by
    it, too.
    """
    frequencies = np.atleast_1d(np.asarray(frequencies, dtype=float))
    bounds = float(frequencies.min()), float(frequencies.max())

    def serves(found: ReducedSolid) -> bool:
        if lacking is not None and found.missing is None:
            return False
        # one that did not reach the tolerance would not reach it again
        return bool(found.error_estimate(frequencies).max() <= max(tolerance, found.error))

    def work() -> ReducedSolid:
        system = assemble(device, mesh, lossy=True)
        surplus = None if lacking is None else lacking()
        return reduce_to_ports(system, frequencies, tolerance=tolerance, surplus=surplus)

    inputs = (made_from(device, mesh), bounds, tolerance)
    return cached_result("reduction", inputs, _MADE_OF, work, serves=serves)


def made_from(device: Device, mesh: Mesh | Bricks) -> str:
    """Inputs that identify a solid: tensors, poling, mesh, and where its motion is measured."""
    known = materials(device, mesh.regions, device.piezo.ceramic(), lossy=True)
    place = [device.measurement.below_tip] if device.measurement.below_tip else []
    return fingerprint(known, mesh, *place)
