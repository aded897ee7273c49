"""The mutation run: what it puts in, which tests it chooses, what it says of a run."""

import importlib
import json
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

SOURCE = '''"""A docstring with 2.0 in it."""

LIMIT: float = 0.5
ORDER = ("first", "second", "third")
Place = Literal["first", "second", "third"]
COLOURS: dict[str, tuple] = {"first": (0.1, 0.2, 0.3)}


def answer(a, b, k):
    """Return 3.0 of them."""
    if a < LIMIT:
        raise ValueError(f"{a + 1} is below")
    c = -a * b + k[0, 1]
    write_text(a, b)
    panels(4.0, 3.0)
    return max(c, 2) if not k else plot(a, b, figsize=(4, 3), stderr=True)


__all__ = ["LIMIT", "ORDER", "answer"]
'''


HERE = Path(__file__).parent


@pytest.fixture
def tool(monkeypatch):
    """Return what imports a module from beside this file, which is in no package."""
    monkeypatch.syspath_prepend(HERE)
    before = set(sys.modules)
    yield importlib.import_module
    for name in set(sys.modules) - before:
        if Path(getattr(sys.modules[name], "__file__", None) or "/").parent == HERE:
            del sys.modules[name]


def test_every_kind_once_and_no_word_of_what_is_said(tool, tmp_path):
    """Numbers of docstrings, messages, annotations and looks stay; each file is still Python."""
    mistakes = tool("mistakes")
    (tmp_path / "a.py").write_text(SOURCE, encoding="utf-8")
    found = mistakes.mistakes_in(tmp_path, "a.py")
    assert {(m.line, m.kind, m.before, m.after) for m in found} >= {
        (3, "number x3", "0.5", "1.5"),
        (4, "key", '"first", ', ""),
        (11, "comparison", " < ", " >= "),
        (11, "refusal", "a < LIMIT", "False"),
        (13, "sign", "-a", "a"),
        (13, "operator", "-a * b + k[0, 1]", "(-a * b) - (k[0, 1])"),
        (13, "term", "-a * b + k[0, 1]", "(-a * b)"),
        (13, "index", "0, 1", "1, 0"),
        (14, "write", "write_text(a, b)", "(a).write_text(b)"),
        (14, "index", "a, b", "b, a"),
        (14, "statement", "write_text(a, b)", "pass"),
        (16, "operator", "max", "min"),
        (16, "integer", "2", "3"),
        (16, "stream", "True", "not True"),
    }
    lines = {m.line for m in found if m.kind.startswith(("number", "integer"))}
    assert lines == {3, 13, 16}  # not 1, 6, 10, 12, 15
    assert not [m for m in found if m.before in ("4", "(4, 3)") or m.line == 5 or m.line > 16]
    source = SOURCE.encode()
    assert all(mistakes.is_python(m.put(source)) for m in found)
    assert {m.function for m in found} == {"", "answer"}


def test_a_method_is_named_after_its_class_and_both_tools_agree(tool, tmp_path):
    """Where a mistake stands is what the noting copy says when it is entered."""
    source = (
        "class A:\n    def f(self):\n        def g():\n            return 1\n        return g\n"
    )
    (tmp_path / "fem").mkdir()
    (tmp_path / "fem/a.py").write_text(source, encoding="utf-8")
    (found,) = tool("mistakes").mistakes_in(tmp_path, "fem/a.py")
    tool("reach").instrument(tmp_path)
    assert found.function == "A.f"
    assert "_reached.add('fem/a.py::A.f')" in (tmp_path / "fem/a.py").read_text("utf-8")


def _line(test, entered, seconds=0.1):
    return json.dumps({"test": test, "seconds": seconds, "entered": entered})


def test_tests_noted_anew_replace_what_was_noted_of_them_alone(tool):
    """Seconds of the phases add up; another test's notes stay."""
    gathered = tool("reach").gathered
    known = gathered([_line("t::a", ["f"]), _line("t::b", ["f"])])
    lines = [_line("t::a", ["g"], 0.5), _line("t::a", ["h"])]
    assert gathered(lines, known) == {
        "seconds": {"t::b": 0.1, "t::a": 0.6},
        "entered": {"f": ["t::b"], "g": ["t::a"], "h": ["t::a"]},
    }


