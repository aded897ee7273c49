"""Shared by all tests: a fixed hypothesis profile and the stored reference solution."""

import json
from pathlib import Path

import pytest
from hypothesis import settings

settings.register_profile(
    "fixed", derandomize=True, database=None, deadline=None, max_examples=30, print_blob=False
)
settings.load_profile("fixed")


@pytest.fixture(scope="session")
def state_space():
    """Return the stored 60-digit state-space solution of the paper's bimorph."""
    path = Path(__file__).parent / "data" / "bimorph_state_space.json"
    return json.loads(path.read_text(encoding="utf-8"))
