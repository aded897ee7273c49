"""Runs fTetWild on the arrays of one file and writes the result to another.

Its own process, since fTetWild can run for hours or take its process down with it.
Imports nothing of this project, so it runs from wherever the project lies.
"""

from __future__ import annotations

import json
import sys
from pathlib import Path

import numpy as np


def main(source: Path, target: Path) -> None:
    """Read ``points``, ``triangles``, settings and sizing; write ``points``, ``tets``."""
    from pytetwild.pytetwild import tetrahedralize

    with np.load(source) as given:
        arrays = {name: given[name] for name in given.files}
    settings = json.loads(str(arrays.pop("settings")))
    points, tets = tetrahedralize(
        arrays.pop("points"),
        arrays.pop("triangles").astype(np.int32),
        vtk_ordering=True,
        # the default drops thin regions and leaks outside; we crop and label ourselves
        disable_filtering=True,
        # more threads hardly help and make the result depend on their race
        num_threads=1,
        **settings,
        **arrays,
    )
    np.savez(target, points=points, tets=tets)


if __name__ == "__main__":
    main(Path(sys.argv[1]), Path(sys.argv[2]))
