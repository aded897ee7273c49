"""Answers and refusals of one family: what is solved is compared, what is refused is quoted."""

from __future__ import annotations

import math
from collections.abc import Iterable

from tactgen.fem.solvers.linear_solver import SolverError
from tactgen.geometry.errors import InputError
from tactgen.validation.checks.stress.result import Point

#: What a model may say instead of a number.
REFUSALS = (InputError, SolverError, ArithmeticError)


class Family:
    """Points of one family, collected as they come."""

    def __init__(self) -> None:
        self.points: list[Point] = []
        self.refusals: list[str] = []

    def add(self, where: str, error: float, bound: float) -> None:
        """Take an answer's relative error with what it may be."""
        self.points.append(Point(where, float(error), math.nan, float(bound), math.nan))

    def compare(self, where: str, value: float, exact: float, bar: float) -> None:
        """Take an answer with its error bar, `bar` and values in one unit."""
        size = abs(exact)
        self.add(where, abs(value - exact) / size, bar / size)

    def refuse(self, error: Exception) -> None:
        """Take what was said instead of an answer."""
        self.refusals.append(str(error))


def spread(values: Iterable[float]) -> float:
    """Return how far values are apart, relative to the largest; nan if one is not finite."""
    found = list(values)
    if not all(math.isfinite(v) for v in found):
        return math.nan
    return (max(found) - min(found)) / max(abs(v) for v in found)
