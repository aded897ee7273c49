"""What a benchmark brings back, as plain values for the table and the plot."""

from __future__ import annotations

from dataclasses import dataclass


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

    @property
    def rate(self) -> float:
        """Points per second."""
        return self.points / self.seconds


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
    timings: tuple[Timing, ...]
    targets: tuple[Target, ...]
    seconds: float
