"""What a benchmark brings back, as plain values for the table, the file and the plot."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import ClassVar


class Timing(ABC):
    """One run of one way of computing; all rows of one part are of one kind.

    Attributes
    ----------
    columns, fields : tuple of str
        Heads of the table and of the file.
    cost_label : str
        What is plotted along x.
    path, case : str
        The way, and what was computed.
    seconds : float
        Processor time.
    error : float
        Relative; infinite where no digit is right.
    wanted : float
        Error asked for; nan if none is.
    """

    columns: ClassVar[tuple[str, ...]]
    fields: ClassVar[tuple[str, ...]]
    cost_label: ClassVar[str] = "time (s)"
    path: str
    case: str
    seconds: float
    error: float
    wanted: float

    @property
    def cost(self) -> float:
        """What is plotted along x."""
        return self.seconds

    @property
    def curves(self) -> dict[str, float]:
        """Errors to plot, one panel each."""
        return {self.case: self.error}

    @property
    @abstractmethod
    def cells(self) -> tuple[str, ...]:
        """The row of the table, as `columns`."""

    @property
    @abstractmethod
    def values(self) -> tuple[str | float, ...]:
        """The row of the file, as `fields`."""


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
