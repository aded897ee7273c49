"""What a benchmark brings back, as plain values for the table and the plot."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar, TypeAlias

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
    def curves(self) -> dict[str, float]:
        """Errors to plot, one panel each."""
        return {self.case: self.error}

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
    def curves(self) -> dict[str, float]:
        """Errors to plot, one panel each."""
        return {self.case: self.error}

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
class SolverTiming:
    """One step of a sparse solver with one matrix.

    Attributes
    ----------
    path, case : str
        Library and kind of number; what was done.
    unknowns, entries : int
        Size of the matrix, and stored entries.
    seconds : float
        Processor time.
    memory : float
        Peak of the whole process (bytes), the matrix included.
    error : float
        Largest error of a known solution, relative to its largest entry; not refined.
    """

    path: str
    case: str
    unknowns: int
    entries: int
    seconds: float
    memory: float
    error: float

    columns: ClassVar = ("way", "result", "unknowns", "entries", "time", "peak memory", "error")
    fields: ClassVar = ("way", "step", "unknowns", "entries", "seconds", "bytes", "error")
    cost_label: ClassVar = "time (s)"
    #: Error asked for: a condition of 1e9 leaves seven digits, a large matrix one less.
    wanted: ClassVar = 1e-6

    @property
    def cost(self) -> float:
        """What is plotted along x."""
        return self.seconds

    @property
    def curves(self) -> dict[str, float]:
        """Errors to plot, one panel each."""
        return {self.case: self.error}

    @property
    def cells(self) -> tuple[str, ...]:
        """The row of the table, as `columns`."""
        return (
            self.path, self.case, f"{self.unknowns:,}", f"{self.entries:,}",
            engineering(self.seconds, "s", 3), engineering(self.memory, "B", 3),
            f"{self.error:.1e}",
        )  # fmt: skip

    @property
    def values(self) -> tuple[str | float, ...]:
        """The row of the file, as `fields`."""
        return (
            self.path, self.case, self.unknowns, self.entries, self.seconds, self.memory,
            self.error,
        )  # fmt: skip


@dataclass(frozen=True)
class SolidTiming:
    """One solution of one job by one way of the piezoelectric solid.

    Attributes
    ----------
    path, level : str
        The way, and how fine.
    case : str
        The job, J1 or J2.
    own : bool
        Whether it is ours or a peer's.
    unknowns : int
        Size of the system.
    phases : dict of str to float
        Processor time (s) of mesh, assembly, factor, solve, eigen, sweep, as far as they
        occur.
    process_seconds, peak_memory : float, int
        Processor time of the whole process (s), its largest resident size (bytes).
    errors : dict of str to float
        Relative, by value.
    """

    path: str
    level: str
    case: str
    own: bool
    unknowns: int
    phases: dict[str, float]
    process_seconds: float
    peak_memory: int
    errors: dict[str, float]

    steps: ClassVar = ("mesh", "assembly", "factor", "solve", "eigen", "sweep")
    columns: ClassVar = (
        "way", "fineness", "job", "unknowns", *steps, "compute", "process", "memory",
        "deflection", "f1…f4", "capacitance", "sweep error",
    )  # fmt: skip
    fields: ClassVar = (
        "way", "fineness", "job", "unknowns", *(f"{step}_seconds" for step in steps),
        "compute_seconds", "process_seconds", "peak_memory", "error_deflection", "error_f1",
        "error_f2", "error_f3", "error_f4", "error_capacitance", "error_sweep",
    )  # fmt: skip
    cost_label: ClassVar = "compute time (s)"
    wanted: ClassVar = 1e-3

    @property
    def cost(self) -> float:
        """Processor time (s) of all phases."""
        return sum(self.phases.values())

    @property
    def frequency_error(self) -> float:
        """Worst error of the natural frequencies; nan in a sweep."""
        return max((e for name, e in self.errors.items() if name[0] == "f"), default=math.nan)

    @property
    def worst(self) -> float:
        """What is judged: deflection and natural frequencies, or the sweep."""
        return max(error for name, error in self.errors.items() if name != "capacitance")

    @property
    def curves(self) -> dict[str, float]:
        """Errors to plot, one panel each."""
        if "sweep" in self.errors:
            return {"J2: damped sweep": self.errors["sweep"]}
        return {
            "J1: deflection": self.errors["deflection"],
            "J1: worst of f1…f4": self.frequency_error,
        }

    @property
    def cells(self) -> tuple[str, ...]:
        """The row of the table, as `columns`."""

        def shown(name: str) -> str:
            return f"{self.errors[name]:.1e}" if name in self.errors else ""

        worst = self.frequency_error
        return (
            self.path, self.level, self.case, f"{self.unknowns:,}",
            *(f"{self.phases[step]:.2f}" if step in self.phases else "" for step in self.steps),
            f"{self.cost:.2f}", f"{self.process_seconds:.1f}", f"{self.peak_memory / 1e9:.2f}",
            shown("deflection"), "" if math.isnan(worst) else f"{worst:.1e}",
            shown("capacitance"), shown("sweep"),
        )  # fmt: skip

    @property
    def values(self) -> tuple[str | float, ...]:
        """The row of the file, as `fields`."""
        names = ("deflection", "f1", "f2", "f3", "f4", "capacitance", "sweep")
        return (
            self.path, self.level, self.case, self.unknowns,
            *(self.phases.get(step, "") for step in self.steps), self.cost, self.process_seconds,
            self.peak_memory, *(self.errors.get(name, "") for name in names),
        )  # fmt: skip


#: A row of a part: all rows of one part are of one kind.
AnyTiming: TypeAlias = Timing | FieldTiming | SolverTiming | SolidTiming


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
    timings: tuple[AnyTiming, ...]
    targets: tuple[Target, ...]
    seconds: float
