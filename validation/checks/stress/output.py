"""A stress run as a table on the terminal, as files, and as what the report shows."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterable, Iterator, Sequence
from itertools import product
from pathlib import Path
from typing import Any

from tactgen.geometry.csv_tables import write_csv
from tactgen.geometry.files import write_text
from tactgen.validation.checks.stress import Asked, beam
from tactgen.validation.checks.stress.plots import approach_plot, map_plot
from tactgen.validation.checks.stress.result import ErrorMap, Row, Stress, share
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
        for row in part.rows:
            for point in row.beyond[:_MOST]:
                words = f"{share(point):.2g} times what was promised at {point.where}"
                screen.print(f"{part.part}: {words}", markup=False)
        for said in _kinds(w for row in part.rows for w in row.refusals):
            such_as = ", such as" if len(set(said)) > 1 else ""
            words = f"refused {len(said)} x{such_as}: {said[0]}"
            screen.print(f"{part.part}: {words}", markup=False)
    for part in parts:
        screen.print(f"{part.part} ({part.seconds:.0f} s): {part.statement}", markup=False)


_CELLS: dict[str, Callable[[Row], str]] = {
    "part": lambda row: "",
    "family": lambda row: row.family,
    "range": lambda row: row.what,
    "points": lambda row: str(row.points),
    "refused": lambda row: str(len(row.refusals)),
    "beyond": lambda row: str(len(row.beyond)),
    "worst": lambda row: short(row.worst.error),
    "promised": lambda row: short(row.worst.bound),
    "over bar": lambda row: "-" if math.isnan(row.over) else f"{row.over:.2g}",
    "verdict": lambda row: row.verdict,
    "worst at": lambda row: row.worst.where,
}
#: Answers beyond their bars that are printed of a family; files have all.
_MOST = 10
_NUMBER = re.compile(r"[-+]?\d+(\.\d+)?(e[-+]?\d+)?")
_NUMBERS = ("points", "refused", "beyond", "worst", "promised", "over bar")


def short(value: float) -> str:
    """Return two digits; words for what has no number."""
    if math.isnan(value):
        return "-"
    return "no digit" if value >= 1.0 else f"{value:.1e}"


def write_stress(parts: Sequence[Stress], out: Path) -> list[Path]:
    """Write CSVs of all rows and of answers beyond, a CSV and an SVG of every map; return all."""
    rows = [
        (part.part, r.family, r.what, r.points, len(r.beyond), r.worst.error, r.worst.bound, r.over,
         r.worst.condition, r.naive, r.verdict, r.worst.where, len(r.refusals),
         " | ".join(said[0] for said in _kinds(r.refusals)))
        for part in parts
        for r in part.rows
    ]  # fmt: skip
    head = (
        "part", "family", "range", "points", "beyond", "worst", "promised", "over bar",
        "condition", "naive", "verdict", "worst at", "refused", "refusals",
    )  # fmt: skip
    beyond = [
        (part.part, r.family, p.error, p.bound, share(p), p.where)
        for part in parts for r in part.rows for p in r.beyond
    ]  # fmt: skip
    written = [
        write_csv(out / "stress.csv", head, rows),
        write_csv(
            out / "stress-beyond.csv",
            ("part", "family", "error", "promised", "over bar", "where"), beyond,
        ),
    ]  # fmt: skip
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


def _kinds(refusals: Iterable[str]) -> list[list[str]]:
    """Return sentences together that differ in their numbers alone, in the order of the first."""
    found: dict[str, list[str]] = {}
    for words in refusals:
        found.setdefault(_NUMBER.sub("", words), []).append(words)
    return list(found.values())


def _flat(table: ErrorMap) -> Iterator[tuple[float, ...]]:
    for i, j in product(range(table.lengths.size), range(table.frequencies.size)):
        values = (table.error[i, j], table.naive[i, j], table.condition[i, j])
        yield (float(table.lengths[i]), float(table.frequencies[j]), *map(float, values))
