"""How far a report can be trusted: counts from its own rows and from the verification book."""

from __future__ import annotations

import math
from typing import NamedTuple

from tactgen.validation.catalogue.models import MODELS
from tactgen.validation.evidence.verification import recalled_rows
from tactgen.validation.models.comparison import Cell
from tactgen.validation.report.sections.section import Context
from tactgen.validation.report.study import Study

#: Groups of known answers about each actuator.
_KNOWN = {
    "bimorph": ("beams", "laminates", "resonators", "elastic", "bimorph"),
    "reluctance": ("coils", "iron", "reluctance"),
}


class Count(NamedTuple):
    """One question, its answer, and whether it speaks for the report: pass, explained or fail."""

    question: str
    answer: str
    status: str


def credibility_section(study: Study) -> Context:
    """Counts."""
    return {
        "counts": [
            _code(study), _numerical_error(study), _same_theory(study), _other_theory(study),
            _measured(study), _parameters(study),
        ]
    }  # fmt: skip


def _code(study: Study) -> Count:
    """Known answers, as far as this code has been run on them."""
    groups = [
        group
        for actuator, own in _KNOWN.items()
        if any(MODELS[name].actuator == actuator for name in study.scene.models)
        for group in own
    ]
    verdicts = [row.verdict for row in recalled_rows(groups)]
    held, failed = verdicts.count("pass"), verdicts.count("fail")
    explained = verdicts.count("explained")
    missing = len(verdicts) - held - failed - explained
    status = "fail" if failed else "explained" if missing else "pass"
    return Count(
        "Does this code reproduce known answers?",
        f"{held} of {len(verdicts)} are reproduced, {explained} are missed for a stated reason, "
        f"{failed} fail, {missing} were not run with this code (tactgen verify --heavy).",
        status,
    )


def _numerical_error(study: Study) -> Count:
    """Numbers of the most detailed model against the accuracy that the scene asks for."""
    cells = [row.cells[-1] for row in study.compared if math.isfinite(row.cells[-1].value)]
    wide = sum(not cell.error <= study.scene.accuracy * abs(cell.value) for cell in cells)
    return Count(
        "Is the numerical error within the accuracy asked for?",
        f"For {len(cells) - wide} of {len(cells)} numbers of the most detailed model "
        f"({100.0 * study.scene.accuracy:g} %).",
        "explained" if wide else "pass",
    )


def _same_theory(study: Study) -> Count:
    """Models of one theory must agree within their errors."""
    differ = sum(cell.verdict == "differs" for cell in _cells(study))
    return Count(
        "Do models of one theory agree within their errors?",
        f"{differ} of {len(_cells(study))} numbers differ by more." if differ else "All do.",
        "fail" if differ else "pass",
    )


def _other_theory(study: Study) -> Count:
    """Difference between theories: a modelling difference, whatever its cause."""
    theories = {MODELS[name].theory for name in study.scene.models}
    apart = [abs(c.difference) for c in _cells(study) if math.isfinite(c.difference)]
    if len(theories) < 2 or not apart:
        return Count("How far apart are theories?", "One theory was asked.", "explained")
    return Count(
        "How far apart are theories?",
        f"{100.0 * max(apart):.2g} % at most, {100.0 * sorted(apart)[len(apart) // 2]:.2g} % in "
        "the median.",
        "explained",
    )


def _measured(study: Study) -> Count:
    """Measurements of this very device: a miss counts as a miss, with a reason or without."""
    found = [o.status for o in study.outcomes if o.check.tier == "validation"]
    if not found:
        return Count("Was this device measured?", "No measurement of it is known.", "explained")
    missed = len(found) - found.count("pass")
    return Count(
        "Was this device measured?",
        f"{found.count('pass')} of {len(found)} measurements are reproduced, {missed} are missed, "
        f"{found.count('explained')} of these for a stated reason.",
        "fail" if "fail" in found else "explained" if missed else "pass",
    )


def _parameters(study: Study) -> Count:
    """Parameters that nobody but this project vouches for."""
    assumed = [row.key for row in study.parameters if row.assumed]
    listed = ", ".join(assumed[:6]) + (" …" if len(assumed) > 6 else "")
    return Count(
        "Are the parameters known?",
        f"{len(assumed)} of {len(study.parameters)} are assumed"
        + (f": {listed}." if assumed else "."),
        "explained" if assumed else "pass",
    )


def _cells(study: Study) -> list[Cell]:
    return [cell for row in study.compared for cell in row.cells if math.isfinite(cell.value)]
