"""``tactgen cache``: what is kept, by kind, and how it goes."""

import json

import pytest

from tactgen.validation.command_line.cli import main


@pytest.fixture
def filled(own_store, capsys):
    """A store with the answers of one small scene."""
    assert main(["solve", "reluctance", "--model", "network"]) == 0
    capsys.readouterr()
    return own_store


def test_info_lists_kinds_with_their_size(filled, capsys):
    """As a table and for programs; the limit and the folder are said."""
    assert main(["cache", "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["folder"] == str(filled)
    assert (found["limit"], found["cleared"]) == (5_000_000_000, False)
    assert found["kinds"]["network.point"]["entries"] == 1
    files = [path for path in filled.iterdir() if path.suffix == ".kept"]
    assert sum(kind["entries"] for kind in found["kinds"].values()) == len(files)
    assert sum(kind["bytes"] for kind in found["kinds"].values()) == sum(
        path.stat().st_size for path in files
    )
    assert main(["cache", "--info"]) == 0
    text = capsys.readouterr().out
    assert "network.point" in text
    assert f"{len(files)} entries" in text
    assert "at most 5 GB (TACTGEN_CACHE_LIMIT)" in text


def test_clear_empties_it(filled, capsys):
    """And says what went."""
    assert main(["cache", "--clear"]) == 0
    assert "removed from" in capsys.readouterr().out
    assert list(filled.iterdir()) == []
    assert main(["cache", "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["kinds"] == {}


def test_bad_limit_is_refused_before_anything_runs(monkeypatch, capsys):
    """One sentence, exit code 2."""
    monkeypatch.setenv("TACTGEN_CACHE_LIMIT", "plenty")
    assert main(["solve", "paper", "--model", "lumped"]) == 2
    said = capsys.readouterr()
    assert said.out == ""
    assert said.err.count("\n") == 1
    assert "TACTGEN_CACHE_LIMIT = plenty is not a size" in said.err
