"""The verification book: every row has its page, nothing is run twice, convergence is shown."""

import math
import re
from dataclasses import replace
from types import SimpleNamespace

import pytest

from tactgen.validation.book import book
from tactgen.validation.book.book import DIVISIONS, KINDS, Convergence, Curve, Page, scatter
from tactgen.validation.evidence import verification
from tactgen.validation.evidence.case import Refinement, judged
from tactgen.validation.evidence.cases import beams
from tactgen.validation.evidence.judgement import Family, rows
from tactgen.validation.evidence.mesh_levels import DEGREE
from tactgen.validation.evidence.stress import RULE
from tactgen.validation.evidence.verification import Division, Verified, verify

FEW = tuple(case for case in beams.CASES if case.id in ("SMITS", "VM148"))
CASE = FEW[0]


@pytest.fixture
def few(monkeypatch):
    monkeypatch.setattr(beams, "CASES", FEW)


def run(extent="light"):
    return verify(("beams",), extent=extent, announce=lambda _: None)


def test_what_did_not_change_is_not_run_again(few, monkeypatch):
    """A measured value is cached by the code that measures it; a failure is measured anew."""
    first = run()

    def refuse():
        raise AssertionError("measured again")

    still = tuple(
        replace(case, rows=tuple(replace(row, measure=refuse) for row in case.rows)) for case in FEW
    )
    monkeypatch.setattr(beams, "CASES", still)
    assert [row.outcome.measured for row in run()] == [row.outcome.measured for row in first]
    wrong = replace(still[0], rows=(replace(still[0].rows[0], reference=1.0),))
    monkeypatch.setattr(beams, "CASES", (wrong,))
    with pytest.raises(AssertionError, match="measured again"):
        run()


def test_the_grid_of_orders_has_every_row_of_an_order_and_no_empty_square():
    """A row in it says its order; one that says an order is in it; each square has a word."""
    said = {
        row.id
        for row in verification.group_rows("orders")
        if " converge with order " in row.requirement
    }
    assert all(len(rows) == len(KINDS) and all(rows) for rows in DIVISIONS.values())
    shown = [ids for rows in DIVISIONS.values() for ids in rows if not isinstance(ids, str)]
    assert {id_ for ids in shown for id_ in ids} == said


def test_quick_takes_the_first_row_of_each_case(few):
    """The others are skipped, and say so."""
    rows = run("quick")
    assert [row.check.id for row in rows if row.verdict != "skipped"] == ["SMITS-1", "VM148-1"]
    assert sum(row.verdict == "skipped" for row in rows) == len(rows) - len(FEW)


def test_bias_and_scatter():
    """Two values e^±s about their references: no bias but the variance's half, scatter √2 s."""
    row, size = CASE.rows[0], 0.01
    rows = [
        Verified("beams", CASE, row, judged(row, row.reference * math.exp(sign * size)))
        for sign in (1, -1)
    ]
    got = scatter(rows)
    assert got.spread == pytest.approx(math.sqrt(2.0) * size, rel=1e-12)
    assert got.bias == pytest.approx(math.exp(size**2), rel=1e-12)
    assert scatter(rows[:1]) is None


def test_the_worst_of_its_rows_is_a_pages_verdict():
    """What fails before what is explained, that before what passes, and last what was skipped."""
    order = ("fail", "explained", "pass", "skipped")
    assert set(order) == set(verification.VERDICTS)
    for number, worst in enumerate(order):
        rows = tuple(SimpleNamespace(verdict=verdict) for verdict in order[number:])
        assert Page("beams", CASE, rows[::-1], Convergence("", "")).verdict == worst


def level(below, value, *, new=True, count=10, kinds=(tuple(DEGREE),)):
    return Division(below, value, math.nan, kinds, new, count, 0.0)


def row_of(found, reference=2.0):
    check = replace(CASE.rows[0], reference=reference)
    return Verified("beams", CASE, check, judged(check, found.value), found)


