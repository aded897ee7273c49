"""What a benchmark brings back, as plain values for the table, the file and the plot."""

from __future__ import annotations

import itertools
import math
from abc import ABC, abstractmethod
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Any, ClassVar

from tactgen.geometry.csv_tables import write_csv
from tactgen.geometry.files import write_text
from tactgen.geometry.formats import engineering
from tactgen.validation.view.console import console
from tactgen.validation.view.figures import ORANGE, panels, plain_numbers, svg


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


def print_bench(parts: Iterable[Bench]) -> None:
    """Print two tables per part: the ways of computing, and the requirements."""
    from rich.table import Table

    screen = console(170)
    for part in parts:
        ways = Table(title=f"{part.part}: time against error ({part.seconds:.0f} s)")
        columns = part.timings[0].columns
        for name in columns:
            ways.add_column(name, justify="left" if name in _WORDS else "right")
        for timing in part.timings:
            ways.add_row(*timing.cells)
        screen.print(ways)
        wanted = Table(title=f"{part.part}: requirements")
        for name in ("requirement", "wanted", "measured", "", "how"):
            wanted.add_column(name)
        for target in part.targets:
            limit = ("at most " if target.at_most else "at least ") + engineering(
                target.wanted, target.unit, 3
            )
            measured = engineering(target.measured, target.unit, 3)
            verdict = "met" if target.met else "not met"
            wanted.add_row(target.what, limit, measured, verdict, target.how)
        screen.print(wanted)
        screen.print(part.conditions)


_WORDS = ("way", "range", "fineness", "result", "job")


def write_bench(parts: Iterable[Bench], out: Path) -> list[Path]:
    """Write a CSV and the time-against-error plot of every part, and return the paths."""
    written = []
    for part in parts:
        stem, rows = f"bench-{part.part}", (timing.values for timing in part.timings)
        written.append(write_csv(out / f"{stem}.csv", part.timings[0].fields, rows))
        written.append(write_text(out / f"{stem}.svg", time_error_plot(part.timings)))
    return written


#: Panels side by side, and the least error that is told apart from none.
_ACROSS, _LEAST = 3, 1e-17
#: So many ways have their legend in every panel, more share one below.
_FEW = 5
#: One look per way, the same in every panel.
_LOOKS = [
    {"color": f"C{n % 10}", "marker": "osv^DPX*<>"[n % 10], "linestyle": "-" if n < 10 else "--"}
    for n in range(20)
]


def time_error_plot(timings: Iterable[Timing]) -> str:
    """Plot error against time, one panel per case and one line per way, as inline SVG."""
    cases: dict[str, list[tuple[Timing, float]]] = {}
    for timing in timings:
        for case, error in timing.curves.items():
            cases.setdefault(case, []).append((timing, error))
    ways = list(dict.fromkeys(row.path for rows in cases.values() for row, _ in rows))
    across = min(len(cases), _ACROSS)
    down = math.ceil(len(cases) / across)
    figure, grid = panels(9.0, 3.4 * down, nrows=down, ncols=across, squeeze=False)
    axes = grid.ravel()
    for axis, (case, rows) in zip(axes, cases.items(), strict=False):
        _panel(axis, rows, ways)
        axis.set_title(case, fontsize="medium")
    for axis in axes[len(cases) :]:
        axis.set_axis_off()
    if len(ways) > _FEW:
        lines = {line.get_label(): line for axis in axes for line in axis.get_lines()}
        figure.set_size_inches(9.0, 3.4 * down + 0.25 * math.ceil(len(ways) / _ACROSS))
        figure.legend(
            [lines[way] for way in ways], ways, loc="outside lower center", ncols=_ACROSS,
            frameon=False, fontsize="small",
        )  # fmt: skip
    return svg(figure)


def _panel(axis: Any, pairs: list[tuple[Timing, float]], ways: list[str]) -> None:
    rows = [row for row, _ in pairs]
    for way, look in zip(ways, itertools.cycle(_LOOKS), strict=False):
        # what overflows has no digit left; shown at the top
        points = [
            (row.cost, min(max(error, _LEAST), 1e1)) for row, error in pairs if row.path == way
        ]
        if points:
            axis.loglog(*zip(*points, strict=True), label=way, **look)
    if not math.isnan(rows[0].wanted):
        axis.axhline(rows[0].wanted, color=ORANGE, linestyle="--", linewidth=1.0)
    plain_numbers(axis.xaxis)
    axis.set_xlabel(rows[0].cost_label)
    axis.set_ylabel("relative error")
    if len(ways) <= _FEW:
        axis.legend(frameon=False, fontsize="small")
