"""Which test enters which function: a copy of the packages that notes it, and what was noted.

Every function of the copy says its number when it is entered; the plugin writes, for each test,
which were since the last, and the processor time it took.  Who is given what was made before, by
a fixture, a cache, the store or when its file was read, counts as having entered all that made it.
Commands that a test starts write their own when they end, under the test's name.
"""

import ast
import atexit
import functools
import json
import os
import time
from collections import defaultdict
from collections.abc import Callable, Hashable, Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

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
#: Functions entered while something was made that is kept for others.
_MADE: dict[Hashable, set[str]] = defaultdict(set)


@contextmanager
def making(key: Hashable) -> Iterator[None]:
    """Note what is entered while something is made or found: who finds it, enters that too."""
    before = set(SEEN)
    SEEN.clear()
    try:
        yield
    finally:
        _MADE[key] |= SEEN
        SEEN.update(_MADE[key], before)


class NotedProperty(functools.cached_property):
    """A cached property that also says what made it when it is only looked up."""

    def __get__(self, instance, owner=None):
        if instance is None:
            return self
        with making((id(instance), self.attrname)):
            return super().__get__(instance, owner)

    def __set__(self, instance, value) -> None:
        instance.__dict__[self.attrname] = value

    def __delete__(self, instance) -> None:
        del instance.__dict__[self.attrname]


def see_through_caches() -> None:
    """Let every cache of functions, and the store, say what made that which they give."""
    functools.cached_property, plain = NotedProperty, functools._lru_cache_wrapper

    def wrapper(function: Callable, *how) -> Callable:
        cached = plain(function, *how)

        def call(*args, **named):
            with making((id(cached), args, tuple(named.items()))):
                return cached(*args, **named)

        call.cache_info, call.cache_clear = cached.cache_info, cached.cache_clear
        return call if function.__module__.startswith("tactgen.") else cached

    functools._lru_cache_wrapper = wrapper
    from tactgen.geometry.store import store

    def seen(function: Callable) -> Callable:
        def call(kind, inputs, made_of, *args, **named):
            with making(store._place(kind, inputs, made_of)):
                return function(kind, inputs, made_of, *args, **named)

        return call

    store.kept, store.recalled = seen(store.kept), seen(store.recalled)


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
    """Return seconds by test, and by function the tests that enter it.

    What was noted before of other tests is kept (`known`).
    """
    noted = [json.loads(line) for line in lines]
    anew = {line["test"] for line in noted}
    found = {"seconds": {}, "entered": {}} if known is None else known
    seconds = defaultdict(float, {t: s for t, s in found["seconds"].items() if t not in anew})
    entered = defaultdict(set, {f: set(tests) - anew for f, tests in found["entered"].items()})
    for line in noted:
        seconds[line["test"]] += line["seconds"]
        for function in line["entered"]:
            entered[function].add(line["test"])
    return {
        "seconds": {test: round(s, 3) for test, s in seconds.items()},
        "entered": {function: sorted(tests) for function, tests in entered.items()},
    }


def _spent() -> float:
    return sum(os.times()[:4])


class _Recorder:
    """The plugin: one line of JSON for each phase of each test."""

    def __init__(self, folder: Path) -> None:
        self.file = (folder / f"{os.getpid()}.jsonl").open("a", encoding="utf-8")
        self.begun = _spent()
        self.collected: dict[str, set[str]] = {}

    @pytest.hookimpl(wrapper=True)
    def pytest_make_collect_report(self, collector):
        SEEN.clear()
        report = yield
        self.collected[collector.nodeid] = set(SEEN)
        SEEN.clear()
        return report

    @pytest.hookimpl(wrapper=True)
    def pytest_fixture_setup(self, fixturedef):
        with making(id(fixturedef)):
            return (yield)

    def pytest_runtest_call(self, item) -> None:
        SEEN.update(self.collected[item.nodeid.split("::")[0]])
        for fixtures in item._fixtureinfo.name2fixturedefs.values():
            SEEN.update(_MADE[id(fixtures[-1])])

    def pytest_runtest_logreport(self, report) -> None:
        now = _spent()
        line = {
            "test": report.nodeid, "seconds": round(now - self.begun, 3), "entered": sorted(SEEN),
        }  # fmt: skip
        self.file.write(json.dumps(line) + "\n")
        self.file.flush()
        SEEN.clear()
        self.begun = now


def pytest_configure(config) -> None:
    """Record when this module is loaded as a plugin (`-p reach`)."""
    see_through_caches()
    config.pluginmanager.register(_Recorder(Path(os.environ["TACTGEN_REACH"])))


def _write_at_exit() -> None:
    test = os.environ.get("PYTEST_CURRENT_TEST", "")
    if SEEN and test and "TACTGEN_REACH" in os.environ:
        name = f"{os.getpid()}-{time.time_ns()}.jsonl"
        line = {
            "test": test.rpartition(" (")[0], "seconds": 0.0, "entered": sorted(SEEN),
        }  # fmt: skip
        whole = Path(os.environ["TACTGEN_REACH"]) / name
        part = whole.with_suffix(".part")  # left behind where the command is killed meanwhile
        part.write_text(json.dumps(line) + "\n")
        part.replace(whole)


atexit.register(_write_at_exit)
