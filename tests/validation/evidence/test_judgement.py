"""What coverage and stress runs count, what they call too narrow, and what their commands write."""

import argparse
import csv
import io
import json
import math
import sys

import numpy as np
import pytest

from tactgen.geometry.errors import InputError
from tactgen.validation.command_line.cli import main
from tactgen.validation.command_line.commands import evidence as command
from tactgen.validation.evidence import coverage, stress
from tactgen.validation.evidence import coverage_bimorph as bimorph
from tactgen.validation.evidence import stress_beam as beam
from tactgen.validation.evidence.judgement import (
    MULTIPLES,
    Family,
    Judged,
    PartRow,
    calibration,
    relative,
    rows,
)


def answers(inside, outside, quantity="f"):
    return [Judged("here", quantity, 1.0, 2.0)] * inside + [Judged("there", quantity, 3.0, 2.0)] * (
        outside
    )


def covered(found):
    return rows(found, coverage.RULE, total=True)


@pytest.mark.parametrize(
    ("inside", "outside", "holds"),
    [(20, 0, True), (18, 2, True), (15, 5, False), (190, 10, True), (180, 20, False), (1, 0, True)],
)
def test_verdict_allows_for_chance(inside, outside, holds):
    """Less than 95 % of a few may be chance; of many it is not (binomial, 1 % false alarm)."""
    (row,) = covered(answers(inside, outside))
    assert (row.inside, row.count, row.holds) == (inside, inside + outside, holds)
    assert row.width == 2.0
    assert row.verdict == ("holds" if holds else "fails")
    assert row.worst.where == ("there" if outside else "here")


def test_width_is_the_median_of_bar_over_error():
    """Answers that are hit exactly take what a double can tell for their error."""
    eps = np.finfo(float).eps
    found = [
        Judged("", "f", 0.0, 3.0 * eps),
        Judged("", "f", 1e-3, 4e-3),
        Judged("", "f", 1.0, 9.0),
    ]
    assert covered(found)[0].width == pytest.approx(4.0)


@pytest.mark.parametrize(
    ("bars", "verdict"),
    [([1.0, 5.0, 9.0], "holds"), ([1.0, 5.1, 9.0], "wide"), (3 * [0.1] + 4 * [90.0], "fails")],
)
def test_bars_that_cover_by_being_wide_are_called_so(bars, verdict):
    """Median of bar over error beyond five; what does not cover fails, however wide it is."""
    (row,) = covered([Judged(f"device {n % 2}", "f", 1.0, bar) for n, bar in enumerate(bars)])
    assert (row.verdict, row.places) == (verdict, 2)
    assert row.holds == (verdict != "fails")


def test_a_row_a_quantity_and_one_of_all():
    found = covered([*answers(5, 1), *answers(1, 0, "u")])
    assert [(row.quantity, row.inside, row.count) for row in found] == [
        ("f", 5, 6), ("u", 1, 1), ("all", 6, 7),
    ]  # fmt: skip


def test_calibration_counts_what_lies_within_so_many_bars():
    """Errors of 0.5 and 1.5 bars: half from 0.5 on, all from 1.5 on."""
    curve = calibration(answers(1, 1))
    assert curve[MULTIPLES < 0.5].max() == 0.0
    assert set(curve[(MULTIPLES >= 0.5) & (MULTIPLES < 1.5)]) == {0.5}
    assert set(curve[MULTIPLES >= 1.5]) == {1.0}


def test_errors_are_relative_to_the_better_answer():
    """Entries of 0 in units of the largest."""
    (one,) = relative("here", "force", 0.9, 0.3, -1.0)
    assert (one.where, one.quantity, one.error, one.bar) == ("here", "force", 1.9, 0.3)
    first, second = relative("here", "f", [1.0, 2.0], [0.1, 0.1], [0.0, 4.0])
    assert (first.which, second.which) == ("1", "2")
    assert (first.error, second.error) == (0.25, 0.5)
    assert relative("here", "f", 0.0, 0.0, 0.0)[0].within


#: Sentence, sentences, and what is none.
FAR = "too far: come nearer"


@pytest.mark.parametrize(
    ("errors", "refusals", "verdict"),
    [
        ([1e-13], [], "holds"),
        ([1e-13], [FAR], "holds or says why not"),
        ([], [FAR], "holds or says why not"),
        ([1e-3, 1e-2], [], "fails"),
        ([1e-13] * 99 + [1e-3], [], "fails"),
        ([math.nan], [], "fails"),
        ([], ["Traceback:\n  File"], "fails"),
        ([], [""], "fails"),
    ],
)
def test_verdicts_of_families(errors, refusals, verdict):
    """Answers within bounds, or refusals in one sentence."""
    family = Family("family")
    for error in errors:
        family.add("somewhere", error, 1e-12)
    for words in refusals:
        with family.attempt():
            raise InputError(words)
    (row,) = rows(family.answers, stress.RULE)
    assert row.verdict == verdict
    assert row.count + row.refused == len(family.answers) == len(errors) + len(refusals)