@pytest.fixture
def drawn(monkeypatch):
    """Take levels from a list in place of solving them; what is drawn in place of figures."""
    asked, curves, coarser = [], [], {}

    def division(group, check, below=0):
        asked.append(below)
        return coarser.get(below, level(below, math.nan, new=False))

    def first(group, check):
        return next((d for b in (1, -1) if (d := division(group, check, b)).new), None)

    monkeypatch.setattr(book, "division", division)
    monkeypatch.setattr(book, "next_division", first)
    monkeypatch.setattr(book, "convergence", lambda *drawn: curves.append(drawn) or "drawn")
    return asked, curves, coarser


def test_levels_are_asked_to_the_third_or_the_last_that_differs(drawn):
    """Of four coarser ones three are solved; two, where the third is no other."""
    asked, curves, coarser = drawn
    coarser.update({n: level(n, 2.0 + 0.1 ** (4 - n), count=50 - 10 * n) for n in (1, 2, 3, 4)})
    found = book.converged([row_of(level(0, 2.0, count=50))])
    assert (found.figure, asked) == ("drawn", [1, 2, 3])
    assert [curve.sizes for curve in curves[-1][0]] == [[50, 40, 30, 20], [40, 30, 20]]
    coarser[3] = level(3, 5.0, new=False)
    book.converged([row_of(level(0, 2.0, count=50))])
    assert [curve.sizes for curve in curves[-1][0]] == [[50, 40, 30], [40, 30]]


@pytest.mark.parametrize("reference", [0.0, (1.0, 2.0)])
def test_nothing_is_relative_to_zero_or_to_a_range(drawn, reference):
    """Changes alone, over levels where some unknowns were not counted; of zeros they are zero."""
    _, curves, coarser = drawn
    coarser[1] = level(1, 0.0, count=0)
    book.converged([row_of(level(0, 0.0), reference)])
    assert curves[0][:2] == ([Curve("change to the finest", [-1], [0.0])], "level")


def test_the_first_row_that_is_divided_is_shown_or_why_there_is_none(drawn):
    _, curves, coarser = drawn
    undivided = row_of(level(0, 2.0, kinds=()))
    coarser[1] = level(1, 2.1)
    assert book.converged([undivided, row_of(level(0, 2.05))]).figure == "drawn"
    assert curves[0][0][0].errors == [pytest.approx(0.025), pytest.approx(0.05)]
    assert book.converged([undivided]).figure == ""
    assert "--heavy" in book.converged([Verified("beams", CASE, CASE.rows[0])]).words


def test_a_case_with_a_refinement_of_its_own_shows_that(drawn, own_store):
    """Though its rows could be solved on other levels."""
    _, curves, coarser = drawn
    coarser[1] = level(1, 2.1)
    refined = replace(CASE, refinement=Refinement((4, 2), lambda n: 0.3 / n**2, "second order"))
    found = book.converged([replace(row_of(level(0, 2.0)), case=refined)])
    assert found == ("drawn", "theory: second order")
    curve = Curve("error", (4, 2), [0.3 / 16, 0.3 / 4])
    assert curves == [([curve], "intervals along an edge", 0.0)]


def test_the_modelling_errors_have_a_page(few, own_store, tmp_path):
    """All calibrations, each number with its errors and the devices that are worst."""
    index = book.write_book(run("quick"), tmp_path, lambda _: None)
    assert 'href="modelling.html"' in index.read_text("utf-8")
    text = (tmp_path / "modelling.html").read_text("utf-8")
    for heading in ("Stiff cores", "Two to five layers", "Straight magnet", "Saturating steels"):
        assert heading in text
    assert text.count("bimorph.length=20.0mm") == 30


def test_what_was_found_under_faults_is_in_the_index(few, monkeypatch, tmp_path):
    """A row a fault: how, how many runs, how many refused."""
    family = Family("faults")
    family.refuse("no room", of="no room on the disk: 3 commands, small files")
    family.add("init", 0.0, 0.0, of="no room on the disk: 3 commands, small files")
    monkeypatch.setattr(book, "cached_rows", lambda: rows(family.answers, RULE))
    page = book.write_book(run("quick"), tmp_path, lambda _: None).read_text()
    cells = re.findall(r"<td[^>]*>([^<]*)</td>", page.partition('id="faults"')[2])
    assert cells == [
        "no room on the disk", "3 commands, small files", "1", "1", "holds or says why not",
    ]  # fmt: skip
