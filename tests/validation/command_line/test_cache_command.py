"""``tactgen cache``: what is kept, by kind, and how it goes."""

import json

from tactgen.validation.command_line.cli import main


def test_what_is_kept_is_listed_and_cleared(own_store, capsys):
    """By kind with its size, as a table and for programs, with limit and folder; then nothing."""
    assert main(["solve", "reluctance", "--model", "network"]) == 0
    capsys.readouterr()
    assert main(["cache", "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert (found["folder"], found["cleared"]) == (str(own_store), False)
    assert found["kinds"]["network.point"]["entries"] == 1
    files = [path for path in own_store.iterdir() if path.suffix == ".kept"]
    assert sum(kind["entries"] for kind in found["kinds"].values()) == len(files)
    assert sum(kind["bytes"] for kind in found["kinds"].values()) == sum(
        path.stat().st_size for path in files
    )
    assert main(["cache", "--info"]) == 0
    text = capsys.readouterr().out
    assert "network.point" in text
    assert f"{len(files)} entries" in text
    assert f"at most {found['limit'] / 1e9:g} GB (TACTGEN_CACHE_LIMIT)" in text
    assert main(["cache", "--clear"]) == 0
    assert "removed from" in capsys.readouterr().out
    assert list(own_store.iterdir()) == []
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
