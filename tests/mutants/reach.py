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
from collections import defaultdict
from collections.abc import Iterable
from pathlib import Path

PACKAGES = ("geometry", "tmm", "fem", "validation")
#: Tests may start commands in an environment of their own, in which nothing is noted.
_NOTEBOOK = """
try:
    from reach import SEEN as _reached
except ImportError:
    _reached = set()
"""
#: Functions entered since the last test began.
SEEN: set[str] = set()


def instrument(root: Path) -> None:
    """Rewrite every source file below `root` so that each outermost function says when it runs."""
    for package in PACKAGES:
        for path in sorted((root / package).rglob("*.py")):
            tree = ast.parse(path.read_text(encoding="utf-8"))
            if _note(tree, f"{path.relative_to(root).as_posix()}::"):
                at = _after_the_first_lines(tree)
                tree.body.insert(at, ast.parse(_NOTEBOOK).body[0])
                path.write_text(ast.unparse(tree), encoding="utf-8")


def _note(node: ast.AST, place: str) -> bool:
    """Put the note into every outermost function below; whether there is one.

    `place` is the file and the classes around: ``file::Class.``.
    """
    any_found = False
    for child in ast.iter_child_nodes(node):
        if isinstance(child, ast.FunctionDef):
            at = 1 if ast.get_docstring(child) is not None else 0
            child.body.insert(at, ast.parse(f"_reached.add({place + child.name!r})").body[0])
            any_found = True
        else:
            inner = f"{place}{child.name}." if isinstance(child, ast.ClassDef) else place
            any_found |= _note(child, inner)
    return any_found


def _after_the_first_lines(tree: ast.Module) -> int:
    at = 1 if ast.get_docstring(tree) is not None else 0
    while isinstance(tree.body[at], ast.ImportFrom) and tree.body[at].module == "__future__":
        at += 1
    return at


def gathered(lines: Iterable[str], known: dict | None = None) -> dict:
    """Return seconds by test, and by function the tests that enter it and those of its fixtures.

    What was noted before of other tests is kept (`known`).
    """
    noted = [json.loads(line) for line in lines]
    anew = {line["test"] for line in noted}
    found = {"seconds": {}, "entered": {}, "fixtures": {}} if known is None else known
    seconds = defaultdict(float, {t: s for t, s in found["seconds"].items() if t not in anew})
    entered = {
        by: defaultdict(set, {f: set(tests) - anew for f, tests in found[by].items()})
        for by in ("entered", "fixtures")
    }
    for line in noted:
        seconds[line["test"]] += line["seconds"]
        within = entered["entered" if line["when"] == "call" else "fixtures"]
        for function in line["entered"]:
            within[function].add(line["test"])
    return {
        "seconds": {test: round(s, 3) for test, s in seconds.items()},
        **{by: {f: sorted(tests) for f, tests in kept.items()} for by, kept in entered.items()},
    }


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
        whole = Path(os.environ["TACTGEN_REACH"]) / name
        part = whole.with_suffix(".part")  # left behind where the command is killed meanwhile
        part.write_text(json.dumps(line) + "\n")
        part.replace(whole)


atexit.register(_write_at_exit)
