"""The stress run: what it finds, how it judges, and what its command writes."""

import argparse
import io
import json
import math
import sys

import pytest

from tactgen.validation.command_line.commands import evidence as command
from tactgen.validation.evidence import stress_beam as beam
from tactgen.validation.evidence import stress_magnetics as magnetics
from tactgen.validation.evidence.stress import Family, PartRequest, Point, Stress, answered


@pytest.fixture(scope="module")
def found():
    """Return the quick run of the transfer-matrix model's part, on a few points over its ranges."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(beam, "_QUICK", (7, 2))
        patch.setattr(beam, "_NEAR_CUT_OFF", (0.0, 1e-14))
        patch.setattr(beam, "_QUALITIES", (1.0, 1e9))
        return beam.run(PartRequest(quick=True))


def row(found, family):
    return next(r for r in found.rows if r.family == family)


def test_every_family_holds(found):
    """Within its bounds; joining n pieces costs n³ roundings at most."""
    assert {r.verdict for r in found.rows if not r.family.startswith("natural")} == {"holds"}


def test_natural_frequencies_from_slender_to_all_shear(found):
    """Each within its rounding; only free beams at φ beyond use are refused."""
    judgement = row(found, "natural frequencies: slenderness")
    assert judgement.verdict == "holds or says why not"
    # three modes at five φ and three ends, less those of the free beam at 1e8 and 1e16
    assert judgement.points == 3 * (5 * 3 - 2)
    assert all("lost in rounding" in refusal for refusal in judgement.refusals)


def test_into_a_resonance(found):
    """Down to the last bit the bound is right, and then is large."""
    worst = row(found, "resonance").worst
    assert worst.error > 1e-8
    assert worst.bound < 100 * worst.error


def test_the_naive_formulas_fail(found):
    """The paper's matrix A has no digit left in a long beam, and too few near 0 Hz."""
    for table in found.maps:
        # above the cut-off, 860 kHz, no wave grows any more
        high = table.naive[-1, (table.frequencies > 1e3) & (table.frequencies < 8e5)]
        low = table.naive[table.lengths < 1e-3][
            :, (table.frequencies > 0) & (table.frequencies < 1)
        ]
        assert high.size
        assert (high > 0.1).all()
        assert low.size
        assert (low > 1e-10).all()
        assert (table.error < 1e-10).all()


@pytest.mark.heavy
@pytest.mark.parametrize("quick", [True, False])
def test_whole_grids(quick):
    """Neither the quick nor the full run finds a family that fails."""
    assert all(r.verdict != "fails" for r in beam.run(PartRequest(quick)).rows)


def synthetic(error):
    return Point("somewhere", error, 1e-12)


@pytest.mark.parametrize(
    ("points", "refusals", "verdict"),
    [
        ([synthetic(1e-13)], [], "holds"),
        ([synthetic(1e-13)], ["too far: come nearer"], "holds or says why not"),
        ([], ["too far: come nearer"], "holds or says why not"),
        ([synthetic(1e-3), synthetic(1e-2)], [], "fails"),
        ([synthetic(math.nan)], [], "fails"),
        ([], ["Traceback:\n  File"], "fails"),
        ([], [""], "fails"),
    ],
)
def test_verdicts_of_answers(points, refusals, verdict):
    """A family of answers and refusals holds, says why not, or fails."""
    assert answered("family", "what", points, refusals).verdict == verdict


@pytest.mark.parametrize(
    ("shares", "verdict"),
    [((2.9,), "holds"), ((1.1, 1.1), "fails"), ((3.1,), "fails"), ((math.nan,), "fails")],
)
def test_bars_that_promise_a_share_are_held_to_it(shares, verdict):
    """One of 20 answers may be beyond its bar, but not two, nor one by three bars."""
    shares = (*shares, *(20 - len(shares)) * (0.5,))
    points = [Point("somewhere", 1e-9 * share, 1e-9) for share in shares]
    row = answered("family", "what", points, promised=0.95)
    assert row.verdict == verdict
    missed = [1e-9 * share for share in shares if not share <= 1.0]
    assert repr([point.error for point in row.beyond]) == repr(missed)
    assert answered("family", "what", points).verdict == "fails"


def test_worst_is_one_that_failed():
    """A large error within its bound does not hide a made_up_stress one beyond its own."""
    allowed = Point("far", 0.5, 1.0)
    assert answered("family", "what", [allowed, synthetic(1e-3)]).worst.where == "somewhere"


def test_nothing_impossible_is_answered():
    """Each of them ends in a sentence of its own."""
    family = Family()
    magnetics._no_answer(family, True)
    assert family.points == []
    assert len(set(family.refusals)) == len(family.refusals) == 12


@pytest.mark.heavy
@pytest.mark.parametrize("quick", [True, False])
def test_whole_magnetic_run(quick):
    """µr 1 to 1e6, gaps 1 µm to 5 mm, 1 µA to 1 kA, coarse to fine: none fails."""
    found = magnetics.run(PartRequest(quick))
    assert all(row.verdict != "fails" for row in found.rows)


def options(**changes):
    return argparse.Namespace(
        **{"only": None, "quick": True, "out": None, "json": False, "seed": "1", **changes}
    )


def test_files_are_there_where_nobody_reads(made_up_stress, tmp_path, monkeypatch):
    """Who closes the pipe still has the tables."""
    made_up_stress([synthetic(1e-13)])

    class Shut(io.StringIO):
        def write(self, _):
            raise ValueError("closed")

    monkeypatch.setattr(sys, "stdout", Shut())
    with pytest.raises(ValueError, match="closed"):
        command._stress(options(only=["tmm"], out=tmp_path))
    assert list(tmp_path.glob("*.csv"))


def test_command_quotes_refusals(monkeypatch, tmp_path, capsys):
    """Those that differ in numbers alone once, with how often; the file has them too."""
    said = ["come nearer", "1.5 mm is off", "come nearer", "-2e-3 mm is off"]
    rows = (answered("family", "what", [synthetic(1e-13)], said),)
    made = Stress("magnetics", "words", rows, (), 0.0)
    monkeypatch.setattr(magnetics, "run", lambda *_: made)
    assert command._stress(options(only=["magnetics"], out=tmp_path)) == 0
    out = capsys.readouterr().out
    assert "magnetics: refused 2 x: come nearer\n" in out
    assert "magnetics: refused 2 x, such as: 1.5 mm is off\n" in out
    assert "come nearer | 1.5 mm is off" in (tmp_path / "stress.csv").read_text()


def test_command_fails_if_a_family_does(made_up_stress):
    """The exit code is 1."""
    made_up_stress([synthetic(1e-3)])
    assert command._stress(options(only=["tmm"])) == 1


def test_command_as_json(made_up_stress, capsys):
    """Standard JSON: what is not finite is null."""
    made_up_stress([synthetic(1e-13)])
    command._stress(options(only=["tmm"], json=True))
    told = json.loads(capsys.readouterr().out)
    assert told["verdicts"] == {"tmm": ["holds"]}
    assert told["parts"][0]["maps"][0]["naive"] == [[None, None]]
