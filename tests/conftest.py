"""Shared by all tests: a fixed hypothesis profile, a store of their own, a reference solution."""

import json
import os
from pathlib import Path

import pytest
from hypothesis import settings

settings.register_profile(
    "fixed", derandomize=True, database=None, deadline=None, max_examples=30, print_blob=False
)
settings.load_profile("fixed")


@pytest.fixture(scope="session", autouse=True)
def shared_store(tmp_path_factory):
    """Give the run a store of its own: what one test solved, the others read; nothing older."""
    base = tmp_path_factory.getbasetemp()
    if "PYTEST_XDIST_WORKER" in os.environ:  # the workers' folders are side by side in one
        base = base.parent
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("TACTGEN_CACHE", str(base / "store"))
        yield


@pytest.fixture
def own_store(tmp_path, monkeypatch):
    """Give one test a store of its own, since it changes code or counts what is computed."""
    monkeypatch.setenv("TACTGEN_CACHE", str(tmp_path / "own store"))
    return tmp_path / "own store"


@pytest.fixture(scope="session")
def state_space():
    """Return the stored 60-digit state-space solution of the paper's bimorph."""
    path = Path(__file__).parent / "data" / "bimorph_state_space.json"
    return json.loads(path.read_text(encoding="utf-8"))
