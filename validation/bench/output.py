"""A benchmark as tables on the terminal, and as files."""

from __future__ import annotations

import csv
import sys
from collections.abc import Iterable
from pathlib import Path

from geometry.files import written_whole
from validation.bench.result import Bench, Timing
from validation.formats import engineering
from validation.plots import svg


def print_bench(parts: Iterable[Bench]) -> None:
    """Print two tables per part: the ways of computing, and the requirements."""
    from rich.console import Console
    from rich.table import Table

    console = Console(width=None if sys.stdout.isatty() else 140)
    for part in parts:
        ways = Table(title=f"{part.part}: time against error ({part.seconds:.0f} s)")
        for name in ("way", "range", "points", "points per second", "ns per point", "worst error"):
            ways.add_column(name, justify="left" if name in ("way", "range") else "right")
        for t in part.timings:
            time = f"{1e9 / t.rate:.0f}"
            ways.add_row(t.path, t.case, f"{t.points:,}", f"{t.rate:,.0f}", time, f"{t.error:.1e}")
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
            writer.writerow(("way", "range", "points", "seconds", "points_per_second", "error"))
            for t in part.timings:
                writer.writerow((t.path, t.case, t.points, t.seconds, t.rate, t.error))
        written.append(path)
        path = out / f"bench-{part.part}.svg"
        with written_whole(path) as temporary:
            temporary.write_text(time_error_plot(part.timings), encoding="utf-8")
        written.append(path)
    return written


def time_error_plot(timings: Iterable[Timing]) -> str:
    """Plot worst error against time per point, one panel per range, as inline SVG."""
    from matplotlib.figure import Figure

    cases: dict[str, list[Timing]] = {}
    for timing in timings:
        cases.setdefault(timing.case, []).append(timing)
    figure = Figure(figsize=(9.0, 3.4), layout="constrained")
    panels = figure.subplots(1, len(cases), sharey=True, squeeze=False)[0]
    for axis, (case, rows) in zip(panels, cases.items(), strict=True):
        for row, marker in zip(rows, "osv^DPX*", strict=False):
            # what overflows has no digit left; shown at the top
            error = min(max(row.error, 1e-17), 1e1)
            axis.loglog([1e9 / row.rate], [error], marker, label=row.path)
        axis.axhline(1e-12, color="#D55E00", linestyle="--", linewidth=1.0)
        axis.set_ylim(1e-17, 3e1)
        axis.set_title(case, fontsize="medium")
        axis.set_xlabel("time per point (ns)")
        axis.grid(visible=True, alpha=0.25)
    panels[0].set_ylabel("worst relative error")
    panels[-1].legend(frameon=False, fontsize="small")
    return svg(figure)
