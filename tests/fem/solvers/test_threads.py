"""The number of threads is one setting, and a bad one is answered before anything runs."""

import pytest

from tactgen.fem.solvers.threads import VARIABLE, thread_count
from tactgen.geometry.errors import InputError
from tactgen.validation.command_line.cli import main


@pytest.mark.parametrize(("text", "count"), [("", None), (" ", None), ("1", 1), ("16", 16)])
def test_count(monkeypatch, text, count):
    """A whole number, or nothing."""
    monkeypatch.setenv(VARIABLE, text)
    assert thread_count() == count


@pytest.mark.parametrize("text", ["0", "-1", "two", "1.5", "1e3", "²", "99999"])
def test_bad_count(monkeypatch, text, capsys):
    """One sentence and exit code 2, also where no system is solved."""
    monkeypatch.setenv(VARIABLE, text)
    with pytest.raises(InputError, match=r"TACTGEN_THREADS is '.*'; set it to a whole number"):
        thread_count()
    assert main(["scenes"]) == 2
    out, err = capsys.readouterr()
    assert not out
    assert err.count("\n") == 1


def test_not_set(monkeypatch):
    """Unset leaves the choice to MKL."""
    monkeypatch.delenv(VARIABLE, raising=False)
    assert thread_count() is None
