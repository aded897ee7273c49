"""``tactgen positions``: table, JSON, CSV and picture; bad input refused in one sentence."""

import csv
import json

import numpy as np
import pytest

from tactgen.validation.command_line.cli import main


def test_the_loop_by_both_ways(tmp_path, capsys):
    """Rising it stays up until the pull-in current, falling down until the drop-out current."""
    plot, table = tmp_path / "loop.svg", tmp_path / "loop.csv"
    arguments = ["--current", "0:150mA:31", "--plot", str(plot), "--csv", str(table), "--json"]
    assert main(["positions", "generator", "--model", "network", *arguments]) == 0
    (found,) = json.loads(capsys.readouterr().out)["loops"]
    current = np.array(found["current"])
    for way, switch in (("rising", "pull_in"), ("falling", "drop_out")):
        at = found["switching"][switch]["value"]
        kinds = np.array([place["kind"] for place in found[way]["places"]])
        assert set(kinds[current < at]) == {"upper stop"}
        assert set(kinds[current > at]) == {"lower stop"}
        assert len(found[way]["uncertainty"]) == current.size
    assert "pull-in" in plot.read_text(encoding="utf-8")
    with table.open(encoding="utf-8", newline="") as rows:
        read = list(csv.DictReader(rows))
    assert len(read) == 31
    assert float(read[-1]["position rising (m)"]) == pytest.approx(-180.6e-6, rel=1e-3)
    assert float(read[-1]["current (A)"]) == pytest.approx(0.150)


@pytest.mark.parametrize(
    ("arguments", "said"),
    [(["--current", "0:9A:5"], "ends at"), (["--model", "tmm"], 'model "tmm" is of the bimorph'),
     (["--csv", "x.txt"], "must end in .csv"),
     (["--plot", "nowhere/x.svg"], "its folder does not exist")],
)  # fmt: skip
def test_refused_in_one_sentence(tmp_path, monkeypatch, capsys, arguments, said):
    """Exit code 2, and nothing written."""
    monkeypatch.chdir(tmp_path)
    assert main(["positions", *arguments]) == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert err.count("\n") == 1
    assert said in err
    assert not list(tmp_path.iterdir())