NOTED = """
import pytest
from tactgen.fem.a import A, f
from tactgen.geometry.store.store import kept

@pytest.fixture(scope="module")
def made():
    return A()

READ = A.k()

def stored():
    return kept("number", (1.0,), ("tactgen.fem.a",), lambda: f(2))

def test_first(made):
    assert (f(1), made.g, stored()) == (1, 1, 2)

def test_second(made):
    assert (f(1), made.g) == (1, 1)

def test_third():
    assert stored() == 2
"""
MADE = """
from functools import cache, cached_property

class A:
    def __init__(self):
        pass
    @cached_property
    def g(self):
        return 1
    @staticmethod
    def k():
        return 3

@cache
def f(x):
    return h(x)

def h(x):
    return x
"""


def test_who_is_given_what_was_made_before_has_entered_what_made_it(tmp_path):
    """By a fixture of the module, a cache, a property, the store, or when its file was read."""
    packages = HERE.parent.parent
    copy = tmp_path / "copy"
    for name in (".setup", "geometry"):
        shutil.copytree(packages / name, copy / name, symlinks=True)
    (copy / "fem").mkdir()
    (copy / "fem/__init__.py").touch()
    (copy / "fem/a.py").write_text(MADE, encoding="utf-8")
    (copy / "tests").mkdir()
    (copy / "tests/test_a.py").write_text(NOTED, encoding="utf-8")
    code = (
        "import argparse, json, run\nfrom pathlib import Path\n"
        f"copy = Path({str(copy)!r})\n"
        "run._reach(argparse.Namespace(tests=['tests'], out=copy / 'reach.json'), copy)\n"
    )
    subprocess.run([sys.executable, "-c", code], cwd=HERE, capture_output=True, check=True)
    entered = json.loads((copy / "reach.json").read_text())["entered"]
    first, second, third = (f"tests/test_a.py::test_{n}" for n in ("first", "second", "third"))
    assert entered["fem/a.py::A.__init__"] == entered["fem/a.py::A.g"] == [first, second]
    assert entered["fem/a.py::h"] == entered["fem/a.py::A.k"] == [first, second, third]


def test_cheap_tests_of_its_own_room_come_first_and_slow_ones_are_left_out(tool, tmp_path):
    """Then the tests of other rooms, those that read the sources last."""
    seconds = {"tests/fem/t.py::slow": 5.0, "tests/fem/t.py::a": 0.2, "tests/fem/t.py::b": 0.1,
               "tests/tmm/t.py::c": 1.0, "tests/tmm/t.py::never": 30.0,
               "tests/test_house.py::d": 0.1, "tests/x.py::e": 0.1}  # fmt: skip
    direct = [t for t in seconds if t.startswith(("tests/fem", "tests/tmm"))]
    known = {"seconds": seconds, "entered": {"fem/a.py::f": direct}}
    (tmp_path / "fem/b").mkdir(parents=True)
    for file in ("a.py", "b/c.py"):
        (tmp_path / "fem" / file).write_text("def f(): ...\n", encoding="utf-8")
    chooser = tool("choice").Chooser(tmp_path, known)
    mistake = tool("mistakes").Mistake("fem/a.py", 1, "sign", "f", 0, 1, "-", "")
    near, others = chooser.turns(mistake)
    assert near == ["tests/fem/t.py::b", "tests/fem/t.py::a"]
    assert others == ["tests/tmm/t.py::c", "tests/fem/t.py::slow", "tests/test_house.py::d"]
    unseen = tool("mistakes").Mistake("fem/b/c.py", 1, "sign", "f", 0, 1, "-", "")
    assert chooser.turns(unseen)[0] == ["tests/fem/t.py::b", "tests/fem/t.py::a"]


