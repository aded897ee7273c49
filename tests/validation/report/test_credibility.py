"""Levels of credibility follow from rows: each moves when what it is earned by moves."""

from types import SimpleNamespace

import pytest

from tactgen.validation.catalogue.quantities import COUPLING_FACTOR, STATIC_TIP_DISPLACEMENT
from tactgen.validation.checks import verification
from tactgen.validation.checks.row import Check, Outcome
from tactgen.validation.checks.verification import GROUPS, Verified, group_cases
from tactgen.validation.models.comparison import Cell, ComparedRow
from tactgen.validation.report.credibility.evidence import SPEAKS_FOR, Evidence, known_rows
from tactgen.validation.report.credibility.factors import factors
from tactgen.validation.report.credibility.levels import Criterion, Factor, overall
from tactgen.validation.scene.parameter_list import ParameterRow

NAMES = ("code", "solution", "validation", "pedigree", "uncertainty", "robustness", "history")


def known(name, models_case, *, heavy=False, status="pass"):
    """Return a row of the group bimorph, as ``tactgen verify`` gives it."""
    check = Check(name, "code verification", "", 1.0, "1", "", 0.0, "", float, heavy=heavy)
    outcome = None if status is None else Outcome(check, 1.0, 0.0, status)
    return Verified("bimorph", SimpleNamespace(id=models_case), check, outcome, 0.0)


def compared(row, *, share=1e-4, verdict="agrees"):
    cells = (
        Cell("tmm", 1.0, share, 0.0, verdict, ""),
        Cell("solid", 1.0, share, 0.0, "reference", ""),
    )
    return ComparedRow(row, cells)


def measured(name, status):
    check = Check(name, "validation", "", 1.0, "1", "", 0.0, "", float)
    return Outcome(check, 1.0, 0.0, status)


def spread(label, **shares):
    target = SimpleNamespace(label=label)
    total = {key: (share, 0.0) for key, share in shares.items()}
    return SimpleNamespace(target=target, total=total, slopes=total)


PRINTED = tuple(ParameterRow(key, "", "", "paper, table 1") for key in "abcdefghij")
#: Evidence that earns all there is.
FULL = Evidence(
    models=("tmm", "solid"),
    accuracy=1e-3,
    known=(known("TMM-1", "TMM"), known("SOL-1", "SOL"), known("SOL-3", "SOL", heavy=True)),
    compared=(compared(STATIC_TIP_DISPLACEMENT), compared(COUPLING_FACTOR)),
    outcomes=(measured("PAP-1", "pass"),),
    as_it_stands=True,
    parameters=PRINTED,
    uncertainties=(spread("deflection", **dict.fromkeys("abcdefghi", 0.1)),),
    both_bars=1,
    stressed=(SimpleNamespace(family="static limit", verdict="holds"),),
)


def levels(evidence):
    return dict(zip(NAMES, (factor.level for factor in factors(evidence)), strict=True))


def test_full_evidence_earns_everything_but_a_history():
    """No program knows what was decided by it: level 1 is the most that it claims."""
    found = levels(FULL)
    assert found == dict.fromkeys(NAMES, 4) | {"history": 1}
    assert overall(factors(FULL)) == 1


def test_no_evidence_earns_nothing():
    """Each factor is at 0, and says what would raise it."""
    nothing = factors(Evidence(models=("tmm",), accuracy=1e-3))
    assert {factor.level for factor in nothing} == {0}
    assert all(factor.next is not None and factor.next.remedy for factor in nothing)


SV, PAP = STATIC_TIP_DISPLACEMENT, "PAP-1"


def test_a_level_counts_only_with_all_below():
    """A met criterion above one that is not met earns nothing."""
    yes, no = (Criterion("asked", "found", met, "remedy") for met in (True, False))
    factor = Factor("name", (yes, no, yes))
    assert factor.level == 1
    assert factor.next is no


def test_every_known_answer_speaks_for_its_models():
    """No group of code verification is left out of the levels."""
    assert set(SPEAKS_FOR) == set(GROUPS)
    silent = {
        (group, case.id)
        for group in GROUPS
        for case in group_cases(group)
        if any(row.tier == "code verification" for row in case.rows)
        and not {case.id, ""} & set(SPEAKS_FOR[group])
    }
    # motion, amplitude and a display's array are no models of a scene, and misprints are about the
    # literature
    assert {group for group, _ in silent} <= {"motion", "amplitude", "display", "misprints"}


def test_a_quick_report_counts_what_was_verified_before(own_store, monkeypatch):
    """Nothing is run for it; what has run with this code is found again."""
    one = group_cases("beams")[:1]
    monkeypatch.setattr(verification, "group_cases", lambda group: one if group == "beams" else ())
    before = known_rows(("lumped",), quick=True, announce=lambda _: pytest.fail("ran"))
    assert {row.verdict for row in before} == {"skipped"}
    ran = known_rows(("lumped",), quick=False, announce=lambda _: None)
    after = known_rows(("lumped",), quick=True, announce=lambda _: pytest.fail("ran"))
    held = [row.check.id for row in after if row.verdict == "pass"]
    assert held
    assert held == [row.check.id for row in ran if row.verdict == "pass"]
