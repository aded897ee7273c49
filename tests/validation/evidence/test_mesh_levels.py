"""One measurement on many levels of fineness: what each kind of division does, and the bars."""

from dataclasses import replace

import pytest

from tactgen.geometry.errors import InputError
from tactgen.validation.evidence import mesh_levels as fineness
from tactgen.validation.evidence import verification
from tactgen.validation.evidence.cases import beams
from tactgen.validation.evidence.verification import division, next_division, verify
from tactgen.validation.models.model import Estimate

LEVELS = (-1, 0, 1, 2, 3)


@pytest.mark.parametrize(
    ("wanted", "on_each"),
    [
        (lambda: fineness.degree(4), (5, 4, 3, 2, 2)),
        (lambda: fineness.degree(1), (2, 1, 1, 1, 1)),
        (lambda: fineness.intervals(6), (9, 6, 4, 3, 2)),
        (lambda: fineness.size(0.8), (0.8 / 1.5, 0.8, 1.2, 1.8, 2.7)),
        (lambda: fineness.segments(4), (8, 4, 2, 1, 1)),
        (lambda: fineness.steps(100), (200, 100, 50, 25, 12)),
        (lambda: fineness.level(3, least=2), (4, 3, 2, 2, 2)),
    ],
)
def test_levels(wanted, on_each):
    """Each is coarser than the last, as long as it can be; a level that is no other says so."""
    before = {}
    for below, value in zip(LEVELS, on_each, strict=True):
        with fineness.on_level(below) as run:
            assert wanted() == pytest.approx(value, rel=1e-15)
        before[below] = value
        assert len(run.kinds) == 1
        if below >= 0:
            assert run.new is (below > 0 and value != before[below - 1])
    with fineness.on_level(-1) as run:
        wanted()
    assert run.new
    assert wanted() == on_each[1]  # outside of all levels it is the case's own


def test_a_cache_holds_each_level_apart():
    """And what was said of the division is said again to whoever asks for the value."""
    asked = []

    @fineness.cached
    def solved(factor):
        asked.append(factor)
        return factor * fineness.counted(fineness.degree(5))

    for below, value in ((0, 10), (1, 8), (0, 10), (1, 8)):
        with fineness.on_level(below) as run:
            assert solved(2) == value
        assert (run.count, run.kinds, run.new) == (value // 2, {fineness.DEGREE}, below == 1)
    assert asked == [2, 2]
    solved.cache_clear()
    assert solved(2) == 10
    assert asked == [2, 2, 2]


@pytest.mark.parametrize(
    ("measure", "bar", "judged_by", "covered_by"),
    [
        (lambda: 1.0 + 0.01 * 4.0 ** -fineness.degree(4), 0.03 / 256, "degree less", "bar"),
        (lambda: 1.01 + 0.01 * 4.0 ** -fineness.degree(4), 0.03 / 256, "degree less",
         "bar and tolerance"),
        (lambda: 1.1 + fineness.degree(1) * 0.01, 0.01, "degree more", ""),
        (lambda: Estimate(1.0, 0.25), 0.25, "own", "bar"),
        (lambda: 1.0, None, "", ""),
    ],
)  # fmt: skip
def test_bars_of_rows(monkeypatch, measure, bar, judged_by, covered_by):
    """The model's own, or the change to the next coarser level; of what is not divided none."""
    case = beams.CASES[0]
    row = replace(case.rows[0], reference=1.0, tolerance=0.0104, measure=measure)
    monkeypatch.setattr(beams, "CASES", (replace(case, rows=(row,)),))
    monkeypatch.setattr(verification, "cached_result", lambda *key, serves: key[-1]())
    (found,) = verify(("beams",), extent="light", announce=lambda _: None)
    assert found.covered_by == covered_by
    assert (found.bar is None) is (bar is None)
    if bar is not None:
        assert found.bar.error == pytest.approx(bar, rel=1e-9)
        assert judged_by in found.bar.method
        assert found.plain()["bar"] == found.bar.error
    assert (next_division("beams", row) is None) is (judged_by in ("own", ""))


def test_a_level_that_is_refused_as_too_coarse_is_none(monkeypatch):
    """The next finer one is taken then; what the row's own level refuses is said."""
    case, least = beams.CASES[0], [4]

    def measure():
        found = fineness.degree(4)
        if found < least[0]:
            raise InputError("the grid is too coarse")
        return 1.0 + 0.1**found

    row = replace(case.rows[0], reference=1.0, measure=measure)
    monkeypatch.setattr(verification, "cached_result", lambda *key, serves: key[-1]())
    assert next_division("beams", row).below == -1
    least[0] = 5
    with pytest.raises(InputError, match="too coarse"):
        division("beams", row)
