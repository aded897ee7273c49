"""Time at a wanted error, read off a work-precision curve."""

from __future__ import annotations

import math
from collections.abc import Iterable

#: Of a run: time (s) and error.
Point = tuple[float, float]


def front(points: Iterable[Point]) -> list[Point]:
    """Return the points that no other beats in both time and error, by time."""
    best: list[Point] = []
    for seconds, error in sorted(points):
        if not best or error < best[-1][1]:
            best.append((seconds, error))
    return best


def time_at_error(points: Iterable[Point], wanted: float) -> float:
    """Return the time (s) at which the error comes down to `wanted`.

    Between two neighbours of the front, on the straight line in logarithms.  Nothing is
    extrapolated: a curve that starts below `wanted` gives its first point's time, one that
    does not come down to it infinity.
    """
    best = front(points)
    if not best or best[-1][1] > wanted:
        return math.inf
    after = next(i for i, (_, error) in enumerate(best) if error <= wanted)
    if after == 0:
        return best[0][0]
    (t0, e0), (t1, e1) = best[after - 1], best[after]
    if e1 <= 0.0:
        return t1
    share = math.log(e0 / wanted) / math.log(e0 / e1)
    return float(t0 * (t1 / t0) ** share)
