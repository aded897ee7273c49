"""A benchmark as tables on the terminal, and as files."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterable
from pathlib import Path
from typing import Any

from tactgen.geometry.csv_tables import write_csv
from tactgen.geometry.files import write_text
from tactgen.geometry.formats import engineering
from tactgen.validation.bench.result import Bench, Timing
from tactgen.validation.view.console import console
from tactgen.validation.view.figures import ORANGE, panels, plain_numbers, svg


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
