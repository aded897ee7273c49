"""Public finite-element programs that solve the same job in the same run.

Each adapter is a module with ``run(job: Job) -> Answer``, called in a process of its own
with one thread.
"""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Sequence
from typing import cast

from tactgen.validation.evidence.bench_timing import on_one_core
from tactgen.validation.evidence.peers.job import Answer, Job

#: Name of each peer, the package it needs and the adapter.
PEERS = {
    "NGSolve": ("ngsolve", "tactgen.validation.evidence.peers.ngsolve"),
    "SfePy": ("sfepy", "tactgen.validation.evidence.peers.sfepy"),
}
#: Environment variable that names the Python with the peers, if that is another one.
PYTHON = "TACTGEN_PEERS"


def missing(peer: str) -> str:
    """Sentence if a peer is not installed, else nothing."""
    return not_installed(PEERS[peer][0])


def not_installed(package: str) -> str:
    """Sentence if the peers' Python lacks a package, else nothing."""
    look = f"import importlib.util as u, sys; sys.exit(u.find_spec({package!r}) is None)"
    try:
        done = subprocess.run([python(), "-c", look], capture_output=True, check=False)
    except OSError:
        return f"{PYTHON} = {python()} cannot be run; name the Python that has {package}"
    return f"{package} is not installed; run: pip install -e '.[peers]'" if done.returncode else ""


def solve(peer: str, job: Job, frequencies: Sequence[float] = ()) -> Answer:
    """Let a peer solve a job, or its sweep at the frequencies (Hz), alone in a process.

    Raises InputError if the peer's process ends badly, with the last line that it wrote.
    """
    asked = {**job, "frequencies": frequencies}
    return cast(Answer, on_one_core(PEERS[peer][1], "run", asked, python=python()))


def python() -> str:
    """Interpreter that runs the peers."""
    return os.environ.get(PYTHON, sys.executable)
