"""Levels of credibility follow from rows: each moves when what it is earned by moves."""

import math
from dataclasses import replace
from types import SimpleNamespace

import pytest
from approved import described

from tactgen.validation.catalogue.bimorph import COUPLING_FACTOR, STATIC_TIP_DISPLACEMENT
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


ASSUMED = (*PRINTED[:-1], ParameterRow("j", "", "", "assumed"))
FIRST_ASSUMED = (ParameterRow("a", "", "", "assumed"), *PRINTED[1:])
SV, PAP = STATIC_TIP_DISPLACEMENT, "PAP-1"


@pytest.mark.parametrize(
    ("factor", "level", "changed"),
    [
        ("code", 3, {"known": (*FULL.known[:2], known("SOL-3", "SOL", heavy=True, status=None))}),
        ("code", 2, {"known": (*FULL.known[:2], known("SOL-2", "SOL", status=None))}),
        ("code", 1, {"known": FULL.known[:1]}),  # the solid has no known answer
        ("code", 1, {"known": (*FULL.known, known("TMM-2", "TMM", status="fail"))}),
        ("code", 0, {"known": (known("TMM-1", "TMM", status=None),)}),
        ("solution", 3, {"compared": (compared(SV), compared(COUPLING_FACTOR, share=2e-3))}),
        ("solution", 2, {"compared": (compared(SV, share=2e-3),)}),
        ("solution", 1, {"compared": (compared(SV, verdict="differs"),)}),
        ("solution", 0, {"compared": (compared(SV, share=math.nan),)}),
        ("validation", 3, {"outcomes": (*FULL.outcomes, measured("PAP-2", "explained"))}),
        ("validation", 2, {"outcomes": (*FULL.outcomes, measured("PAP-2", "fail"))}),
        ("validation", 2, {"outcomes": (), "as_it_stands": False}),
        ("validation", 1, {"compared": (compared(SV, verdict="model form"),)}),
        ("validation", 0, {"compared": (compared(SV, verdict="differs"),)}),
        ("validation", 0, {"models": ("tmm", "lumped")}),  # both are beams
        ("pedigree", 3, {"parameters": ASSUMED}),
        ("pedigree", 2, {"parameters": FIRST_ASSUMED}),
        ("pedigree", 1, {"parameters": FIRST_ASSUMED, "uncertainties": (spread("f", a=0.8),)}),
        ("pedigree", 1, {"uncertainties": ()}),
        ("pedigree", 0, {"parameters": (ParameterRow("a", "", "", ""),)}),
        ("uncertainty", 3, {"both_bars": 0}),
        ("uncertainty", 2, {"uncertainties": (*FULL.uncertainties, spread("not sampled"))}),
        ("uncertainty", 1, {"uncertainties": ()}),
        ("robustness", 3, {"uncertainties": (spread("f", **dict.fromkeys("abcdef", 0.1)),)}),
        ("robustness", 2, {"uncertainties": (spread("f", a=1.0),)}),
        ("robustness", 1, {"uncertainties": ()}),
        ("robustness", 0, {"stressed": (SimpleNamespace(family="static", verdict="fails"),)}),
        ("history", 0, {"outcomes": (measured("PAP-1", "fail"),)}),
    ],
)
def test_a_level_falls_with_its_evidence(factor, level, changed, approved_line):
    """One thing taken away, and the factor stands where the row below it ends, and says why."""
    found = next(f for n, f in zip(NAMES, factors(replace(FULL, **changed)), strict=True)
                 if n == factor)  # fmt: skip
    told = [f"{'met' if c.met else 'not met'}: {c.found}" for c in found.criteria]
    approved_line(" | ".join([str(found.level), *told]))
    assert levels(replace(FULL, **changed))[factor] == level


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


#: What earns little, each for a reason of its own; more of a kind than are named.
MIXED = replace(
    FULL,
    accuracy=0.02,
    known=(
        *(known(f"TMM-{n}", "TMM", status="fail") for n in range(6)), known("SOL-1", "SOL"),
        known("SOL-2", "SOL", status=None), known("SOL-3", "SOL", heavy=True, status=None),
    ),
    compared=(
        compared(STATIC_TIP_DISPLACEMENT, share=0.03), compared(COUPLING_FACTOR, verdict="differs"),
        compared(COUPLING_FACTOR, share=math.nan), compared(COUPLING_FACTOR, verdict="model form"),
    ),
    outcomes=tuple(measured(f"PAP-{n}", s) for n, s in enumerate(("pass", "explained", "fail"))),
    parameters=(*ASSUMED[:5], ParameterRow("x", "", "", ""), ParameterRow("b", "", "", "assumed")),
    uncertainties=(
        spread("mostly assumed", b=0.6, a=0.4, c=-0.5), spread("half", b=0.5, a=0.5),
        spread("little", b=0.05, a=0.95), spread("less", b=0.049, a=1.0), spread("not sampled"),
    ),
    both_bars=4,
    stressed=tuple(
        SimpleNamespace(family=name, verdict=verdict)
        for name, verdict in (("static", "holds"), ("slender", "fails"), ("stout", "refuses"))
    ),
)  # fmt: skip


@pytest.mark.parametrize("name", ["full", "mixed", "none", "changed scene"])
def test_all_that_the_factors_say(name, approved):
    """What is asked, found and would help, and which rows it rests on."""
    evidence = {
        "full": FULL, "mixed": MIXED, "none": Evidence(models=("tmm",), accuracy=1e-3),
        "changed scene": replace(FULL, as_it_stands=False, models=("tmm", "network")),
    }[name]  # fmt: skip
    approved(described(factors(evidence)))
