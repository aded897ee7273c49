"""The suite's own checks run as one job: rows with a verdict, for people and for programs.

What a row measures is cached by the code that measures it, so a second run does only what changed;
a failure is never served, but measured anew.  Its error bar is that of the model, or where that
states none, by how much the value changes on the next coarser division.
"""

from __future__ import annotations

import importlib
import math
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, Literal, get_args

from tactgen.geometry.errors import InputError
from tactgen.geometry.store.store import cached_result
from tactgen.geometry.store.values import storable
from tactgen.validation.evidence.case import Case, Check, Outcome, judged, value_of
from tactgen.validation.evidence.mesh_levels import Kind, on_level
from tactgen.validation.models.model import Estimate

Verdict = Literal["pass", "explained", "fail", "skipped"]
#: All verdicts, in the order in which they are counted.
VERDICTS: tuple[Verdict, ...] = get_args(Verdict)
#: How much is run: the first row of each case, all that are light, or the heavy ones as well.
Extent = Literal["quick", "light", "heavy"]

_CASES = "tactgen.validation.evidence.cases."
#: What computes the answers on scenes and is loaded by names in strings.
ENGINE = (
    "tactgen.validation.models", "tactgen.validation.catalogue", "tactgen.fem", "tactgen.tmm",
)  # fmt: skip

#: Groups of known answers, each a module of the room of cases, imported when it is asked for; and
#: what each is about, for the reader who was not there.
GROUPS = {
    "beams": "Beams in closed form and from handbooks, by the models lumped and tmm; two as solids",
    "laminates": "Exact laminates in cylindrical bending, bimetal strips, PVDF, a patch in shear",
    "resonators": "Piezoelectric resonators of IEEE Std 176, patch test of a free block",
    "elastic": "Elastic bodies: cube, plates, torsion, rods",
    "coils": "Coils in air: inductance, force, field, circuit",
    "iron": "Bodies of iron: shielding, demagnetising factor, a slotted gap",
    "orders": "Observed orders of convergence, each with an absolute bound",
    "bimorph": "The lateral actuator: exact beam, job J1, models against each other, the paper",
    "reluctance": "The normal actuator: fields and circuits, TEAM problem 20, the paper",
    "motion": "The machine in time: oscillators with known motions, circuits, the paper's Fig 16",
    "amplitude": "Large amplitudes: oscillators with known answers, the paper's Figs 8, 14 and 15",
    "display": "The display: crosstalk, units that differ, the field between units, what fits",
    "devices": "Benders and harvesters that others built and measured, beside bands over all that "
    "their sources leave open; the actuator of TEAM problem 20 is among the reluctance actuators",
    "misprints": "Printed targets that are wrong or coarse, with the proof",
}
#: Of these, those whose rows are about scenes, solved by the whole suite.
ON_SCENES = ("bimorph", "reluctance", "motion", "amplitude", "display", "devices")


@storable
@dataclass(frozen=True)
class Division:
    """A row's value on one level of fineness (:mod:`validation.evidence.mesh_levels`)."""

    below: int  # how many levels coarser than the case's own; below 0 finer
    value: float  # in the row's unit
    error: float  # the model's own bar; nan where it states none
    kinds: tuple[tuple[str, ...], ...]  # how it is divided; empty where nothing is
    new: bool  # whether it differs from the next level towards the case's own
    count: int  # the most unknowns, or steps; 0 where they were not counted
    seconds: float

    @property
    def estimate(self) -> Estimate:
        """Value with its model's own bar."""
        return Estimate(self.value, self.error)

    @property
    def kind(self) -> Kind | None:
        """How it is divided; of several ways the first by name."""
        return Kind(*self.kinds[0]) if self.kinds else None

    @property
    def words(self) -> str:
        """What is different from the next level towards the case's own."""
        assert self.kind is not None
        return self.kind.coarser if self.below > 0 else self.kind.finer


