"""A stress run as a table on the terminal, as files, and as what the report shows."""

from __future__ import annotations

import math
import sys
from collections import Counter
from collections.abc import Callable, Iterable, Iterator
from itertools import product
from pathlib import Path
from typing import Any

from tactgen.geometry.csv_rows import write_csv
from tactgen.geometry.files import write_text
from tactgen.validation.checks.stress import run_parts
from tactgen.validation.checks.stress.plots import approach_plot, map_plot
from tactgen.validation.checks.stress.result import ErrorMap, Row, Stress


def section(
    quick: bool, announce: Callable[[str], None], names: Iterable[str] = ("tmm",)
) -> dict[str, Any]:
    """Run the named parts and return what ``report/templates/stress.html`` shows."""
    parts = run_parts(names, quick, announce)
    return {
        "stress": parts,
        "stress_maps": [map_plot(table) for part in parts for table in part.maps],
        "stress_approaches": [approach_plot(part.approaches) for part in parts if part.approaches],
    }


def print_stress(parts: Iterable[Stress]) -> None:
    """Print one table per part, and what was said where there is no answer."""
    from rich.console import Console
    from rich.table import Table

    console = Console(width=None if sys.stdout.isatty() else 170)
    for part in parts:
        table = Table(title=f"{part.part}: worst relative errors ({part.seconds:.0f} s)")
        for name in part.columns:
            table.add_column(name, justify="right" if name in _NUMBERS else "left")
        for row in part.rows:
            table.add_row(*(_CELLS[name](row) for name in part.columns))
        console.print(table)
        for words, count in Counter(w for row in part.rows for w in row.refusals).items():
            console.print(f"refused {count} x: {words}", markup=False)
        console.print(part.statement)


_CELLS: dict[str, Callable[[Row], str]] = {
    "family": lambda row: row.family,
    "points": lambda row: str(row.points),
    "refused": lambda row: str(len(row.refusals)),
    "worst": lambda row: short(row.worst.error),
    "promised": lambda row: short(row.worst.bound),
    "condition": lambda row: f"{row.worst.condition:.1e}",
    "matrix A": lambda row: short(row.naive),
    "verdict": lambda row: row.verdict,
    "worst at": lambda row: row.worst.where,
}
_NUMBERS = ("points", "refused", "worst", "promised", "condition", "matrix A")


def short(value: float) -> str:
    """Return two digits; words for what has no number."""
    if math.isnan(value):
        return "-"
    return "no digit" if value >= 1.0 else f"{value:.1e}"


def write_stress(parts: Iterable[Stress], out: Path) -> list[Path]:
    """Write a CSV of the rows, and a CSV and an SVG of every map, and return the paths."""
    written = []
    for part in parts:
        rows = (
            (r.family, r.what, r.points, r.worst.error, r.worst.bound, r.worst.condition, r.naive,
             r.verdict, r.worst.where, len(r.refusals), " | ".join(dict.fromkeys(r.refusals)))
            for r in part.rows
        )  # fmt: skip
        head = (
            "family", "what", "points", "worst", "promised", "condition", "naive", "verdict",
            "worst at", "refused", "refusals",
        )  # fmt: skip
        written.append(write_csv(out / f"stress-{part.part}.csv", head, rows))
        for number, table in enumerate(part.maps, start=1):
            stem = f"stress-{part.part}-map-{number}"
            columns = ("length_m", "frequency_hz", "error", "naive", "condition")
            written.append(write_csv(out / f"{stem}.csv", columns, _flat(table)))
            written.append(write_text(out / f"{stem}.svg", map_plot(table)))
        if part.approaches:
            plot = approach_plot(part.approaches)
            written.append(write_text(out / f"stress-{part.part}-resonance.svg", plot))
    return written


def _flat(table: ErrorMap) -> Iterator[tuple[float, ...]]:
    for i, j in product(range(table.lengths.size), range(table.frequencies.size)):
        values = (table.error[i, j], table.naive[i, j], table.condition[i, j])
        yield (float(table.lengths[i]), float(table.frequencies[j]), *map(float, values))
