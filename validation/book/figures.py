"""The book's figures: convergence of a case, and scatter of measured about reference."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from typing import NamedTuple

import numpy as np

from tactgen.geometry.arrays import Floats
from tactgen.validation.evidence.case import Refinement
from tactgen.validation.evidence.verification import (
    Division,
    Verified,
    division,
    next_division,
    remembered,
)
from tactgen.validation.show.figures import BLUE, DARK, GREY, ORANGE, new_figure, panels, svg


@dataclass(frozen=True)
class Scatter:
    """Measured values over references of a group's rows that have one number to meet."""

    #: (n,) Absolute values; a row whose signs differ is left out and counted as a fail anyway
    measured: Floats
    reference: Floats
    #: exp of the mean of ln(measured/reference), with the half variance of a log-normal
    bias: float
    spread: float  #: Standard deviation of ln(measured/reference): the relative scatter


def scatter(rows: Sequence[Verified]) -> Scatter | None:
    """Scatter of the rows that were to agree, or None if fewer than two have a number.

    Rows that differ for a stated reason are not counted: they say nothing about the models.
    """
    pairs = [
        (row.outcome.measured, row.check.reference)
        for row in rows
        if row.outcome is not None
        and row.verdict in ("pass", "fail")
        and isinstance(row.check.reference, float | int)
        and row.outcome.measured * row.check.reference > 0.0
    ]
    if len(pairs) < 2:
        return None
    measured, reference = np.abs(np.array(pairs)).T
    logarithms = np.log(measured / reference)
    spread = float(logarithms.std(ddof=1))
    bias = math.exp(float(logarithms.mean()) + 0.5 * spread**2)
    return Scatter(measured, reference, bias, spread)


#: Errors below this are rounding, and drawn here.
_ROUNDING = 1e-16
#: Lines of errors, and of changes from level to level.
_STYLES = (("o-", BLUE), ("s--", GREY))


class Curve(NamedTuple):
    """Relative errors or changes over sizes."""

    name: str
    sizes: Sequence[int]
    errors: Sequence[float]


def convergence(curves: Sequence[Curve], measure: str, tolerance: float) -> str:
    """Relative errors over a measure of fineness, with the row's tolerance."""
    figure, axis = panels(6.4, 3.4)
    for curve, (mark, color) in zip(curves, _STYLES[: len(curves)], strict=True):
        axis.plot(
            curve.sizes, np.maximum(np.abs(curve.errors), _ROUNDING), mark, color=color,
            label=curve.name,
        )  # fmt: skip
    axis.set_yscale("log")
    if tolerance > 0.0:
        axis.axhline(tolerance, color=ORANGE, linestyle=":", linewidth=1.0, label="tolerance")
    sizes = sorted({size for curve in curves for size in curve.sizes})
    if sizes[0] > 0:
        axis.set_xscale("log")
    axis.set_xticks(sizes, [f"{size:,}".replace(",", " ") for size in sizes])
    axis.minorticks_off()
    axis.set_xlabel(measure)
    axis.set_ylabel("relative")
    axis.legend(fontsize=8, labelcolor=DARK)
    return svg(figure)


def scattered(groups: dict[str, Scatter]) -> str:
    """All groups' values over their references, on one logarithmic square."""
    figure = new_figure(6.4, 5.6)
    axis = figure.add_subplot()
    low = min(float(s.reference.min()) for s in groups.values())
    high = max(float(s.reference.max()) for s in groups.values())
    axis.loglog([low, high], [low, high], color=GREY, linewidth=1.0)
    marks = "os^Dv<>Pp*hX"
    for mark, (name, found) in zip(marks, groups.items(), strict=False):
        axis.loglog(
            found.reference, found.measured, mark, label=name, markersize=5,
            markerfacecolor="none",
        )  # fmt: skip
    axis.set_xlabel("reference (SI or the case's own units)")
    axis.set_ylabel("computed")
    axis.grid(visible=True, alpha=0.25)
    axis.legend(fontsize=8, labelcolor=DARK)
    return svg(figure)


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
    """How the first of a case's rows that can be solved more coarsely converges."""
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
    """Errors against the reference where it is one number, and changes to the finest."""
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
    """Errors by which a case shows its order."""
    errors = [
        remembered(group, f"{name} {level}", partial(refinement.error, level))
        for level in refinement.levels
    ]
    curve = Curve("error", refinement.levels, errors)
    return Convergence(
        convergence([curve], "intervals along an edge", 0.0), f"theory: {refinement.order}"
    )
