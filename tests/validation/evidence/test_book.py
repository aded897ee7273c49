"""The verification book: every row has its page, the matrix leads to it, nothing is run twice."""

import math
from dataclasses import replace
from types import SimpleNamespace

import pytest

from tactgen.validation.book.book import SUBJECTS, Convergence, Page, scatter
from tactgen.validation.book.orders import DIVISIONS, KINDS
from tactgen.validation.evidence import verification
from tactgen.validation.evidence.case import PROBLEMS, judged
from tactgen.validation.evidence.cases import beams, elastic
from tactgen.validation.evidence.verification import GROUPS, Verified, verify

FEW = tuple(case for case in beams.CASES if case.id in ("SMITS", "VM148"))
STRIP = tuple(case for case in elastic.CASES if case.id == "R0031")


@pytest.fixture
def few(monkeypatch):
    monkeypatch.setattr(beams, "CASES", FEW)
    monkeypatch.setattr(elastic, "CASES", STRIP)


def test_every_group_has_a_subject():
    """A group without a word on what it is about could not be read."""
    assert list(SUBJECTS) == list(GROUPS)


def test_every_case_says_its_problem():
    """And what solves it, so that a reader can solve it elsewhere; no family without rows."""
    families = set()
    for group in GROUPS:
        for case in verification.group_cases(group):
            assert case.title, case.id
            assert case.problem.endswith((".", "?")), case.id
            assert case.model, case.id
            families.add((group, case.id))
    assert set(PROBLEMS) <= families


def test_what_did_not_change_is_not_run_again(few, monkeypatch):
    """A measured value is kept by the code that measures it; a failure is measured anew."""
    first = verify(("beams",), extent="light", announce=lambda _: None)

    def refuse():
        raise AssertionError("measured again")

    still = tuple(
        replace(case, rows=tuple(replace(row, measure=refuse) for row in case.rows)) for case in FEW
    )
    monkeypatch.setattr(beams, "CASES", still)
    again = verify(("beams",), extent="light", announce=lambda _: None)
    assert [row.outcome.measured for row in again] == [row.outcome.measured for row in first]
    wrong = replace(still[0], rows=(replace(still[0].rows[0], reference=1.0),))
    monkeypatch.setattr(beams, "CASES", (wrong,))
    with pytest.raises(AssertionError, match="measured again"):
        verify(("beams",), extent="light", announce=lambda _: None)


def test_the_grid_of_orders_has_every_row_of_an_order_and_no_empty_square():
    """A row in it says its order; one that says an order is in it; each square has a word."""
    said = {
        row.id
        for row in verification.group_rows("orders")
        if " converge with order " in row.requirement
    }
    shown = [rows for division in DIVISIONS for rows in division.rows]
    assert all(len(division.rows) == len(KINDS) for division in DIVISIONS)
    assert all(shown)
    assert {id_ for rows in shown if not isinstance(rows, str) for id_ in rows} == said


def test_quick_takes_the_first_row_of_each_case(few):
    """The others are skipped, and say so."""
    found = verify(("beams",), extent="quick", announce=lambda _: None)
    assert [row.check.id for row in found if row.verdict != "skipped"] == ["SMITS-1", "VM148-1"]
    assert sum(row.verdict == "skipped" for row in found) == len(found) - len(FEW)


def test_bias_and_scatter():
    """Two values e^±s about their references: no bias but the variance's half, scatter √2 s."""
    row = FEW[0].rows[0]
    size = 0.01
    found = [
        Verified("beams", FEW[0], row, judged(row, row.reference * math.exp(sign * size)), 0.0)
        for sign in (1, -1)
    ]
    got = scatter(found)
    assert got.spread == pytest.approx(math.sqrt(2.0) * size, rel=1e-12)
    assert got.bias == pytest.approx(math.exp(size**2), rel=1e-12)
    assert scatter(found[:1]) is None


def test_modules_of_groups_are_there():
    """Each group names a module and a tuple of rows or cases in it."""
    assert all(verification.group_rows(group) for group in ("beams", "elastic"))


def test_the_worst_of_its_rows_is_a_pages_verdict():
    """What fails before what is explained, that before what passes, and last what was skipped."""
    order = ("fail", "explained", "pass", "skipped")
    assert set(order) == set(verification.VERDICTS)
    for number, worst in enumerate(order):
        rows = tuple(SimpleNamespace(verdict=verdict) for verdict in order[number:])
        assert Page("beams", FEW[0], rows[::-1], Convergence("", ""), "").verdict == worst
