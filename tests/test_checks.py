"""The declarative rows that the report shows, run as tests."""

from dataclasses import replace

import pytest

from validation.checks import CHECKS, run_check


@pytest.mark.parametrize(
    "check",
    [pytest.param(c, id=c.id, marks=[pytest.mark.heavy] if c.heavy else []) for c in CHECKS],
)
def test_row(check):
    """Each row passes, or differs for the reason that it states."""
    outcome = run_check(check)
    expected = {"pass", "differs, explained"} if check.explained else {"pass"}
    assert outcome.status in expected, f"{outcome.measured} against {check.reference}"


def test_ids_are_unique_and_rows_complete():
    """A row that lacks a source or a reason for its tolerance is no check."""
    assert len({c.id for c in CHECKS}) == len(CHECKS)
    assert all(c.source and c.reason and c.requirement.endswith(".") for c in CHECKS)


def test_explained_rows_can_fail():
    """An explanation covers one known deviation: any other, or none, or nan, is a failure."""
    for check in CHECKS:
        if check.explained:
            assert abs(check.known) > check.tolerance
            for factor in (1.0 + check.known + 0.1, float("nan")):
                moved = replace(check, measure=lambda f=factor, c=check: f * c.reference)
                assert run_check(moved).status == "fail"
