"""A case: one problem with a known answer, solved by the suite, and the rows that must hold."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from typing import Any, Literal, NamedTuple

from tactgen.validation.models.model import Estimate

Tier = Literal["code verification", "solution verification", "cross-model", "validation"]
Status = Literal["pass", "fail", "explained"]


class Null(NamedTuple):
    """A trivial model: what it assumes, and what it gives in the row's unit, at once."""

    words: str
    value: Callable[[], float]


@dataclass(frozen=True)
class Check:
    """One requirement with its reference and its tolerance.

    What is left open (`tolerance`, `reason`, `source`, `id`, `tier`, `scene`) is that of the case.
    """

    requirement: str  # a sentence
    reference: float | tuple[float, float]  # in `unit`, or the range in which the value must lie
    unit: str
    measure: Callable[[], float | Estimate]  # with its error bar where its model states one
    tolerance: float = math.nan  # relative deviation from the value, or beyond the range
    reason: str = ""  # why the tolerance is what it is
    source: str = ""
    id: str = ""  # within its case what stands after the dash; a number where it is open
    tier: Tier | Literal[""] = ""
    explained: str = ""  # why the row is known to differ; empty where it must pass
    known: float = 0.0  # the deviation that was explained; another one fails
    fitted: str = ""  # what was fitted to the reference: agreement then is no pass
    #: Whether the measured value is the middle of a band of predictions, its error half the width:
    #: then the band's nearest value is judged
    band: bool = False
    null: Null | None = None  # a trivial model: where it passes, passing is no evidence
    heavy: bool = False  # takes more than a few seconds
    scene: str = ""  # the built-in scene whose report shows it

    @property
    def explanation(self) -> str:
        """Why agreement or disagreement says nothing about the models; empty where it does."""
        if self.fitted:
            return f"fitted to this reference, so it is no test: {self.fitted}"
        return self.explained

    @property
    def ends(self) -> tuple[float, float]:
        """Reference as a range."""
        return self.reference if isinstance(self.reference, tuple) else (self.reference,) * 2


@dataclass(frozen=True)
class Outcome:
    """A check with what came out."""

    check: Check
    measured: float
    deviation: float
    status: Status
    null: float = math.nan  # what the check's trivial model gives
    half: float = 0.0  # of the width of a band of predictions

    @property
    def is_no_evidence(self) -> bool:
        """Whether a trivial model passes as well."""
        low, high = self.check.ends
        if self.half:  # granted a band of the same relative width
            half = abs(self.null * self.half / self.measured)
            return self.null - half < high and low < self.null + half
        if low < high:  # on a limit, as of "more than 1", it does not
            return low < self.null < high
        return abs(_deviation(self.null, self.check.ends)) <= self.check.tolerance

    @property
    def explanation(self) -> str:
        """Why a deviation, or an agreement, is known to say nothing; empty where it does."""
        return self.check.explanation if self.status == "explained" else ""

    @property
    def beside(self) -> str:
        """Band, what a trivial model gives, a limit that is near, in sentences; maybe empty."""
        from tactgen.geometry.formats import engineering, percent, share

        found, (low, high) = [], self.check.ends
        if self.half:
            ends = (self.measured - self.half, self.measured + self.half, low, high)
            band = [engineering(end, self.check.unit, 4) for end in ends]
            found.append("Predicted {} to {}, published {} to {}.".format(*band))
        if self.check.null is not None and not math.isnan(self.null):
            what = f"{self.check.null.words} gives {engineering(self.null, self.check.unit)}"
            off = _deviation(self.null, self.check.ends)
            missed = f"misses by {percent(off, 0)}" if off else "is on the limit"
            passes = "passes with a band as wide" if self.half else "passes"
            verdict = (
                f"{passes}, so that this row is no evidence" if self.is_no_evidence else missed
            )
            found.append(f"Trivial model: {what}, which {verdict}.")
        limits = [end for end in (low, high) if low < high and end]
        if self.status == "pass" and limits:
            near = min(abs(self.measured / end - 1.0) for end in limits)
            if near < _NEAR_LIMIT:
                found.append(f"A limit is {share(near)} away.")
        return " ".join(found)


#: How far a known deviation may move before its explanation no longer counts: absolutely, and
#: as a share of itself.
_STILL, _STILL_SHARE = 0.02, 0.2
#: Distance from a limit, relative to it, below which a row says so.
_NEAR_LIMIT = 0.01


def run_check(check: Check) -> Outcome:
    """Measure one row."""
    return judged(check, check.measure())


def value_of(measured: float | Estimate) -> float:
    """Measured value without its bar."""
    return float(measured.value if isinstance(measured, Estimate) else measured)


def judged(check: Check, measured: float | Estimate) -> Outcome:
    """Verdict of a measured value, or of a band."""
    value, (low, high) = value_of(measured), check.ends
    half = float(measured.error) if check.band and isinstance(measured, Estimate) else 0.0
    nearest = min(max(min(max(value, low), high), value - half), value + half)
    deviation = _deviation(nearest, check.ends)
    if abs(deviation) <= check.tolerance:
        status: Status = "explained" if check.fitted else "pass"
    else:
        near = min(_STILL, _STILL_SHARE * abs(check.known))
        still = check.explained and abs(deviation - check.known) <= near
        status = "explained" if still else "fail"
    null = math.nan if check.null is None else check.null.value()
    outcome = Outcome(check, value, deviation, status, null, half)
    no_evidence = status == "pass" and outcome.is_no_evidence
    return replace(outcome, status="explained") if no_evidence else outcome


def _deviation(measured: float, ends: tuple[float, float]) -> float:
    """Relative distance from a value, or from the nearer end of a range.

    Relative to that end; where it is 0, to the range's other end, and without one infinite.
    """
    nearest = min(max(measured, ends[0]), ends[1])
    if measured == nearest:
        return 0.0
    if nearest:
        return measured / nearest - 1.0
    size = max(map(abs, ends))
    return math.copysign(abs(measured) / size if size else math.inf, measured)


class Refinement(NamedTuple):
    """Errors of a case whose rows are errors: on so many intervals an edge, and their order."""

    levels: tuple[int, ...]
    error: Callable[[int], float]
    order: str


@dataclass(frozen=True)
class Case:
    """A problem with a known answer, all dimensions stated, and what of the suite solves it."""

    id: str
    title: str
    problem: str
    model: str
    rows: tuple[Check, ...]
    refinement: Refinement | None = None


def case(
    name: str,
    title: str,
    problem: str,
    rows: Iterable[Check],
    *,
    model: str,
    source: str = "",
    tolerance: float = 0.0,
    reason: str = "",
    tier: Tier = "code verification",
    scene: str = "",
    refinement: Refinement | None = None,
) -> Case:
    """Case called `name`, whose rows have its source, tolerance, … where they have none."""
    checks = tuple(
        replace(
            row, id=f"{name}-{row.id or number}", source=row.source or source,
            tolerance=tolerance if math.isnan(row.tolerance) else row.tolerance,
            reason=row.reason or reason, tier=row.tier or tier, scene=row.scene or scene,
        )
        for number, row in enumerate(rows, start=1)
    )  # fmt: skip
    return Case(name, title, problem, model, checks, refinement)


def middle(values: Iterable[float]) -> Estimate:
    """Middle of a band, with half of its width as the error."""
    found = list(values)
    return Estimate(0.5 * (max(found) + min(found)), 0.5 * (max(found) - min(found)))


def nth(values: Callable[..., Any], index: int | str, *arguments: object) -> Callable[[], float]:
    """Measurement of one of several values that a function gives at once."""
    return lambda: float(values(*arguments)[index])
