"""Runs fTetWild on the arrays of one file after another and writes each result to another.

Its own process, since fTetWild can run for hours or take its process down with it.
Imports nothing of this project, so it runs from wherever the project lies.  Two lines on its
input name a file to read and one to write; one line on its output says that it is written.
"""

from __future__ import annotations

import json
import os
import sys
from pathlib import Path

import numpy as np
from pytetwild.pytetwild import tetrahedralize


def mesh(source: Path, target: Path) -> None:
    """Read ``points``, ``triangles``, settings and sizing; write ``points``, ``tets``."""
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


def main() -> None:
    """Mesh what the input names until it ends."""
    # what fTetWild itself prints must not look like an answer
    answers = os.fdopen(os.dup(1), "w")
    os.dup2(2, 1)
    while source := sys.stdin.readline().rstrip("\n"):
        mesh(Path(source), Path(sys.stdin.readline().rstrip("\n")))
        print("done", file=answers, flush=True)


if __name__ == "__main__":
    main()