def test_what_runs_on_import_is_asked_of_all_that_use_the_file(tool, tmp_path):
    """No test enters it; a test that reads the table made by it does not enter the file at all."""
    source = "def f():\n    return -1\ndef g():\n    return f()\nTABLE = g()\ndef h(): ...\n"
    (tmp_path / "fem").mkdir()
    (tmp_path / "fem/a.py").write_text(source, encoding="utf-8")
    (tmp_path / "tests").mkdir()
    (tmp_path / "tests/t.py").write_text("from tactgen.fem.a import TABLE\n", encoding="utf-8")
    known = {"seconds": {"tests/t.py::a": 0.1, "tests/u.py::b": 0.1}, "entered": {}}
    chooser = tool("choice").Chooser(tmp_path, known)
    mistake = tool("mistakes").Mistake("fem/a.py", 2, "sign", "f", 0, 1, "-1", "1")
    assert chooser.turns(mistake) == [["tests/t.py::a"]]


def test_no_two_drawn_touch_and_a_seed_draws_the_same(tool, tmp_path):
    """All survivors can be put in at once."""
    for package in ("geometry", "tmm", "fem", "validation"):
        (tmp_path / package).mkdir()
        (tmp_path / package / "a.py").write_text(SOURCE, encoding="utf-8")
    drawn = tool("run").drawn
    found = drawn(tmp_path, 1, 12)
    assert found == drawn(tmp_path, 1, 12)
    assert len({(m.file, m.line) for m in found}) == 12
    assert {m.file for m in drawn(tmp_path, 1, 4, ["fem"])} == {"fem/a.py"}
    (tmp_path / "fem/b").mkdir()
    (tmp_path / "fem/b/c.py").write_text(SOURCE, encoding="utf-8")
    few = drawn(tmp_path, 1, 6, ["fem"], ["fem/b"])  # two kinds stand on one line alone
    assert {m.file for m in few} == {"fem/b/c.py"}
    one = tool("mistakes").Mistake("a.py", 1, "sign", "f", 4, 9, "-a - b", "a - b")
    assert one.touches(tool("mistakes").Mistake("a.py", 2, "sign", "f", 8, 12, "b", "c"))
    assert not one.touches(tool("mistakes").Mistake("a.py", 2, "sign", "f", 9, 12, "b", "c"))


def test_a_mistake_is_there_while_the_tests_run_and_never_after(tool, tmp_path, monkeypatch):
    """With a time of its own, so that no compiled file is taken for it."""
    run, mistake = tool("run"), tool("mistakes").Mistake
    path = tmp_path / "a.py"
    path.write_text("b = 1 + 2\n")
    before, during = path.stat().st_mtime_ns, []
    monkeypatch.setattr(
        run, "tried", lambda *_, **__: during.append((path.read_text(), path.stat().st_mtime_ns))
    )
    ones = [mistake("a.py", 1, "integer", "", 4, 5, "1", "10"),
            mistake("a.py", 1, "integer", "", 8, 9, "2", "3")]  # fmt: skip
    run._tried_on(tmp_path, ones, [])
    ((text, time),) = during
    assert (text, time > before) == ("b = 10 + 3\n", True)
    assert (path.read_text(), path.stat().st_mtime_ns) == ("b = 1 + 2\n", before)


@pytest.mark.heavy
@pytest.mark.parametrize(
    ("body", "verdict"),
    [("pass", "('survived', [])"), ("assert 0", "('killed', ['tests/test_a.py::test_b'])"),
     ("while True: pass", "('undecided', [])")],
)  # fmt: skip
def test_a_run_survives_is_killed_or_takes_too_long(tmp_path, body, verdict):
    """Only what is chosen runs, and what ends it is named."""
    tests = tmp_path / "copy/tests"
    tests.mkdir(parents=True)
    (tests / "test_a.py").write_text(f"def test_a():\n    assert 0\ndef test_b():\n    {body}\n")
    code = (
        "from pathlib import Path\nimport trial\ntrial.SECONDS = 2\n"
        f"print(trial.tried(Path({str(tmp_path / 'copy')!r}), ['tests/test_a.py::test_b']))"
    )
    done = subprocess.run(
        [sys.executable, "-c", code], cwd=HERE, capture_output=True, text=True, check=True
    )
    assert done.stdout.strip() == verdict
