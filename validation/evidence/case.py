"""A case: one problem whose answer is known, solved by the suite, with all its rows.

Rows say what must hold; the case says what the problem is, so that the verification book can
give it a page of its own.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import Literal

from tactgen.geometry.arrays import Floats
from tactgen.validation.engine.results import Estimate

Tier = Literal["code verification", "solution verification", "cross-model", "validation"]
Status = Literal["pass", "fail", "explained"]


@dataclass(frozen=True)
class Check:
    """One requirement with its reference and its tolerance."""

    #: The requirement is a sentence
    id: str
    tier: Tier
    requirement: str
    #: Reference value in `unit`, or the range in which the value must lie
    reference: float | tuple[float, float]
    unit: str
    source: str
    tolerance: float  #: Accepted relative deviation from the value, or beyond the range
    reason: str  #: Why the tolerance is what it is
    #: Computes the value, with its error bar where the model that it asks states one
    measure: Callable[[], float | Estimate]
    explained: str = ""  #: Why the row is known to differ; empty where it must pass
    known: float = 0.0  #: The deviation that the explanation was written for; another one fails
    #: What was fitted to the reference; agreement then confirms nothing and is no pass
    fitted: str = ""
    heavy: bool = False  #: Whether it takes more than a few seconds
    #: The built-in scene whose report shows it; empty where it is about the suite alone
    scene: str = ""

    @property
    def explanation(self) -> str:
        """Why agreement or disagreement says nothing about the models; empty where it does."""
        if self.fitted:
            return f"fitted to this reference, so it is no test: {self.fitted}"
        return self.explained


@dataclass(frozen=True)
class Outcome:
    """A check with what came out."""

    check: Check
    measured: float
    deviation: float
    status: Status


#: How far a known deviation may move before its explanation no longer counts: absolutely, and
#: as a share of itself.
_STILL, _STILL_SHARE = 0.02, 0.2


def run_check(check: Check) -> Outcome:
    """Measure one row."""
    return judged(check, value_of(check.measure()))


def value_of(measured: float | Estimate) -> float:
    """Measured value without its bar."""
    return float(measured.value if isinstance(measured, Estimate) else measured)


def judged(check: Check, measured: float) -> Outcome:
    """What a measured value says about a row."""
    deviation = _deviation(measured, check.reference)
    if abs(deviation) <= check.tolerance:
        status: Status = "explained" if check.fitted else "pass"
    else:
        near = min(_STILL, _STILL_SHARE * abs(check.known))
        still = check.explained and abs(deviation - check.known) <= near
        status = "explained" if still else "fail"
    return Outcome(check, measured, deviation, status)


def _deviation(measured: float, reference: float | tuple[float, float]) -> float:
    """Relative distance from a value, or from the nearer end of a range.

    Relative to that end; where it is 0, to the range's other end, and without one infinite.
    """
    ends = reference if isinstance(reference, tuple) else (reference, reference)
    nearest = min(max(measured, ends[0]), ends[1])
    if measured == nearest:
        return 0.0
    if nearest:
        return measured / nearest - 1.0
    size = max(map(abs, ends))
    return math.copysign(abs(measured) / size if size else math.inf, measured)


@dataclass(frozen=True)
class Refinement:
    """The divisions by which a case shows an order, where its rows are errors themselves."""

    levels: tuple[int, ...]  #: Intervals along an edge, from coarse to fine
    error: Callable[[int], float]  #: Gives the relative error on so many
    order: str  #: What theory expects of it, in words


@dataclass(frozen=True)
class Case:
    """A problem with a known answer."""

    #: Rows are called by the id and a number
    id: str
    title: str
    problem: str  #: What is asked, with all dimensions, so that a reader can solve it elsewhere
    model: str  #: What of the suite solves it, and how finely
    rows: tuple[Check, ...]  #: What must hold
    #: What is shown in place of the rows' own coarser levels (`checks/cases/fineness.py`)
    refinement: Refinement | None = None
    #: Gives a drawing as SVG, where a body is hard to say in words
    setup: Callable[[], str] | None = None


@dataclass(frozen=True)
class Answer:
    """One known number of a case; see :class:`Check` for what is not said here."""

    requirement: str
    reference: float | tuple[float, float]
    unit: str
    measure: Callable[[], float]
    tolerance: float | None = None
    reason: str = ""
    explained: str = ""
    known: float = 0.0
    heavy: bool = False


def nth(values: Callable[..., Floats], index: int, *arguments: object) -> Callable[[], float]:
    """Measurement of one of several values that a function gives at once."""
    return lambda: float(values(*arguments)[index])


def case(
    name: str,
    title: str,
    problem: str,
    *,
    model: str,
    source: str,
    answers: Iterable[Answer],
    tolerance: float = 0.0,
    reason: str = "",
    tier: Tier = "code verification",
    refinement: Refinement | None = None,
    setup: Callable[[], str] | None = None,
) -> Case:
    """Case called `name`; answers without a tolerance or reason have the case's."""
    rows = tuple(
        Check(
            f"{name}-{number}", tier, answer.requirement, answer.reference, answer.unit, source,
            tolerance if answer.tolerance is None else answer.tolerance,
            answer.reason or reason, answer.measure,
            explained=answer.explained, known=answer.known, heavy=answer.heavy,
        )
        for number, answer in enumerate(answers, start=1)
    )  # fmt: skip
    return Case(name, title, problem, model, rows, refinement, setup)
