"""Every notebook runs as a script and its closing assertions hold.

Those that solve fields or runs in time are heavy here; ``make docs`` runs them all.
"""

import runpy
from pathlib import Path

import pytest

NOTEBOOKS = sorted((Path(__file__).parent.parent / "notebooks").glob("*.py"))
HEAVY = {"1_first_look", "5_reluctance_map", "6_machine_in_motion", "7_accuracy_and_cost"}


@pytest.mark.parametrize(
    "path",
    [pytest.param(p, marks=[pytest.mark.heavy] * (p.stem in HEAVY)) for p in NOTEBOOKS],
    ids=lambda p: p.stem,
)
def test_notebook(path):
    """Examples are tests."""
    runpy.run_path(str(path))


def test_there_are_notebooks():
    """An empty folder must not pass."""
    assert len(NOTEBOOKS) >= 3
    assert {p.stem for p in NOTEBOOKS} >= HEAVY
