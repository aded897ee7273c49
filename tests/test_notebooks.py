"""Every notebook runs as a script and its closing assertions hold.

Those whose fields or runs in time take long are heavy here, and by default only what they use must
be there; ``make docs`` runs them all.
"""

import ast
import importlib
import runpy
from pathlib import Path

import pytest

NOTEBOOKS = sorted((Path(__file__).parent.parent / "notebooks").glob("*.py"))
HEAVY = {
    "1_first_look", "4_what_the_rod_does", "5_reluctance_map", "6_machine_in_motion",
    "7_accuracy_and_cost", "beam_to_solid", "chain_bimorph", "chain_reluctance", "own_device",
}  # fmt: skip


@pytest.mark.parametrize(
    "path",
    [pytest.param(p, marks=[pytest.mark.heavy] * (p.stem in HEAVY)) for p in NOTEBOOKS],
    ids=lambda p: p.stem,
)
def test_notebook(path):
    """Examples are tests."""
    runpy.run_path(str(path))


@pytest.mark.parametrize("name", sorted(HEAVY))
def test_what_a_heavy_notebook_uses_is_there(name):
    """Each thing that it imports, and each that it takes from the package itself."""
    text = next(p for p in NOTEBOOKS if p.stem == name).read_text(encoding="utf-8")
    wanted = []
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, ast.ImportFrom):
            wanted += [(node.module, alias.name) for alias in node.names]
        elif isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name):
            wanted += [("tactgen", node.attr)] * (node.value.id == "tactgen")
    assert wanted
    for module, attribute in wanted:
        if not hasattr(importlib.import_module(module), attribute):
            importlib.import_module(f"{module}.{attribute}")


def test_there_are_notebooks():
    """An empty folder must not pass."""
    assert len(NOTEBOOKS) >= 3
    assert {p.stem for p in NOTEBOOKS} >= HEAVY
