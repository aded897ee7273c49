"""Finished meshes on disk, so that a study run twice runs on the same mesh.

The mesher has no seed: only a kept mesh makes results repeatable.  Never a reason to
fail: what cannot be read is meshed again, what cannot be written is not kept.
"""

from __future__ import annotations

import hashlib
import os
import zipfile
import zlib
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from geometry.errors import InputError
from geometry.files import written_whole
from geometry.meshing.mesh import Mesh

#: Prefix that tells the named faces from the other arrays of a file.
_FACE = "face "


def cache_folder() -> Path:
    """Return the folder of kept meshes: ``$TACTGEN_CACHE``, or ``~/.cache/tactgen``."""
    chosen = os.environ.get("TACTGEN_CACHE")
    return Path(chosen) if chosen else Path.home() / ".cache" / "tactgen"


def cache_key(*inputs: object) -> str:
    """Return a name that stands for exactly these inputs.

    The inputs are plain frozen values, whose ``repr`` shows all that is in them.
    """
    return hashlib.sha256(repr(inputs).encode()).hexdigest()[:32]


def stored_mesh(key: str) -> Mesh | None:
    """Return the mesh kept under `key`, or None if there is none that can be read."""
    path = cache_folder() / f"{key}.npz"
    try:
        # opened here, since numpy leaves a file open that it cannot read
        with path.open("rb") as stream, np.load(stream, allow_pickle=False) as data:
            return Mesh(
                points=data["points"],
                cells=data["cells"],
                kind=data["kind"].item(),
                region_of_cell=data["region_of_cell"],
                regions=tuple(data["regions"].tolist()),
                faces={
                    name.removeprefix(_FACE): data[name]
                    for name in data.files
                    if name.startswith(_FACE)
                },
            )
    except (OSError, ValueError, KeyError, EOFError, zipfile.BadZipFile, zlib.error):
        return None


def store_mesh(key: str, mesh: Mesh) -> None:
    """Keep a mesh under `key`, if the folder can be written."""
    folder = cache_folder()
    arrays: dict[str, NDArray[Any]] = {
        "points": mesh.points,
        "cells": mesh.cells,
        "kind": np.array(mesh.kind),
        "region_of_cell": mesh.region_of_cell,
        "regions": np.array(mesh.regions),
        **{_FACE + name: faces for name, faces in mesh.faces.items()},
    }
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with written_whole(folder / f"{key}.npz") as temporary:
            np.savez_compressed(temporary, allow_pickle=False, **arrays)
    except (OSError, InputError):
        return
