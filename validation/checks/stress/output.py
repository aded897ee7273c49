"""A stress run as a table on the terminal, as files, and as what the report shows."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from itertools import product
from pathlib import Path
from typing import Any

from tactgen.geometry.csv_rows import write_csv
from tactgen.geometry.files import write_text
from tactgen.validation.checks.stress import Asked, beam
from tactgen.validation.checks.stress.plots import approach_plot, map_plot
from tactgen.validation.checks.stress.result import ErrorMap, Row, Stress
from tactgen.validation.view.console import console


def section(announce: Callable[[str], None]) -> dict[str, Any]:
    """Run the transfer matrix's part on few points: what ``stress.html`` shows."""
    part = beam.run(Asked(quick=True, announce=announce))
    return {
        "stress": [part],
        "stress_maps": [map_plot(table) for table in part.maps],
        "stress_approaches": [approach_plot(part.approaches)],
    }


def print_stress(parts: Sequence[Stress]) -> None:
    """Print one table of all parts, what was said where there is no answer, and what is meant."""
    from rich.table import Table

    screen = console(200)
    table = Table(title="worst errors, against what was promised of each answer")
    for name in _CELLS:
        table.add_column(name, justify="right" if name in _NUMBERS else "left")
    for part in parts:
        for row in part.rows:
            table.add_row(part.part, *(cell(row) for cell in list(_CELLS.values())[1:]))
        table.add_section()
    screen.print(table)
    for part in parts:
        for words, count in Counter(w for row in part.rows for w in row.refusals).items():
            screen.print(f"{part.part}: refused {count} x: {words}", markup=False)
    for part in parts:
        screen.print(f"{part.part} ({part.seconds:.0f} s): {part.statement}", markup=False)


_CELLS: dict[str, Callable[[Row], str]] = {
    "part": lambda row: "",
    "family": lambda row: row.family,
    "range": lambda row: row.what,
    "points": lambda row: str(row.points),
    "refused": lambda row: str(len(row.refusals)),
    "beyond": lambda row: str(row.beyond),
    "worst": lambda row: short(row.worst.error),
    "promised": lambda row: short(row.worst.bound),
    "over bar": lambda row: "-" if math.isnan(row.over) else f"{row.over:.2g}",
    "verdict": lambda row: row.verdict,
    "worst at": lambda row: row.worst.where,
}
_NUMBERS = ("points", "refused", "beyond", "worst", "promised", "over bar")


def short(value: float) -> str:
    """Return two digits; words for what has no number."""
    if math.isnan(value):
        return "-"
    return "no digit" if value >= 1.0 else f"{value:.1e}"


def write_stress(parts: Sequence[Stress], out: Path) -> list[Path]:
    """Write one CSV of all rows, and a CSV and an SVG of every map, and return the paths."""
    rows = [
        (part.part, r.family, r.what, r.points, r.beyond, r.worst.error, r.worst.bound, r.over,
         r.worst.condition, r.naive, r.verdict, r.worst.where, len(r.refusals),
         " | ".join(dict.fromkeys(r.refusals)))
        for part in parts
        for r in part.rows
    ]  # fmt: skip
    head = (
        "part", "family", "range", "points", "beyond", "worst", "promised", "over bar",
        "condition", "naive", "verdict", "worst at", "refused", "refusals",
    )  # fmt: skip
    written = [write_csv(out / "stress.csv", head, rows)]
    for part in parts:
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
