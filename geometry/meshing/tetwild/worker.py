"""Runs fTetWild on the arrays of one file after another and writes each result to another.

Its own process, since fTetWild can run for hours or take its process down with it.
Imports nothing of this project, so it runs from wherever the project lies.  Three lines on its
input name a file to read, one to write and the processor time (s) that this may take; one line
on its output says what it took.
"""

from __future__ import annotations

import json
import math
import os
import sys
import time
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


def allow(seconds: float) -> None:
    """Let the system end this process by SIGXCPU after so much more of the processor's time.

    What the clock on the wall says depends on who else is at work; this does not.
    """
    try:
        import resource
    except ImportError:  # Windows has no such limit
        return
    _, most = resource.getrlimit(resource.RLIMIT_CPU)
    wanted = math.ceil(time.process_time() + seconds)
    allowed = wanted if most == resource.RLIM_INFINITY else min(wanted, most)
    resource.setrlimit(resource.RLIMIT_CPU, (allowed, most))


def main() -> None:
    """Mesh the files named on standard input until it ends."""
    # what fTetWild itself prints must not look like an answer
    answers = os.fdopen(os.dup(1), "w")
    os.dup2(2, 1)
    while source := sys.stdin.readline().rstrip("\n"):
        target, seconds = (sys.stdin.readline().rstrip("\n") for _ in range(2))
        began = time.process_time()
        allow(float(seconds))
        mesh(Path(source), Path(target))
        print(time.process_time() - began, file=answers, flush=True)


if __name__ == "__main__":
    main()
