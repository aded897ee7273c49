"""What a stress run brings back, as plain values for the table, the plots and the report."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from tactgen.geometry.arrays import Floats
from tactgen.geometry.store.values import storable

#: Relative error that is asked for.
WANTED = 1e-12
#: Bounds that hold for a share of answers are missed by the rest, but by none so many times.
FAR = 3.0


@storable
@dataclass(frozen=True)
class Point:
    """Relative errors at one set of parameters, against the high-precision reference.

    Attributes
    ----------
    where : str
        The parameters, for people.
    error : float
        Worst relative error of all that was compared.
    condition : float
        Condition number of the same.
    bound : float
        What the error may be at that condition number.
    naive : float
        Worst error of the naive formulas; infinite where they overflow, nan if not defined.
    """

    where: str
    error: float
    condition: float
    bound: float
    naive: float


@storable
@dataclass(frozen=True)
class Row:
    """One family of points, judged.

    Attributes
    ----------
    family, what : str
        What it is called, and what was varied.
    points : int
        How many were answered.
    worst : Point
        The answer with the largest error; of those beyond their bound, if there are any.
    over : float
        The largest error over its bound.
    naive : float
        Largest error of the naive formulas.
    verdict : str
        ``holds``, ``holds up to the condition limit``, ``holds or says why not``, or ``fails``.
    refusals : tuple of str
        What was said at the points that were not answered.
    beyond : tuple of Point
        The answers beyond their bound, that by the largest share first.
    """

    family: str
    what: str
    points: int
    worst: Point
    over: float
    naive: float
    verdict: str
    refusals: tuple[str, ...] = ()
    beyond: tuple[Point, ...] = ()


@storable
@dataclass(frozen=True)
class ErrorMap:
    """Errors over frequency (Hz) and length (m), each (n_length, n_frequency)."""

    title: str
    frequencies: Floats
    lengths: Floats
    error: Floats
    naive: Floats
    condition: Floats


@storable
@dataclass(frozen=True)
class Approach:
    """Error against condition number on the way into a resonance, (n,) arrays."""

    title: str
    condition: Floats
    error: Floats
    bound: Floats


@dataclass(frozen=True)
class Stress:
    """All that one part found."""

    part: str
    statement: str
    rows: tuple[Row, ...]
    maps: tuple[ErrorMap, ...]
    approaches: tuple[Approach, ...]
    seconds: float


def judged(family: str, what: str, points: Sequence[Point]) -> Row:
    """Return the row of a family that is held against what was asked for.

    It fails if a point is beyond its bound, or beyond what was asked for where its bound
    is that or less.
    """
    well = [p.error for p in points if p.bound <= WANTED]
    naive = [p.naive for p in points if not math.isnan(p.naive)]
    worst = max(points, key=lambda p: p.error)
    beyond = _beyond(points)
    if beyond or max(well, default=0.0) > WANTED:
        verdict = "fails"
    else:
        verdict = "holds" if worst.error <= WANTED else "holds up to the condition limit"
    naive_worst = max(naive, default=math.nan)
    return Row(family, what, len(points), worst, _over(points), naive_worst, verdict, beyond=beyond)


def share(point: Point) -> float:
    """Return the share of its bound that an error takes; an error without one is beyond."""
    if math.isnan(point.error):
        return math.inf
    if point.error == 0.0:
        return 0.0
    return point.error / point.bound if point.bound > 0.0 else math.inf


def _beyond(points: Sequence[Point]) -> tuple[Point, ...]:
    """Return the points that are not within their bound; what is no number is not."""
    return tuple(sorted((p for p in points if not p.error <= p.bound), key=share, reverse=True))


def _over(points: Sequence[Point]) -> float:
    """Return the largest share of its bound that an error takes."""
    return max(map(share, points), default=math.nan)


#: Stands for the worst of no answers.
_NONE = Point("", math.nan, math.nan, math.nan, math.nan)


def answered(
    family: str,
    what: str,
    points: Sequence[Point],
    refusals: Sequence[str] = (),
    *,
    promised: float = 1.0,
) -> Row:
    """Return the row of a family that is held against the bound of each answer.

    It fails if a refusal is not one sentence, or answers are beyond their bounds: more than the
    share for which these are `promised`, or one by :data:`FAR` of them.
    """
    beyond = _beyond(points)
    worst = max(beyond or points, key=lambda p: p.error, default=_NONE)
    clear = all(words.strip() and "\n" not in words for words in refusals)
    holds = "holds or says why not" if refusals else "holds"
    missed = len(beyond) > (1.0 - promised) * len(points) or _over(beyond) > FAR
    verdict = "fails" if missed or not clear else holds
    return Row(
        family, what, len(points), worst, _over(points), math.nan, verdict, tuple(refusals), beyond,
    )  # fmt: skip
