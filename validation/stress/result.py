"""What a stress run brings back, as plain values for the table, the plots and the report."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from geometry.arrays import Floats

#: Relative error that is asked for.
WANTED = 1e-12


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


@dataclass(frozen=True)
class Row:
    """One family of points, judged."""

    family: str
    what: str
    points: int
    worst: Point
    #: Worst among the points whose bound is what was asked for or less.
    worst_well: Point | None
    naive: float
    within_bounds: bool

    @property
    def verdict(self) -> str:
        """Whether the family is within what was asked for, and if not everywhere, where."""
        if not self.within_bounds or (self.worst_well and self.worst_well.error > WANTED):
            return "fails"
        return "holds" if self.worst.error <= WANTED else "holds up to the condition limit"


@dataclass(frozen=True)
class ErrorMap:
    """Errors over frequency (Hz) and length (m), each (n_length, n_frequency)."""

    title: str
    frequencies: Floats
    lengths: Floats
    error: Floats
    naive: Floats
    condition: Floats


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
    """Return the row of a family."""
    well = [p for p in points if p.bound <= WANTED]
    naive = [p.naive for p in points if not math.isnan(p.naive)]
    return Row(
        family,
        what,
        len(points),
        max(points, key=lambda p: p.error),
        max(well, key=lambda p: p.error) if well else None,
        max(naive, default=math.nan),
        all(p.error <= p.bound for p in points),
    )
