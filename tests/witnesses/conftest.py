"""Public programs, each in a process of its own, where they are installed."""

from pathlib import Path

import pytest

from tactgen.validation.evidence import peers
from tactgen.validation.evidence.bench_timing import on_one_core


@pytest.fixture
def witness(monkeypatch):
    """Return what runs the adapter of a package, a module beside this file, on a job."""
    monkeypatch.setenv("PYTHONPATH", str(Path(__file__).parent))

    def run(package, adapter, job):
        if why := peers.not_installed(package):
            pytest.skip(why)
        return on_one_core(adapter, "run", job, python=peers.python())

    return run
