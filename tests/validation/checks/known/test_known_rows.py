"""Every row of the cases with known answers, run as a test."""

import pytest
from approved import measured_text

from tactgen.validation.checks.row import run_check
from tactgen.validation.checks.verification import GROUPS, group_cases

KNOWN = [group for group, (module, _) in GROUPS.items() if ".known." in module]
CASES = [case for group in KNOWN for case in group_cases(group)]
#: Rows that cost a second and whose like stays: NAGAOKA-3 is a solenoid of another length, VM168-2
#: the same field farther away; SHELL's mesh is SPHEROID's; CARTER-2 is a slot of another width.
_LIKE = ("NAGAOKA-1", "NAGAOKA-5", "VM168-1", "SPHEROID-1", "CARTER-1", "CARTER-3", "CARTER-4")


@pytest.mark.parametrize(
    "check",
    [
        pytest.param(
            row, id=row.id, marks=[pytest.mark.heavy] if row.heavy or row.id in _LIKE else []
        )
        for case in CASES
        for row in case.rows
    ],
)
def test_row(check, approved_line):
    """Each row passes; one that is known to differ differs as it says, and does not pass."""
    outcome = run_check(check)
    expected = "differs, explained" if check.explained else "pass"
    assert outcome.status == expected, f"{outcome.measured} against {check.reference}"
    approved_line(measured_text(outcome))


def test_cases_are_complete():
    """A case says what the problem is and what solves it; rows have reasons, ids are unique."""
    assert len({case.id for case in CASES}) == len(CASES)
    assert set(_LIKE) < {row.id for case in CASES for row in case.rows}
    for case in CASES:
        assert case.title, case.id
        assert case.problem.endswith("."), case.id
        assert case.model, case.id
        assert case.rows, case.id
        for row in case.rows:
            assert row.requirement.endswith("."), row.id
            assert row.source, row.id
            assert row.reason, row.id
            # a tolerance of 0 needs a range
            assert row.tolerance > 0.0 or isinstance(row.reference, tuple), row.id


def test_refinements_approach_the_answer():
    """The finest level of the cheap refinements is nearer to the reference than the coarsest."""
    for case in CASES:
        found = case.refinement
        if found is None or case.id not in ("CYL2", "ROD", "TE", "BEAMO", "AXIO", "MMSE"):
            continue
        values = [found.solve(level)[1] for level in found.levels]
        if not found.of_error:
            reference = case.rows[0].reference
            values = [abs(value / reference - 1.0) for value in values]
        assert values[-1] < 0.1 * values[0], case.id
