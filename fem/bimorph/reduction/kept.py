"""Reductions kept on disk, so that another support, finger or voltage factorises nothing.

Never a reason to fail: what cannot be read is reduced again, what cannot be written is not
kept.
"""

from __future__ import annotations

import hashlib
from collections.abc import Iterator
from dataclasses import fields, is_dataclass
from functools import cache
from pathlib import Path

import numpy as np

from fem.bimorph.reduction.files import read_ports, write_ports
from fem.bimorph.reduction.krylov import ReducedSolid, reduce_to_ports
from fem.bimorph.system import materials
from geometry.arrays import Floats
from geometry.bimorph.bricks import Bricks
from geometry.device.parameters import Device
from geometry.errors import InputError
from geometry.meshing.mesh import Mesh
from geometry.meshing.mesh_cache import cache_folder, cache_key


def reduced_solid(
    device: Device, mesh: Mesh | Bricks, frequencies: Floats, *, tolerance: float
) -> ReducedSolid:
    """Return the lossy solid reduced to its ports, from the cache if it was reduced before.

    One that was reduced for these frequency limits serves all frequencies between them, as
    far as its error estimate holds there too.
    """
    frequencies = np.atleast_1d(np.asarray(frequencies, dtype=float))
    bounds = float(frequencies.min()), float(frequencies.max())
    stamp = made_from(device, mesh)
    path = cache_folder() / f"ports-{cache_key(stamp, bounds, tolerance)}.npz"
    try:
        kept = read_ports(path, made_from=stamp)
        # one that did not reach the tolerance would not reach it again
        reached = max(tolerance, kept.error)
        if kept.range == bounds and kept.error_estimate(frequencies).max() <= reached:
            return kept
    except InputError:
        pass
    from fem.bimorph.solid import assemble

    reduced = reduce_to_ports(assemble(device, mesh, lossy=True), frequencies, tolerance=tolerance)
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        write_ports(path, reduced, made_from=stamp)
    except (OSError, InputError):
        pass
    return reduced


def made_from(device: Device, mesh: Mesh | Bricks) -> str:
    """Return what stands for the solid: tensors, poling, all that is in the mesh, the program."""
    digest = hashlib.sha256(_program().encode())
    tensors = materials(device, mesh.regions, device.piezo.ceramic(), lossy=True)
    for part in _content((tensors, mesh)):
        digest.update(part)
    return digest.hexdigest()[:32]


@cache
def _program() -> str:
    """Return what stands for the code: numbers of another version are never served."""
    digest = hashlib.sha256()
    for module in ("fem", "geometry"):
        for file in sorted((Path(__file__).parents[3] / module).rglob("*.py")):
            digest.update(file.read_bytes())
    return digest.hexdigest()


def _content(value: object) -> Iterator[bytes]:
    """Yield all that is in a value of dataclasses, tuples, dicts and arrays."""
    if isinstance(value, np.ndarray):
        yield repr((value.dtype.str, value.shape)).encode()
        yield np.ascontiguousarray(value).tobytes()
    elif is_dataclass(value):
        yield type(value).__name__.encode()
        for field in fields(value):
            yield field.name.encode()
            yield from _content(getattr(value, field.name))
    elif isinstance(value, tuple | list):
        yield b"("
        for item in value:
            yield from _content(item)
        yield b")"
    elif isinstance(value, dict):
        yield from _content(sorted(value.items()))
    else:
        yield repr(value).encode()
