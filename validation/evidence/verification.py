"""The suite's own checks run as one job: rows with a verdict, for people and for programs.

What a row measures is kept in the store by the code that measures it, so a second run does only
what changed; a failure is never served, but measured anew.  Its error bar is that of the model, or
where that states none, by how much the value changes on the next coarser division.
"""

from __future__ import annotations

import importlib
import math
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any, Literal, get_args

from tactgen.geometry.errors import InputError
from tactgen.geometry.store.store import kept, recalled
from tactgen.geometry.store.values import storable
from tactgen.validation.engine.results import Estimate
from tactgen.validation.evidence.case import (
    PROBLEMS,
    Case,
    Check,
    Outcome,
    Problem,
    judged,
    value_of,
)
from tactgen.validation.evidence.mesh_levels import Kind, on_level

Verdict = Literal["pass", "explained", "fail", "skipped"]
#: All verdicts, in the order in which they are counted.
VERDICTS: tuple[Verdict, ...] = get_args(Verdict)
#: How much is run: the first row of each case, all that are light, or the heavy ones as well.
Extent = Literal["quick", "light", "heavy"]

_CASES = "tactgen.validation.evidence.cases."
#: What rows on scenes run without importing it by name.
_ENGINE = (
    "tactgen.validation.models",
    "tactgen.validation.catalogue",
    "tactgen.fem",
    "tactgen.tmm",
)

#: Groups of known answers, each a module of the room of cases, imported when it is asked for.
GROUPS = (
    "beams", "laminates", "resonators", "elastic", "coils", "iron", "orders", "bimorph",
    "reluctance", "motion", "amplitude", "display", "misprints",
)  # fmt: skip
#: Of these, those whose rows are about scenes, solved by the whole suite.
ON_SCENES = ("bimorph", "reluctance", "motion", "amplitude", "display")


@storable
@dataclass(frozen=True)
class Division:
    """Measurement of a row on one level of fineness (:mod:`validation.evidence.mesh_levels`).

    Attributes
    ----------
    value, bar : float
        In the row's unit; `bar` is the model's own, nan where it states none.
    """

    below: int  #: How many levels coarser than the case's own; below 0 finer
    value: float
    error: float
    kinds: tuple[tuple[str, ...], ...]  #: How it is divided; empty where nothing is
    new: bool  #: Whether it differs from the next level towards the case's own
    count: int  #: The most unknowns, or steps; 0 where they were not counted
    seconds: float  #: How long it took

    @property
    def kind(self) -> Kind | None:
        """Kind of division; of several the first by name."""
        return Kind(*self.kinds[0]) if self.kinds else None

    @property
    def words(self) -> str:
        """Difference from the next finer level, in words."""
        assert self.kind is not None
        return self.kind.coarser if self.below > 0 else self.kind.finer


@dataclass(frozen=True)
class Bar:
    """Error in the row's unit, and its basis."""

    size: float
    judged_by: str


@dataclass(frozen=True)
class Verified:
    """Row with its result; `outcome` and `found` are None where it was skipped."""

    group: str
    case: Case
    check: Check
    outcome: Outcome | None = None
    found: Division | None = None
    error: Bar | None = None

    @property
    def seconds(self) -> float | None:
        """Elapsed time (s)."""
        return None if self.found is None else self.found.seconds

    @property
    def covered_by(self) -> Literal["", "bar", "bar and tolerance"]:
        """Error that covers the deviation; "" where the row has none."""
        if self.outcome is None or self.error is None:
            return ""
        nearest = _nearest(self.outcome)
        beyond = abs(self.outcome.measured - nearest) - self.error.size
        if beyond <= 0.0:
            return "bar"
        return "bar and tolerance" if beyond <= self.check.tolerance * abs(nearest) else ""

    @property
    def verdict(self) -> Verdict:
        """The verdict in one word."""
        return "skipped" if self.outcome is None else self.outcome.status

    @property
    def test(self) -> str:
        """The test that runs the same row."""
        file = "test_checks.py" if self.group in ON_SCENES else "test_known_rows.py"
        return f"tests/validation/evidence/{file}::test_row[{self.check.id}]"

    def plain(self) -> dict[str, Any]:
        """Row as plain values; None for unknowns of a skipped one."""
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
            "bar": None if self.error is None else self.error.size,
            "bar_judged_by": None if self.error is None else self.error.judged_by,
            "covered_by": None if self.error is None else self.covered_by,
            "deviation": None if found is None else found.deviation,
            "source": check.source,
            "tolerance": check.tolerance,
            "reason": check.reason,
            "verdict": self.verdict,
            "explained": check.explanation,
            "seconds": self.seconds,
            "test": self.test,
        }


