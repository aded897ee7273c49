"""What a benchmark brings back, as plain values for the table and the plot."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar

from validation.formats import engineering


@dataclass(frozen=True)
class Timing:
    """One way of computing, over one range of frequencies.

    Attributes
    ----------
    path : str
        The way.
    case : str
        The range.
    points : int
        Frequency points timed.
    seconds : float
        Least of several runs.
    error : float
        Worst relative error of the tip velocity on a sample; infinite where it overflows.
    """

    path: str
    case: str
    points: int
    seconds: float
    error: float

    columns: ClassVar = (
        "way",
        "range",
        "points",
        "points per second",
        "ns per point",
        "worst error",
    )
    fields: ClassVar = ("way", "range", "points", "seconds", "points_per_second", "error")
    cost_label: ClassVar = "time per point (ns)"
    #: Error asked for.
    wanted: ClassVar = 1e-12

    @property
    def rate(self) -> float:
        """Points per second."""
        return self.points / self.seconds

    @property
    def cost(self) -> float:
        """What is plotted along x."""
        return 1e9 / self.rate

    @property
    def cells(self) -> tuple[str, ...]:
        """The row of the table, as `columns`."""
        return (
            self.path, self.case, f"{self.points:,}", f"{self.rate:,.0f}", f"{self.cost:.0f}",
            f"{self.error:.1e}",
        )  # fmt: skip

    @property
    def values(self) -> tuple[str | float, ...]:
        """The row of the file, as `fields`."""
        return self.path, self.case, self.points, self.seconds, self.rate, self.error


@dataclass(frozen=True)
class FieldTiming:
    """One result of one field solution.

    Attributes
    ----------
    path, level : str
        The formulation, and how fine.
    case : str
        The result that was compared.
    unknowns : int
        Size of the system.
    seconds : float
        Least of several runs, everything included.
    value : float
        The result, in `unit`.
    error : float
        Relative, against the reference of the run.
    wanted : float
        Error asked for; nan if none is.
    """

    path: str
    level: str
    case: str
    unknowns: int
    seconds: float
    value: float
    unit: str
    error: float
    wanted: float = math.nan

    columns: ClassVar = ("way", "fineness", "result", "unknowns", "time", "value", "error")
    fields: ClassVar = (
        "way", "fineness", "result", "unknowns", "seconds", "value", "unit", "error",
    )  # fmt: skip
    cost_label: ClassVar = "time (s)"

    @property
    def cost(self) -> float:
        """What is plotted along x."""
        return self.seconds

    @property
    def cells(self) -> tuple[str, ...]:
        """The row of the table, as `columns`."""
        return (
            self.path, self.level, self.case, f"{self.unknowns:,}",
            engineering(self.seconds, "s", 3), engineering(self.value, self.unit),
            f"{self.error:.1e}",
        )  # fmt: skip

    @property
    def values(self) -> tuple[str | float, ...]:
        """The row of the file, as `fields`."""
        return (
            self.path, self.level, self.case, self.unknowns, self.seconds, self.value, self.unit,
            self.error,
        )  # fmt: skip


@dataclass(frozen=True)
class Target:
    """A requirement and what was measured; met if below (`at_most`) or above the wanted."""

    what: str
    wanted: float
    measured: float
    unit: str
    at_most: bool
    how: str

    @property
    def met(self) -> bool:
        """Whether the requirement is met."""
        return self.measured <= self.wanted if self.at_most else self.measured >= self.wanted


@dataclass(frozen=True)
class Bench:
    """All that one part measured; `conditions` says on what."""

    part: str
    conditions: str
    timings: tuple[Timing, ...] | tuple[FieldTiming, ...]
    targets: tuple[Target, ...]
    seconds: float
