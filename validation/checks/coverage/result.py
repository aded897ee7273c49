"""One number with its bar held against a better one, and what many of them say about the bars."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal, TypeAlias

import numpy as np

from tactgen.geometry.arrays import Floats
from tactgen.geometry.store.values import storable

#: Share of the errors that a bar promises to cover.
PROMISED = 0.95
#: Errors below are those of the reference.
_EPS = float(np.finfo(float).eps)
#: Median of bar over error from which bars say too little to be of use.
WIDE = 5.0
#: Multiples of the bars at which the calibration curve is drawn.
MULTIPLES: Floats = np.geomspace(0.05, 5.0, 41)
#: Chance at most that bars which keep the promise are called too narrow.
_FALSE_ALARM = 0.01

#: What is said of bars: they cover and are tight, they cover by being wide, they do not cover.
Verdict: TypeAlias = Literal["holds", "wide", "fails"]


@storable
@dataclass(frozen=True)
class Judged:
    """An answer held against its reference; both error and bar relative to the reference.

    Attributes
    ----------
    where : str
        The device, for people: what differs from the scene that it was drawn from.
    quantity : str
        What was asked, with the number of a mode.
    """

    where: str
    quantity: str
    error: float
    bar: float

    @property
    def within(self) -> bool:
        """Whether the bar covers the error."""
        return self.error <= self.bar


@dataclass(frozen=True)
class Row:
    """All answers of one quantity.

    Attributes
    ----------
    inside, count : int
        How many lie within their bars, and of how many.
    devices : int
        Of how many devices these are: of few, the median is a guess.
    width : float
        Median of bar over error.
    worst : Judged
        The answer whose error is largest beside its bar.
    verdict : {"holds", "wide", "fails"}
        "fails" if so many outside are unlikely of bars that keep the promise; "wide" if the
        median is beyond :data:`WIDE`.
    """

    quantity: str
    inside: int
    count: int
    devices: int
    width: float
    worst: Judged
    verdict: Verdict

    @property
    def holds(self) -> bool:
        """Whether the bars cover, however wide they are."""
        return self.verdict != "fails"


def rows(found: Sequence[Judged]) -> list[Row]:
    """Return one row a quantity, numbers of modes together, and last all of them."""
    by_quantity: dict[str, list[Judged]] = {}
    for one in found:
        by_quantity.setdefault(one.quantity.partition(" ")[0], []).append(one)
    made = [_row(name, of) for name, of in by_quantity.items()]
    return [*made, _row("all", list(found))] if len(made) > 1 else made


def _row(quantity: str, found: list[Judged]) -> Row:
    worst = max(found, key=lambda one: one.error / max(one.bar, 1e-300))
    inside, devices = sum(one.within for one in found), len({one.where for one in found})
    width = median_width(found)
    verdict = _verdict(inside, len(found), width)
    return Row(quantity, inside, len(found), devices, width, worst, verdict)


def _verdict(inside: int, count: int, width: float) -> Verdict:
    from scipy.stats import binom

    if binom.cdf(inside, count, PROMISED) < _FALSE_ALARM:
        return "fails"
    return "wide" if width > WIDE else "holds"


def median_width(found: Sequence[Judged]) -> float:
    """Return the median of bar over error."""
    return float(np.median([one.bar / max(one.error, _EPS) for one in found]))


def calibration(found: Sequence[Judged]) -> Floats:
    """Return the share of errors within each of :data:`MULTIPLES` times the bar."""
    ratios = np.array([one.error / max(one.bar, 1e-300) for one in found])
    return np.asarray((ratios[:, None] <= MULTIPLES).mean(axis=0))
