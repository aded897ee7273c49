"""Which test enters which function: a copy of the packages that notes it, and what was noted.

Every function of the copy says its number when it is entered; the plugin writes, for each test,
which were since the last, and the processor time it took.  Commands that a test starts write
their own when they end, under the test's name.
"""

import ast
import atexit
import json
import os
import time
from pathlib import Path

PACKAGES = ("geometry", "tmm", "fem", "validation")
#: Tests may start commands in an environment of their own, in which nothing is noted.
_NOTEBOOK = """
try:
    from reach import SEEN as _seen
except ImportError:
    _seen = set()
"""
#: Functions entered since the last test began.
SEEN: set[str] = set()


def instrument(root: Path) -> None:
    """Rewrite every source file below `root` so that each outermost function says when it runs."""
    for package in PACKAGES:
        for path in sorted((root / package).rglob("*.py")):
            tree = ast.parse(path.read_text(encoding="utf-8"))
            if _note(tree, str(path.relative_to(root))):
                at = _after_the_first_lines(tree)
                tree.body.insert(at, ast.parse(_NOTEBOOK).body[0])
                path.write_text(ast.unparse(tree), encoding="utf-8")


def _note(node: ast.AST, file: str) -> bool:
    """Put the note into every outermost function below; whether there is one."""
    any_found = False
    for child in ast.iter_child_nodes(node):
        if isinstance(child, ast.FunctionDef):
            at = 1 if ast.get_docstring(child) is not None else 0
            said = f"{file}::{child.name}:{child.lineno}"
            child.body.insert(at, ast.parse(f"_seen.add({said!r})").body[0])
            any_found = True
        else:
            any_found |= _note(child, file)
    return any_found


def _after_the_first_lines(tree: ast.Module) -> int:
    at = 1 if ast.get_docstring(tree) is not None else 0
    while isinstance(tree.body[at], ast.ImportFrom) and tree.body[at].module == "__future__":
        at += 1
    return at


def _spent() -> float:
    return sum(os.times()[:4])


class _Recorder:
    """The plugin: one line of JSON for each phase of each test."""

    def __init__(self, folder: Path) -> None:
        self.file = (folder / f"{os.getpid()}.jsonl").open("a", encoding="utf-8")
        self.begun = _spent()

    def pytest_runtest_logreport(self, report) -> None:
        now = _spent()
        line = {
            "test": report.nodeid, "when": report.when, "outcome": report.outcome,
            "seconds": round(now - self.begun, 3), "entered": sorted(SEEN),
        }  # fmt: skip
        self.file.write(json.dumps(line) + "\n")
        self.file.flush()
        SEEN.clear()
        self.begun = now


def pytest_configure(config) -> None:
    """Record when this module is loaded as a plugin (`-p reach`)."""
    config.pluginmanager.register(_Recorder(Path(os.environ["TACTGEN_REACH"])))


def _write_at_exit() -> None:
    test = os.environ.get("PYTEST_CURRENT_TEST", "")
    if SEEN and test and "TACTGEN_REACH" in os.environ:
        name = f"{os.getpid()}-{time.time_ns()}.jsonl"
        line = {
            "test": test.rpartition(" (")[0], "when": "call", "outcome": "command",
            "seconds": 0.0, "entered": sorted(SEEN),
        }  # fmt: skip
        (Path(os.environ["TACTGEN_REACH"]) / name).write_text(json.dumps(line) + "\n")


atexit.register(_write_at_exit)
