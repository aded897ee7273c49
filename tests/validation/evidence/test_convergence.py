"""How a case converges: which levels are asked, and what is drawn of them."""

import math
from dataclasses import replace

import pytest

from tactgen.validation.book import book as convergence
from tactgen.validation.book.book import Curve
from tactgen.validation.evidence.case import Answer, Refinement, case, judged
from tactgen.validation.evidence.mesh_levels import DEGREE
from tactgen.validation.evidence.verification import Division, Verified

CASE = case(
    "BAR", "A bar", "How long is it?", model="made up", source="a ruler",
    answers=[Answer("It is 2 m long.", 2.0, "m", lambda: 2.0, 1e-2, "made up")],
)  # fmt: skip


def level(below, value, *, new=True, count=10, kinds=(tuple(DEGREE),)):
    return Division(below, value, math.nan, kinds, new, count, 0.0)


def row_of(found, reference=2.0):
    check = replace(CASE.rows[0], reference=reference)
    return Verified("beams", CASE, check, judged(check, found.value), found)


@pytest.fixture
def drawn(monkeypatch):
    """Take levels from a list in place of solving them; what is drawn in place of figures."""
    asked, kept, coarser = [], [], {}

    def division(group, of, check, below=0):
        asked.append(below)
        return coarser.get(below, level(below, math.nan, new=False))

    def first(group, of, check):
        return next((d for b in (1, -1) if (d := division(group, of, check, b)).new), None)

    monkeypatch.setattr(convergence, "division", division)
    monkeypatch.setattr(convergence, "next_division", first)
    monkeypatch.setattr(convergence, "convergence", lambda *drawn: kept.append(drawn) or "drawn")
    return asked, kept, coarser


def test_levels_are_asked_to_the_third_or_the_last_that_differs(drawn):
    """Of four coarser ones three are solved; two, where the third is no other."""
    asked, kept, coarser = drawn
    coarser.update({n: level(n, 2.0 + 0.1 ** (4 - n), count=50 - 10 * n) for n in (1, 2, 3, 4)})
    found = convergence.converged([row_of(level(0, 2.0, count=50))])
    assert (found.figure, asked) == ("drawn", [1, 2, 3])
    assert [curve.sizes for curve in kept[-1][0]] == [[50, 40, 30, 20], [40, 30, 20]]
    coarser[3] = level(3, 5.0, new=False)
    convergence.converged([row_of(level(0, 2.0, count=50))])
    assert [curve.sizes for curve in kept[-1][0]] == [[50, 40, 30], [40, 30]]


@pytest.mark.parametrize("reference", [0.0, (1.0, 2.0)])
def test_nothing_is_relative_to_zero_or_to_a_range(drawn, reference):
    """Changes alone, over levels where some unknowns were not counted; of zeros they are zero."""
    _, kept, coarser = drawn
    coarser[1] = level(1, 0.0, count=0)
    convergence.converged([row_of(level(0, 0.0), reference)])
    assert kept[0][:2] == ([Curve("change to the finest", [-1], [0.0])], "level")


def test_the_first_row_that_is_divided_is_shown_or_why_there_is_none(drawn):
    _, kept, coarser = drawn
    undivided = row_of(level(0, 2.0, kinds=()))
    coarser[1] = level(1, 2.1)
    found = convergence.converged([undivided, row_of(level(0, 2.05))])
    assert kept[0][0][0].errors == [pytest.approx(0.025), pytest.approx(0.05)]
    assert found.figure == "drawn"
    assert convergence.converged([undivided]) == ("", convergence._WITHOUT)
    skipped = Verified("beams", CASE, CASE.rows[0])
    assert convergence.converged([skipped, undivided]) == ("", convergence._WITHOUT)
    assert "--heavy" in convergence.converged([skipped]).words


def test_a_case_with_a_refinement_of_its_own_shows_that(drawn, own_store):
    """Though its rows could be solved on other levels."""
    _, kept, coarser = drawn
    coarser[1] = level(1, 2.1)
    refined = replace(CASE, refinement=Refinement((4, 2), lambda n: 0.3 / n**2, "second order"))
    found = convergence.converged([replace(row_of(level(0, 2.0)), case=refined)])
    assert found == ("drawn", "theory: second order")
    curve = Curve("error", (4, 2), [0.3 / 16, 0.3 / 4])
    assert kept == [([curve], "intervals along an edge", 0.0)]
