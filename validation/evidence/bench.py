"""Run time against error: timings and requirements, with table, file and plot."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from tactgen.geometry.csv_tables import write_csv
from tactgen.geometry.files import write_text
from tactgen.geometry.formats import engineering
from tactgen.validation.evidence.judgement import loaded
from tactgen.validation.show.browser import console
from tactgen.validation.show.figures import ORANGE, panels, plain_numbers, svg

#: Modules of the parts; each has ``run(quick, announce) -> Bench``.
PARTS = {
    "tmm": "bench_beam",
    "magnetics": "bench_reluctance",
    "piezo": "bench_solid",
    "skip": "bench_skip",
}


@dataclass(frozen=True)
class Timing:
    """One run of one way of computing."""

    #: The way, and the problem
    path: str
    case: str
    cost: float  #: Processor time, as plotted along x
    error: float  #: Relative; infinite where no digit is right
    #: Row of the table and of the file, by column; all rows of one part have the same
    values: Mapping[str, str | float]
    wanted: float = math.nan  #: Error asked for; nan if none is
    #: Errors to plot, one panel each; by default that of the case
    curves: Mapping[str, float] = field(default_factory=dict)
    own: bool = True  #: Whether it is this program's way or a peer's


@dataclass(frozen=True)
class Target:
    """Requirement and measured value; met if below (`at_most`) or above the wanted."""

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
    """Measurements of one part and their conditions."""

    part: str
    conditions: str
    timings: tuple[Timing, ...]
    targets: tuple[Target, ...]
    seconds: float
    cost_label: str = "time (s)"


def run_parts(names: Iterable[str], quick: bool, announce: Callable[[str], None]) -> list[Bench]:
    """Measure the named parts (keys of :data:`PARTS`) in order."""
    return [loaded(f"{PARTS[name]}.run")(quick, announce) for name in names]


#: Of a run: time (s) and error.
Point = tuple[float, float]


def front(points: Iterable[Point]) -> list[Point]:
    """Points that no other beats in both time and error, by time."""
    best: list[Point] = []
    for seconds, error in sorted(points):
        if not best or error < best[-1][1]:
            best.append((seconds, error))
    return best


def time_at_error(points: Iterable[Point], wanted: float) -> float:
    """Time (s) at which the error comes down to `wanted`.

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


#: Characters of a terminal's line, and columns of a table that fit in it.
_WIDTH, _MOST_COLUMNS = 100, 10


def print_bench(parts: Iterable[Bench]) -> None:
    """Print two tables per part: the ways of computing, and the requirements."""
    from rich.table import Table

    for part in parts:
        screen = console(_WIDTH)
        ways = Table(title=f"{part.part}: time against error ({part.seconds:.0f} s)")
        for name, value in _shown(part.timings[0]).items():
            heading = name.removesuffix("_seconds").replace("_", " ")
            left = isinstance(value, str)
            ways.add_column(heading, justify="left" if left else "right", overflow="fold")
        for timing in part.timings:
            ways.add_row(*(_cell(name, value) for name, value in _shown(timing).items()))
        screen.print(ways)
        wanted = Table(title=f"{part.part}: requirements")
        for name in ("requirement", "wanted", "measured", "", "how"):
            wanted.add_column(name, overflow="fold")
        for target in part.targets:
            limit = ("at most " if target.at_most else "at least ") + engineering(
                target.wanted, target.unit, 3
            )
            measured = engineering(target.measured, target.unit, 3)
            verdict = "met" if target.met else "not met"
            wanted.add_row(target.what, limit, measured, verdict, target.how)
        screen.print(wanted)
        screen.print(part.conditions, markup=False)


def _shown(timing: Timing) -> Mapping[str, str | float]:
    """Columns on a terminal: of many steps and errors their sum and the worst; --out has all."""
    if len(timing.values) <= _MOST_COLUMNS:
        return timing.values
    kept = {
        name: value
        for name, value in timing.values.items()
        if not name.startswith("error_") and not name.endswith("_seconds")
    }
    return {**kept, "compute_seconds": timing.cost, "error": timing.error}


def _cell(name: str, value: str | float) -> str:
    if isinstance(value, str):
        return value
    if isinstance(value, int):
        return f"{value:,}"
    if name.startswith("error"):
        return f"{value:.1e}"
    if name.endswith(("seconds", "memory")):
        return engineering(value, "s" if name.endswith("seconds") else "B", 3)
    return f"{value:,.0f}" if abs(value) >= 1e3 else f"{value:.4g}"


def write_bench(parts: Iterable[Bench], out: Path) -> list[Path]:
    """Write a CSV and the time-against-error plot of every part, and return the paths."""
    written = []
    for part in parts:
        stem, rows = f"bench-{part.part}", (t.values.values() for t in part.timings)
        written.append(write_csv(out / f"{stem}.csv", tuple(part.timings[0].values), rows))
        plot = time_error_plot(part.timings, part.cost_label)
        written.append(write_text(out / f"{stem}.svg", plot))
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


def time_error_plot(timings: Iterable[Timing], cost_label: str = "time (s)") -> str:
    """Plot error against time, one panel per case and one line per way, as inline SVG."""
    cases: dict[str, list[tuple[Timing, float]]] = {}
    for timing in timings:
        for case, error in (timing.curves or {timing.case: timing.error}).items():
            cases.setdefault(case, []).append((timing, error))
    ways = list(dict.fromkeys(row.path for rows in cases.values() for row, _ in rows))
    across = min(len(cases), _ACROSS)
    down = math.ceil(len(cases) / across)
    figure, grid = panels(9.0, 3.4 * down, nrows=down, ncols=across, squeeze=False)
    axes = grid.ravel()
    for axis, (case, rows) in zip(axes, cases.items(), strict=False):
        _panel(axis, rows, ways)
        axis.set_title(case, fontsize="medium")
        axis.set_xlabel(cost_label)
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
    axis.set_ylabel("relative error")
    if len(ways) <= _FEW:
        axis.legend(frameon=False, fontsize="small")
