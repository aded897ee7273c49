"""How a case converges: its values on coarser divisions, as a figure and in words."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import partial
from typing import NamedTuple

from tactgen.validation.book.figures import Curve, convergence
from tactgen.validation.checks.case import Refinement
from tactgen.validation.checks.verification import (
    Division,
    Verified,
    division,
    next_division,
    remembered,
)

#: How many levels coarser than its own a case is solved: they cost less each time.
_LEVELS = 3
_WITHOUT = (
    "closed forms, transfer matrices, circuits and harmonic balance divide nothing into elements, "
    "and what is solved on a mesh of the model's own choice has the bar that the model states"
)


class Convergence(NamedTuple):
    """The figure, empty where there is none; what it shows, or why there is none."""

    figure: str
    words: str


def converged(rows: Sequence[Verified]) -> Convergence:
    """Return how the first of a case's rows that can be solved more coarsely converges."""
    case = rows[0].case
    if case.refinement is not None:
        return _errors(rows[0].group, case.id, case.refinement)
    run = [row for row in rows if row.found is not None]
    if not run:
        return Convergence("", "none of its rows was run; run them with --heavy")
    for row in run:
        levels = list(_levels(row))
        if len(levels) > 1:
            return _values(row, levels)
    return Convergence("", _WITHOUT)


def _levels(row: Verified) -> Iterator[Division]:
    """Yield what a row measures, from its own level to coarser ones as far as they differ.

    Where there is no coarser one, then on the next finer.
    """
    assert row.found is not None
    yield row.found
    if row.found.kind is None:
        return
    other = next_division(row.group, row.case, row.check)
    while other is not None and other.new:
        yield other
        if not 0 < other.below < _LEVELS:
            return
        other = division(row.group, row.case, row.check, other.below + 1)


def _values(row: Verified, levels: Sequence[Division]) -> Convergence:
    """Return errors against the reference where it is one number, and changes to the finest."""
    levels, check = sorted(levels, key=lambda level: level.below), row.check
    finest = levels[0]
    assert finest.kind is not None
    measure = finest.kind.measure if all(level.count for level in levels) else "level"
    sizes = [level.count if measure != "level" else -i for i, level in enumerate(levels)]
    scale = max(abs(level.value) for level in levels) or 1.0
    curves = [Curve("change to the finest", sizes[1:],
                    [abs(level.value - finest.value) / scale for level in levels[1:]])]  # fmt: skip
    reference = check.reference
    if not isinstance(reference, tuple) and reference != 0.0:
        errors = [abs(level.value / reference - 1.0) for level in levels]
        curves.insert(0, Curve("error", sizes, errors))
    words = (
        f"row {check.id}, from right to left each point with {finest.kind.coarser}. "
        f"Expected: {finest.kind.theory}; what is left of the error at the end is the model's or "
        "the reference's"
    )
    return Convergence(convergence(curves, measure, check.tolerance), words)


def _errors(group: str, name: str, refinement: Refinement) -> Convergence:
    """Return the errors by which a case shows its order."""
    errors = [
        remembered(group, f"{name} {level}", partial(refinement.error, level))
        for level in refinement.levels
    ]
    curve = Curve("error", refinement.levels, errors)
    return Convergence(
        convergence([curve], "intervals along an edge", 0.0), f"theory: {refinement.order}"
    )
