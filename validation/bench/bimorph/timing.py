"""A row of the piezoelectric solid's benchmark."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar

from tactgen.validation.bench.result import Timing


@dataclass(frozen=True)
class SolidTiming(Timing):
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
    columns: ClassVar[tuple[str, ...]] = (
        "way", "fineness", "job", "unknowns", *steps, "compute", "process", "memory",
        "deflection", "f1…f4", "capacitance", "sweep error",
    )  # fmt: skip
    fields: ClassVar[tuple[str, ...]] = (
        "way", "fineness", "job", "unknowns", *(f"{step}_seconds" for step in steps),
        "compute_seconds", "process_seconds", "peak_memory", "error_deflection", "error_f1",
        "error_f2", "error_f3", "error_f4", "error_capacitance", "error_sweep",
    )  # fmt: skip
    cost_label: ClassVar[str] = "compute time (s)"
    wanted: float = 1e-3

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
