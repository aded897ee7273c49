"""A benchmark as tables on the terminal, and as files."""

from __future__ import annotations

import csv
import math
import sys
from collections.abc import Iterable
from pathlib import Path
from typing import Any

from geometry.files import written_whole
from validation.bench.result import Bench, FieldTiming, Timing
from validation.formats import engineering
from validation.plots import svg


def print_bench(parts: Iterable[Bench]) -> None:
    """Print two tables per part: the ways of computing, and the requirements."""
    from rich.console import Console
    from rich.table import Table

    console = Console(width=None if sys.stdout.isatty() else 140)
    for part in parts:
        ways = Table(title=f"{part.part}: time against error ({part.seconds:.0f} s)")
        columns = part.timings[0].columns
        for name in columns:
            ways.add_column(name, justify="left" if name in _WORDS else "right")
        for timing in part.timings:
            ways.add_row(*timing.cells)
        console.print(ways)
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
        console.print(wanted)
        console.print(part.conditions)


_WORDS = ("way", "range", "fineness", "result")


def write_bench(parts: Iterable[Bench], out: Path) -> list[Path]:
    """Write a CSV and the time-against-error plot of every part, and return the paths."""
    written = []
    for part in parts:
        path = out / f"bench-{part.part}.csv"
        with (
            written_whole(path) as temporary,
            temporary.open("w", newline="", encoding="utf-8") as file,
        ):
            writer = csv.writer(file)
            writer.writerow(part.timings[0].fields)
            writer.writerows(timing.values for timing in part.timings)
        written.append(path)
        path = out / f"bench-{part.part}.svg"
        with written_whole(path) as temporary:
            temporary.write_text(time_error_plot(part.timings), encoding="utf-8")
        written.append(path)
    return written


#: Panels side by side, and the least error that is told apart from none.
_ACROSS, _LEAST = 3, 1e-17


def time_error_plot(timings: Iterable[Timing | FieldTiming]) -> str:
    """Plot error against time, one panel per case and one line per way, as inline SVG."""
    from matplotlib.figure import Figure

    cases: dict[str, list[Timing | FieldTiming]] = {}
    for timing in timings:
        cases.setdefault(timing.case, []).append(timing)
    across = min(len(cases), _ACROSS)
    down = math.ceil(len(cases) / across)
    figure = Figure(figsize=(9.0, 3.4 * down), layout="constrained")
    panels = figure.subplots(down, across, squeeze=False).ravel()
    for axis, (case, rows) in zip(panels, cases.items(), strict=False):
        _panel(axis, rows)
        axis.set_title(case, fontsize="medium")
    for axis in panels[len(cases) :]:
        axis.set_axis_off()
    return svg(figure)


def _panel(axis: Any, rows: list[Timing | FieldTiming]) -> None:
    from matplotlib.ticker import LogLocator, NullFormatter

    ways: dict[str, list[Timing | FieldTiming]] = {}
    for row in rows:
        ways.setdefault(row.path, []).append(row)
    for (way, levels), marker in zip(ways.items(), "osv^DPX*", strict=False):
        # what overflows has no digit left; shown at the top
        errors = [min(max(level.error, _LEAST), 1e1) for level in levels]
        axis.loglog([level.cost for level in levels], errors, f"{marker}-", label=way)
    if not math.isnan(rows[0].wanted):
        axis.axhline(rows[0].wanted, color="#D55E00", linestyle="--", linewidth=1.0)
    # times span a decade at times, where the default labels run into each other
    axis.xaxis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
    axis.xaxis.set_major_formatter("{x:g}")
    axis.xaxis.set_minor_formatter(NullFormatter())
    axis.set_xlabel(rows[0].cost_label)
    axis.set_ylabel("relative error")
    axis.grid(visible=True, alpha=0.25)
    axis.legend(frameon=False, fontsize="small")
