"""The suite's own checks run as one job: rows with a verdict, for people and for programs.

What a row measures is kept in the store by the code that measures it, so a second run does only
what changed; a failure is never served, but measured anew.
"""

from __future__ import annotations

import importlib
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any, Literal

from tactgen.geometry.store.store import kept, recalled
from tactgen.validation.checks.case import Case
from tactgen.validation.checks.problems import PROBLEMS, Problem
from tactgen.validation.checks.row import Check, Outcome, judged

Verdict = Literal["pass", "fail", "explained", "calibrated", "skipped"]
#: How much is run: the first row of each case, all that are light, or the heavy ones as well.
Extent = Literal["quick", "light", "heavy"]

_KNOWN = "tactgen.validation.checks.known."
#: What rows on scenes run without importing it by name.
_ENGINE = (
    "tactgen.validation.models",
    "tactgen.validation.catalogue",
    "tactgen.fem",
    "tactgen.tmm",
)

#: Where the rows or cases of each group are declared; a group is imported when it is asked for.
GROUPS: dict[str, tuple[str, str]] = {
    "beams": (_KNOWN + "beams", "CASES"),
    "laminates": (_KNOWN + "laminates", "CASES"),
    "resonators": (_KNOWN + "resonators", "CASES"),
    "elastic": (_KNOWN + "elastic", "CASES"),
    "coils": (_KNOWN + "coils", "CASES"),
    "iron": (_KNOWN + "iron", "CASES"),
    "orders": (_KNOWN + "orders", "CASES"),
    "bimorph": ("tactgen.validation.checks.bimorph", "CHECKS"),
    "reluctance": ("tactgen.validation.checks.reluctance", "MAGNETIC_CHECKS"),
    "motion": ("tactgen.validation.checks.motion", "MOTION_CHECKS"),
    "amplitude": ("tactgen.validation.checks.amplitude", "AMPLITUDE_CHECKS"),
    "display": ("tactgen.validation.checks.display", "DISPLAY_CHECKS"),
    "misprints": (_KNOWN + "misprints", "CASES"),
}


@dataclass(frozen=True)
class Verified:
    """A row with what came out; `outcome` and `seconds` are None where it was skipped."""

    group: str
    case: Case
    check: Check
    outcome: Outcome | None
    seconds: float | None

    @property
    def verdict(self) -> Verdict:
        """The verdict in one word."""
        if self.outcome is None:
            return "skipped"
        explained = self.outcome.status == "differs, explained"
        return "explained" if explained else self.outcome.status  # type: ignore[return-value]

    @property
    def test(self) -> str:
        """The test that runs the same row."""
        known = ".known." in GROUPS[self.group][0]
        file = "known/test_known_rows.py" if known else "test_checks.py"
        return f"tests/validation/checks/{file}::test_row[{self.check.id}]"

    def plain(self) -> dict[str, Any]:
        """Return the row as plain values; what is not known of a skipped one is None."""
        check, found = self.check, self.outcome
        return {
            "id": check.id,
            "group": self.group,
            "case": self.case.id,
            "tier": check.tier,
            "requirement": check.requirement,
            "unit": check.unit,
            "measured": None if found is None else found.measured,
            "reference": check.reference,
            "deviation": None if found is None else found.deviation,
            "source": check.source,
            "tolerance": check.tolerance,
            "reason": check.reason,
            "verdict": self.verdict,
            "explained": check.explained,
            "calibrated": check.calibrated,
            "seconds": self.seconds,
            "test": self.test,
        }


def group_cases(group: str) -> tuple[Case, ...]:
    """Return the cases of a group; rows without one are gathered by the letters of their ids."""
    module, name = GROUPS[group]
    declared: tuple[Case | Check, ...] = getattr(importlib.import_module(module), name)
    gathered: dict[str, Case] = {}
    for entry in declared:
        found = entry if isinstance(entry, Case) else _alone(group, entry)
        known = gathered.get(found.id)
        if known is not None:
            found = replace(known, rows=known.rows + found.rows)
        gathered[found.id] = found
    return tuple(gathered.values())


def _alone(group: str, row: Check) -> Case:
    """Return a case of one row that was declared without one: its family's problem."""
    family = row.id.rpartition("-")[0]
    problem = PROBLEMS.get((group, family), Problem(row.requirement, "", ""))
    title, about, model, setup = problem
    return Case(family, title, about, model, (row,), setup=setup)


def group_rows(group: str) -> tuple[Check, ...]:
    """Return the checks of a group."""
    return tuple(row for found in group_cases(group) for row in found.rows)


def verify(
    groups: Sequence[str], *, extent: Extent, announce: Callable[[str], None]
) -> list[Verified]:
    """Run the checks of the groups, as many of them as `extent` says; the others are skipped."""
    found = []
    for group in groups:
        for case in group_cases(group):
            for check in case.rows:
                wanted = check is case.rows[0] if extent == "quick" else True
                if not wanted or (check.heavy and extent != "heavy"):
                    found.append(Verified(group, case, check, None, None))
                    continue
                announce(f"check {check.id}")
                measured, seconds = remembered(
                    group, "row", check.id, check.measure,
                    serves=partial(_holds, check),
                )  # fmt: skip
                found.append(Verified(group, case, check, judged(check, measured), seconds))
    return found


def recalled_rows(groups: Sequence[str]) -> list[Verified]:
    """Return the groups' checks as far as this very code has run and kept them; others skipped."""
    found = []
    for group in groups:
        for case in group_cases(group):
            for check in case.rows:
                kept_row: tuple[float, float] | None = recalled(*_entry(group, "row", check.id))
                outcome, seconds = None, None
                if kept_row is not None:
                    measured, seconds = kept_row
                    outcome = judged(check, measured)
                found.append(Verified(group, case, check, outcome, seconds))
    return found


def _holds(check: Check, measured: float) -> bool:
    return judged(check, measured).status != "fail"


def remembered(
    group: str,
    kind: str,
    name: str,
    measure: Callable[[], float],
    *,
    serves: Callable[[float], bool] = lambda _: True,
) -> tuple[float, float]:
    """Return a measured value and the seconds that it took, from the store if the code is the same.

    `name` must tell it from all others of its kind.
    """

    def work() -> tuple[float, float]:
        started = time.perf_counter()
        return float(measure()), time.perf_counter() - started

    value, seconds = kept(*_entry(group, kind, name), work, serves=lambda both: serves(both[0]))
    return value, seconds


def _entry(group: str, kind: str, name: str) -> tuple[str, tuple[str, str], tuple[str, ...]]:
    """Return kind, inputs and code that a measured value goes by in the store."""
    module = GROUPS[group][0]
    code = (module,) if ".known." in module else (module, *_ENGINE)
    return f"check.{kind}", (group, name), code