@pytest.mark.parametrize(
    ("shares", "verdict"),
    [((2.9,), "holds"), ((1.1, 1.1), "fails"), ((3.1,), "fails"), ((math.nan,), "fails")],
)
def test_bars_that_promise_a_share_are_held_to_it(shares, verdict):
    """One of 20 answers may be beyond its bar, but not two, nor one by three bars."""
    shares = (*shares, *(20 - len(shares)) * (0.5,))
    (row,) = rows([Judged("somewhere", "f", 1e-9 * s, 1e-9) for s in shares], stress.RULE)
    assert row.verdict == verdict
    assert row.inside == sum(share <= 1.0 for share in shares)


def test_worst_is_the_one_farthest_beyond_its_bar():
    """A large error within its bound does not hide a smaller one beyond its own."""
    found = [Judged("far", "f", 0.5, 1.0), Judged("somewhere", "f", 1e-3, 1e-12)]
    assert rows(found, stress.RULE)[0].worst.where == "somewhere"


@pytest.fixture
def made_up(own_store, monkeypatch):
    """Return a function that gives ``stress`` a part, made up of one error and some refusals."""

    def put(error, *refusals):
        def judge(family, _):
            family.add("somewhere", error, 1e-12)
            for words in refusals:
                family.refuse(words)

        monkeypatch.setattr(beam, "MADE_UP", {"family": judge}, raising=False)
        monkeypatch.setitem(stress.PARTS, "made-up", PartRow("words", "stress_beam.MADE_UP"))

    return put


MADE_UP = ["stress", "--only", "made-up", "--seed", "1"]


def test_files_are_there_where_nobody_reads(made_up, tmp_path, monkeypatch):
    """Who closes the pipe still has the tables."""
    made_up(1e-13)

    class Shut(io.StringIO):
        def write(self, _):
            raise ValueError("closed")

    monkeypatch.setattr(sys, "stdout", Shut())
    with pytest.raises(ValueError, match="closed"):
        command._judge(
            "stress", argparse.Namespace(only=["made-up"], out=tmp_path, json=False, seed="1")
        )
    assert list(tmp_path.glob("*.csv"))


def test_command_quotes_refusals(made_up, tmp_path, capsys):
    """Those that differ in numbers alone once, with how often; the file has all."""
    made_up(1e-13, "come nearer", "1.5 mm is off", "come nearer", "-2e-3 mm is off")
    assert main([*MADE_UP, "--out", str(tmp_path)]) == 0
    out = capsys.readouterr().out
    assert "refused 2 x: come nearer\n" in out
    assert "refused 2 x, such as: 1.5 mm is off\n" in out
    assert (tmp_path / "stress-answers.csv").read_text().count("come nearer") == 2


def test_command_fails_if_a_family_does(made_up, capsys):
    """The exit code is 1, and what is beyond its bar is told."""
    made_up(1e-3)
    assert main(MADE_UP) == 1
    assert "1e+09 times its bar of 1.0e-12 at somewhere" in capsys.readouterr().out


def test_command_as_json(made_up, capsys):
    """Standard JSON: what is not finite is null."""
    made_up(1e-13, "come nearer")
    assert main([*MADE_UP, "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    (row,), (answer, refusal) = told["rows"]["made-up"], told["answers"]["made-up"]
    assert (row["verdict"], row["refused"]) == ("holds or says why not", 1)
    assert (answer["error"], refusal["error"], refusal["refusal"]) == (1e-13, None, "come nearer")


def test_wide_bars_are_said_in_table_json_and_csv(own_store, monkeypatch, capsys, tmp_path):
    """And the exit code stays 0."""
    monkeypatch.setattr(bimorph, "judge_beam", lambda _: [Judged("device", "f", 1e-6, 6e-6)])
    asked = ["coverage", "--only", "beam", "--devices", "2", "--seed", "1"]
    assert main([*asked, "--out", str(tmp_path)]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert lines[2].split() == ["1", "2/2", "0", "6", "1.0e-06", "0.17", "wide", "f"]
    assert lines[3] == "wide: bars that cover, but of a median bar/error beyond 5"
    with (tmp_path / "coverage-verdicts.csv").open() as file:
        (row,) = csv.DictReader(file)
    assert (row["quantity"], row["answers"], row["verdict"]) == ("f", "2", "wide")
    assert main([*asked, "--json"]) == 0
    (row,) = json.loads(capsys.readouterr().out)["rows"]["beam"]
    assert row["verdict"] == "wide"


def test_bad_input_is_refused(capsys):
    """One sentence each."""
    for arguments in (["--devices", "0"], ["--seed", "-1"], ["--only", "beams"]):
        assert main(["coverage", *arguments]) == 2
        assert capsys.readouterr().err.count("\n") == 1
