"""Every notebook runs as a script and its closing assertions hold."""

import runpy
from pathlib import Path

import pytest

NOTEBOOKS = sorted((Path(__file__).parent.parent / "notebooks").glob("*.py"))


@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda p: p.stem)
def test_notebook(path):
    """Examples are tests."""
    runpy.run_path(str(path))


def test_there_are_notebooks():
    """An empty folder must not pass."""
    assert len(NOTEBOOKS) >= 3
