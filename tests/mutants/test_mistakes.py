"""What the mutation run puts in: each kind of mistake where it is wanted, and nothing else."""

import importlib.util
import sys
from pathlib import Path

import pytest

SOURCE = '''"""A docstring with 2.0 in it."""

LIMIT: float = 0.5
ORDER = ("first", "second", "third")


def answer(a, b, k):
    """Return 3.0 of them."""
    if a < LIMIT:
        raise ValueError(f"{a + 1} is below")
    c = -a * b + k[0, 1]
    write_text(a, b)
    return max(c, 2) if not k else plot(a, b, figsize=(4, 3), stderr=True)
'''


@pytest.fixture(scope="module")
def mistakes():
    """Return the module, which is beside this file and in no package."""
    path = Path(__file__).parent / "mistakes.py"
    spec = importlib.util.spec_from_file_location("mistakes", path)
    module = importlib.util.module_from_spec(spec)
    sys.modules[spec.name] = module
    spec.loader.exec_module(module)
    yield module
    del sys.modules[spec.name]


def test_every_kind_once_and_no_word_of_what_is_said(mistakes, tmp_path):
    """Numbers of docstrings, messages, annotations and looks stay; each file is still Python."""
    (tmp_path / "a.py").write_text(SOURCE, encoding="utf-8")
    found = mistakes.mistakes_in(tmp_path, "a.py")
    assert {(m.line, m.kind, m.before, m.after) for m in found} >= {
        (3, "number x3", "0.5", "1.5"),
        (4, "key", '"first", ', ""),
        (9, "comparison", " < ", " >= "),
        (9, "refusal", "a < LIMIT", "False"),
        (11, "sign", "-a", "a"),
        (11, "operator", "-a * b + k[0, 1]", "(-a * b) - (k[0, 1])"),
        (11, "term", "-a * b + k[0, 1]", "(-a * b)"),
        (11, "index", "0, 1", "1, 0"),
        (12, "write", "write_text(a, b)", "(a).write_text(b)"),
        (12, "index", "a, b", "b, a"),
        (12, "statement", "write_text(a, b)", "pass"),
        (13, "operator", "max", "min"),
        (13, "integer", "2", "3"),
        (13, "stream", "True", "not True"),
    }
    lines = {m.line for m in found if m.kind.startswith(("number", "integer"))}
    assert lines == {3, 11, 13}  # not 1, 8, 10
    assert not [m for m in found if m.before in ("4", "(4, 3)")]
    source = SOURCE.encode()
    assert all(mistakes.is_python(m.put(source)) for m in found)
    assert {m.function for m in found} == {"", "answer:7"}