@dataclass(frozen=True)
class Verified:
    """A row with what came out; `outcome` and `found` are None where it was skipped."""

    group: str
    case: Case
    check: Check
    outcome: Outcome | None = None
    found: Division | None = None
    bar: Estimate | None = None  # the value with its error in the row's unit, and its method

    @property
    def covered_by(self) -> Literal["", "bar", "bar and tolerance"]:
        """What covers the deviation; nothing where the row has no bar."""
        if self.outcome is None or self.bar is None:
            return ""
        low, high = self.check.ends
        nearest = min(max(self.outcome.measured, low), high)
        beyond = abs(self.outcome.measured - nearest) - self.bar.error
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
        return f"tests/validation/evidence/test_rows.py::test_row[{self.check.id}]"

    def plain(self) -> dict[str, Any]:
        """Row as plain values; what is not known of a skipped one is None."""
        check, outcome, bar = self.check, self.outcome, self.bar
        return {
            "id": check.id, "group": self.group, "case": self.case.id, "tier": check.tier,
            "requirement": check.requirement, "unit": check.unit,
            "measured": None if outcome is None else outcome.measured,
            "reference": check.reference,
            "bar": None if bar is None else bar.error,
            "bar_judged_by": None if bar is None else bar.method,
            "covered_by": None if bar is None else self.covered_by,
            "deviation": None if outcome is None else outcome.deviation,
            "source": check.source, "tolerance": check.tolerance, "reason": check.reason,
            "verdict": self.verdict,
            "explained": check.explanation if outcome is None else outcome.explanation,
            "beside": "" if outcome is None else outcome.beside,
            "seconds": None if self.found is None else self.found.seconds, "test": self.test,
        }  # fmt: skip


def group_cases(group: str) -> tuple[Case, ...]:
    """Cases of a group."""
    cases: tuple[Case, ...] = importlib.import_module(_CASES + group).CASES
    return cases


def group_rows(group: str) -> tuple[Check, ...]:
    """Checks of a group."""
    return tuple(row for case in group_cases(group) for row in case.rows)


def verify(
    groups: Sequence[str], *, extent: Extent, announce: Callable[[str], None]
) -> list[Verified]:
    """Run the checks of the groups, as many of them as `extent` says; the others are skipped."""
    rows = []
    every = ((g, case, row) for g in groups for case in group_cases(g) for row in case.rows)
    for group, case, check in every:
        left_out = extent == "quick" and check is not case.rows[0]
        if left_out or (check.heavy and extent != "heavy"):
            rows.append(Verified(group, case, check))
            continue
        announce(f"check {check.id}")
        measured = division(group, check)
        outcome, bar = judged(check, measured.estimate), _bar(group, case, check, measured)
        rows.append(Verified(group, case, check, outcome, measured, bar))
    return rows


def _bar(group: str, case: Case, check: Check, measured: Division) -> Estimate | None:
    """Row's bar; None where nothing is divided, and of a row that is an error itself."""
    if math.isfinite(measured.error):
        method = "what is unknown of the device" if check.band else "the model's own"
        return Estimate(measured.value, measured.error, method)
    if measured.kind is None or case.refinement is not None:
        return None
    other = next_division(group, check)
    if other is None:
        return None
    change = abs(measured.value - other.value)
    return Estimate(measured.value, change, f"the change with {other.words}")


def next_division(group: str, check: Check) -> Division | None:
    """Row's value on the next coarser level.

    Where there is none, as of linear functions that contain the answer, on the next finer one.
    """
    levels = (division(group, check, below) for below in (1, -1))
    return next((level for level in levels if level.new), None)


def division(group: str, check: Check, below: int = 0) -> Division:
    """Row's value so many levels coarser, from the store if the code is the same.

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

    return cached_result(
        *_entry(group, "row", f"{check.id} {below}" if below else check.id), work,
        serves=lambda level: below > 0 or judged(check, level.estimate).status != "fail",
    )  # fmt: skip


def remembered(group: str, name: str, error: Callable[[], float]) -> float:
    """Error of a case's own refinement, from the store if the code is the same."""
    return cached_result(*_entry(group, "level", name), error)


def _entry(group: str, kind: str, name: str) -> tuple[str, tuple[str, str], tuple[str, ...]]:
    """Kind, inputs and code that a measured value goes by in the store."""
    module = _CASES + group
    code = (module, *ENGINE) if group in ON_SCENES else (module,)
    return f"check.{kind}", (group, name), code
