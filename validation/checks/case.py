"""A case: one problem whose answer is known, solved by the suite, with all its rows.

Rows say what must hold; the case says what the problem is, so that the verification book can
give it a page of its own.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import TYPE_CHECKING

from tactgen.geometry.arrays import Floats
from tactgen.validation.checks.row import Check, Tier

if TYPE_CHECKING:
    from tactgen.validation.checks.drawings.drawing import Drawing


@dataclass(frozen=True)
class Refinement:
    """The divisions by which a case shows an order, where its rows are errors themselves.

    Attributes
    ----------
    levels : tuple of int
        Intervals along an edge, from coarse to fine.
    error : callable
        Gives the relative error on so many.
    order : str
        What theory expects of it, in words.
    """

    levels: tuple[int, ...]
    error: Callable[[int], float]
    order: str


@dataclass(frozen=True)
class Case:
    """A problem with a known answer.

    Attributes
    ----------
    id, title : str
        Rows are called by the id and a number.
    problem : str
        What is asked, with all dimensions, so that a reader can solve it elsewhere.
    model : str
        What of the suite solves it, and how finely.
    rows : tuple of Check
        What must hold.
    refinement : Refinement, optional
        What is shown in place of the rows' own coarser levels (`checks/cases/fineness.py`).
    setup : callable, optional
        Gives a drawing of what is solved; a case without one is about formulas alone.
    """

    id: str
    title: str
    problem: str
    model: str
    rows: tuple[Check, ...]
    refinement: Refinement | None = None
    setup: Callable[[], Drawing] | None = None


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
    """Return the measurement of one of several values that a function gives at once."""
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
    setup: Callable[[], Drawing] | None = None,
) -> Case:
    """Return a case called `name`; answers without a tolerance or reason have the case's."""
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