def group_cases(group: str) -> tuple[Case, ...]:
    """Cases of a group; rows without one are gathered by the letters of their ids."""
    declared: tuple[Case | Check, ...] = importlib.import_module(_CASES + group).CASES
    gathered: dict[str, Case] = {}
    for entry in declared:
        found = entry if isinstance(entry, Case) else _alone(group, entry)
        known = gathered.get(found.id)
        if known is not None:
            found = replace(known, rows=known.rows + found.rows)
        gathered[found.id] = found
    return tuple(gathered.values())


def _alone(group: str, row: Check) -> Case:
    """Case of one row that was declared without one: its family's problem."""
    family = row.id.rpartition("-")[0]
    problem = PROBLEMS.get((group, family), Problem(row.requirement, "", ""))
    title, about, model = problem
    return Case(family, title, about, model, (row,))


def group_rows(group: str) -> tuple[Check, ...]:
    """Checks of a group."""
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
                    found.append(Verified(group, case, check))
                    continue
                announce(f"check {check.id}")
                measured = division(group, case, check)
                outcome, bar = judged(check, measured.value), _bar(group, case, check, measured)
                found.append(Verified(group, case, check, outcome, measured, bar))
    return found


def _bar(group: str, case: Case, check: Check, measured: Division) -> Bar | None:
    """Row's bar; None where nothing is divided, and of a row that is an error itself."""
    if math.isfinite(measured.error):
        return Bar(measured.error, "the model's own")
    if measured.kind is None or case.refinement is not None:
        return None
    other = next_division(group, case, check)
    if other is None:
        return None
    return Bar(abs(measured.value - other.value), f"the change with {other.words}")


def next_division(group: str, case: Case, check: Check) -> Division | None:
    """Measurement of a row on the next coarser level.

    Where there is none, as of linear functions that contain the answer, on the next finer one.
    """
    for below in (1, -1):
        found = division(group, case, check, below)
        if found.new:
            return found
    return None


def division(group: str, case: Case, check: Check, below: int = 0) -> Division:
    """Measurement of a row so many levels coarser, cached by code.

    A level that its model refuses as too coarse is none.
    """

    def work() -> Division:
        started = time.perf_counter()
        with on_level(below) as run:
            try:
                measured = check.measure()
            except InputError:
                if below == 0:
                    raise
                return Division(below, math.nan, math.nan, (), False, 0, 0.0)
        bar = measured.error if isinstance(measured, Estimate) else math.nan
        kinds = tuple(sorted(tuple(kind) for kind in run.kinds))
        seconds = time.perf_counter() - started
        return Division(below, value_of(measured), bar, kinds, run.new, run.count, seconds)

    return kept(
        *_entry(group, "row", f"{check.id} {below}" if below else check.id), work,
        serves=lambda found: below > 0 or _holds(check, found.value),
    )  # fmt: skip


def _nearest(outcome: Outcome) -> float:
    """Reference, or of a range the point nearest to the measured value."""
    reference = outcome.check.reference
    ends = reference if isinstance(reference, tuple) else (reference, reference)
    return min(max(outcome.measured, ends[0]), ends[1])


def recalled_rows(groups: Sequence[str]) -> list[Verified]:
    """Groups' checks as far as this very code has run and kept them; others skipped."""
    found = []
    for group in groups:
        for case in group_cases(group):
            for check in case.rows:
                held: Division | None = recalled(*_entry(group, "row", check.id))
                outcome = None if held is None else judged(check, held.value)
                found.append(Verified(group, case, check, outcome, held))
    return found


def _holds(check: Check, measured: float) -> bool:
    return judged(check, measured).status != "fail"


def remembered(group: str, name: str, error: Callable[[], float]) -> float:
    """Error of a case's own refinement, from the store if the code is the same."""
    return kept(*_entry(group, "level", name), error)


def _entry(group: str, kind: str, name: str) -> tuple[str, tuple[str, str], tuple[str, ...]]:
    """Kind, inputs and code that a measured value goes by in the store."""
    module = _CASES + group
    code = (module, *_ENGINE) if group in ON_SCENES else (module,)
    return f"check.{kind}", (group, name), code
