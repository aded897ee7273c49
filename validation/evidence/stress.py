"""Stress runs: points, rows, verdicts, tables and plots."""

from __future__ import annotations

import math
import re
import time
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from tactgen.fem.solvers.linear_solver import SolverError
from tactgen.geometry.arrays import Floats
from tactgen.geometry.csv_tables import write_csv
from tactgen.geometry.errors import InputError
from tactgen.geometry.files import write_text
from tactgen.geometry.formats import engineering
from tactgen.geometry.store.values import storable
from tactgen.validation.evidence.coverage import cached_by_code, loaded
from tactgen.validation.show.browser import console
from tactgen.validation.show.figures import new_figure, svg

#: Bounds that hold for a share of answers are missed by the rest, but by none so many times.
FAR = 3.0


@storable
@dataclass(frozen=True)
class Point:
    """Relative error at one set of parameters, against the reference."""

    where: str  #: The parameters, for people
    error: float  #: Worst relative error of all that was compared
    bound: float  #: What the error may be

    @property
    def share(self) -> float:
        """Share of its bound that the error takes; an error without one is beyond."""
        if self.error == 0.0:
            return 0.0
        known = self.bound > 0.0 and not math.isnan(self.error)
        return self.error / self.bound if known else math.inf


@storable
@dataclass(frozen=True)
class Row:
    """One family of points, judged."""

    #: What it is called, and what was varied
    family: str
    what: str
    points: int  #: How many were answered
    #: The answer with the largest error; of those beyond their bound, if there are any
    worst: Point
    over: float  #: The largest error over its bound
    verdict: str  #: ``holds``, ``holds or says why not``, or ``fails``
    refusals: tuple[str, ...] = ()  #: What was said at the points that were not answered
    #: The answers beyond their bound, that by the largest share first
    beyond: tuple[Point, ...] = ()


@storable
@dataclass(frozen=True)
class ErrorMap:
    """Errors over frequency (Hz) and length (m), each (n_length, n_frequency)."""

    title: str
    frequencies: Floats
    lengths: Floats
    error: Floats
    #: Of the printed formulas; infinite where they overflow, nan if not defined
    naive: Floats


@dataclass(frozen=True)
class Stress:
    """All that one part found."""

    part: str
    statement: str
    rows: tuple[Row, ...]
    maps: tuple[ErrorMap, ...] = ()
    seconds: float = 0.0  #: How long the run took


#: Stands for the worst of no answers.
_NONE = Point("", math.nan, math.nan)


def answered(
    family: str,
    what: str,
    points: Sequence[Point],
    refusals: Sequence[str] = (),
    *,
    promised: float = 1.0,
) -> Row:
    """Row of a family that is held against the bound of each answer.

    It fails if a refusal is not one sentence, or answers are beyond their bounds: more than the
    share for which these are `promised`, or one by :data:`FAR` of them.
    """
    beyond = [p for p in points if not p.error <= p.bound]  # nan included
    worst = max(beyond or points, key=lambda p: p.error, default=_NONE)
    over = max((p.share for p in points), default=math.nan)
    clear = all(words.strip() and "\n" not in words for words in refusals)
    holds = "holds or says why not" if refusals else "holds"
    missed = len(beyond) > (1.0 - promised) * len(points) or over > FAR
    verdict = "fails" if missed or not clear else holds
    beyond.sort(key=lambda p: p.share, reverse=True)
    return Row(family, what, len(points), worst, over, verdict, tuple(refusals), tuple(beyond))


#: What a model may say instead of a number.
REFUSALS = (InputError, SolverError, ArithmeticError)


class Family:
    """Points of one family, collected as they come; bars hold for the share `promised`."""

    def __init__(self, promised: float = 1.0) -> None:
        self.promised = promised
        self.points: list[Point] = []
        self.refusals: list[str] = []

    def add(self, where: str, error: float, bound: float) -> None:
        """Add an answer's relative error and its bound."""
        self.points.append(Point(where, float(error), float(bound)))

    def compare(self, where: str, value: float, exact: float, bar: float) -> None:
        """Take an answer with its error bar, `bar` and values in one unit."""
        size = abs(exact)
        self.add(where, abs(value - exact) / size, bar / size)

    @contextmanager
    def attempt(self) -> Iterator[None]:
        """Context that adds a refusal in place of its answers."""
        try:
            yield
        except REFUSALS as error:
            self.refusals.append(str(error))

    def row(self, name: str, what: str) -> Row:
        """Family, judged as :func:`answered` has it."""
        return answered(name, what, self.points, self.refusals, promised=self.promised)


#: Decades of relative error that the colours span.
_DECADES = (-17.0, 0.0)


def map_plot(table: ErrorMap) -> str:
    """Plot errors over frequency and length, ours beside the naive formulas'.

    Colours are decades of relative error; black is no correct digit, overflow or 0/0.
    """
    figure = new_figure(10.0, 3.4)
    axes = figure.subplots(1, 2, sharey=True)
    sides = ((axes[0], "this model", table.error), (axes[1], "matrix A", table.naive))
    for axis, title, values in sides:
        image = _decades(axis, table, values)
        axis.set_title(f"{title}: {table.title}", fontsize="medium")
        axis.set_xlabel("frequency")
    axes[0].set_ylabel("length")
    figure.colorbar(image, ax=axes.tolist(), label="log10 of the relative error", extend="max")
    return svg(figure)


def _decades(axis: Any, table: ErrorMap, values: Floats) -> Any:
    import matplotlib as mpl

    colours = mpl.colormaps["viridis"].with_extremes(over="black", bad="black")
    with np.errstate(divide="ignore"):
        shown = np.log10(np.clip(values, 10.0 ** _DECADES[0], 1e300))
    low, high = _DECADES
    image = axis.imshow(shown, cmap=colours, vmin=low, vmax=high, origin="lower", aspect="auto")
    axis.set_xticks(*_decade_ticks(table.frequencies, "Hz", every=3))
    axis.set_yticks(*_decade_ticks(table.lengths, "m", every=1))
    return image


def _decade_ticks(spaced: Floats, unit: str, every: int) -> tuple[list[float], list[str]]:
    """Places between the cells, and names, of decades; a leading 0 keeps its cell."""
    start = int(spaced[0] == 0.0)
    powers = np.log10(spaced[start:])
    cells = np.arange(start, spaced.size)
    first, last = math.ceil(powers[0] - 1e-9), math.floor(powers[-1] + 1e-9)
    decades = [d for d in range(first, last + 1) if d % every == 0]
    places = [float(np.interp(d, powers, cells)) for d in decades]
    names = [engineering(10.0**d, unit, 3) for d in decades]
    return ([0.0, *places], ["0", *names]) if start else (places, names)


def print_stress(parts: Sequence[Stress]) -> None:
    """Print one table of all parts, the refusals, and the statements."""
    from rich.table import Table

    screen = console(200)
    table = Table(title="worst errors, against what was promised of each answer")
    for name in ("part", *_SHOWN):
        table.add_column(name, justify="right" if name in _NUMBERS else "left")
    for part in parts:
        for row in part.rows:
            known = _values(row)
            table.add_row(part.part, *(_cell(name, known[name]) for name in _SHOWN))
        table.add_section()
    screen.print(table)
    for part in parts:
        for row in part.rows:
            for point in row.beyond[:_MOST]:
                words = f"{point.share:.2g} times what was promised at {point.where}"
                screen.print(f"{part.part}: {words}", markup=False)
        for said in _kinds(w for row in part.rows for w in row.refusals):
            such_as = ", such as" if len(set(said)) > 1 else ""
            words = f"refused {len(said)} x{such_as}: {said[0]}"
            screen.print(f"{part.part}: {words}", markup=False)
    for part in parts:
        screen.print(f"{part.part} ({part.seconds:.0f} s): {part.statement}", markup=False)


def _values(row: Row) -> dict[str, Any]:
    """Columns of files by their headings."""
    return {
        "family": row.family, "range": row.what, "points": row.points, "beyond": len(row.beyond),
        "worst": row.worst.error, "promised": row.worst.bound, "over bar": row.over,
        "verdict": row.verdict, "worst at": row.worst.where, "refused": len(row.refusals),
        "refusals": " | ".join(said[0] for said in _kinds(row.refusals)),
    }  # fmt: skip


#: Columns on the screen, and those of them to the right.
_SHOWN = (
    "family", "range", "points", "refused", "beyond", "worst", "promised", "over bar", "verdict",
    "worst at",
)  # fmt: skip
_NUMBERS = _SHOWN[2:8]
#: Answers beyond their bars that are printed of a family; files have all.
_MOST = 10
_NUMBER = re.compile(r"[-+]?\d+(\.\d+)?(e[-+]?\d+)?")


def _cell(name: str, value: Any) -> str:
    """Two digits of a number that is no count; words for nan and errors above 1."""
    if not isinstance(value, float):
        return str(value)
    if math.isnan(value):
        return "-"
    if name == "over bar":
        return f"{value:.2g}"
    return "no digit" if value >= 1.0 else f"{value:.1e}"


def write_stress(parts: Sequence[Stress], out: Path) -> list[Path]:
    """Write CSVs of all rows and of answers beyond, a CSV and an SVG of every map; return all."""
    rows = [{"part": part.part} | _values(row) for part in parts for row in part.rows]
    beyond = [
        (part.part, r.family, p.error, p.bound, p.share, p.where)
        for part in parts for r in part.rows for p in r.beyond
    ]  # fmt: skip
    written = [
        write_csv(out / "stress.csv", tuple(rows[0]), (row.values() for row in rows)),
        write_csv(
            out / "stress-beyond.csv",
            ("part", "family", "error", "promised", "over bar", "where"), beyond,
        ),
    ]  # fmt: skip
    for part in parts:
        for number, table in enumerate(part.maps, start=1):
            stem = f"stress-{part.part}-map-{number}"
            columns = ("length_m", "frequency_hz", "error", "naive")
            grid = np.meshgrid(table.lengths, table.frequencies, indexing="ij")
            values = np.stack([*grid, table.error, table.naive], axis=-1).reshape(-1, 4)
            written.append(write_csv(out / f"{stem}.csv", columns, values.tolist()))
            written.append(write_text(out / f"{stem}.svg", map_plot(table)))
    return written


def _kinds(refusals: Iterable[str]) -> list[list[str]]:
    """Sentences together that differ in their numbers alone, in the order of the first."""
    found: dict[str, list[str]] = {}
    for words in refusals:
        found.setdefault(_NUMBER.sub("", words), []).append(words)
    return list(found.values())


#: The range of a family and what adds its points, or what gives rows; told if a few points will do.
Judge = tuple[str, Callable[[Family, bool], None]] | Callable[[bool], Row | list[Row]]
Families = Mapping[str, Judge]


@dataclass(frozen=True)
class PartRequest:
    """Request to a part of the run."""

    quick: bool  #: Whether a few points will do
    seed: int = 0  #: Of all that is drawn
    announce: Callable[[str], None] = lambda _: None  #: Told what is being done
    #: Part and module by which results are kept; without them they are not
    kept_as: tuple[str, str] | None = None

    def keep(self, of: tuple[object, ...], work: Callable[[], Any]) -> Any:
        """Result of `work`, from the store if there is one of the same."""
        if self.kept_as is None:
            return work()
        name, module = self.kept_as
        return cached_by_code("stress", (name, *of, self.seed), module, work)

    def part(self, name: str, statement: str, families: Families) -> Stress:
        """Part with the rows of all its families, each announced before."""
        rows = list[Row]()
        for title, family in families.items():
            self.announce(title if title.startswith(name) else f"{name}: {title}")
            rows += self.keep((title, self.quick), partial(self._rows, title, family))
        return Stress(name, statement, tuple(rows))

    def _rows(self, title: str, judge: Judge) -> list[Row]:
        if callable(judge):
            found = judge(self.quick)
            return found if isinstance(found, list) else [found]
        (what, add), family = judge, Family()
        add(family, self.quick)
        return [family.row(title, what)]


#: The parts in order: module and function, from :class:`PartRequest` to :class:`Stress`.
PARTS = {
    "tmm": "stress_beam.run",
    "lateral": "stress_driven.run_lateral",
    "solid": "stress_solid.run",
    "magnetics": "stress_magnetics.run",
    "machine": "stress_machine.run",
    "random": "stress_driven.run_random",
    "faults": "faults.run",
}


def run_parts(
    names: Iterable[str], quick: bool, seed: int, announce: Callable[[str], None]
) -> list[Stress]:
    """Run the named parts of :data:`PARTS` in order.

    Each family and each random scene is kept in the store: a run that was stopped goes on with its
    seed where it was.
    """
    found = []
    for name in names:
        run, started = loaded(PARTS[name]), time.perf_counter()
        part = run(PartRequest(quick, seed, announce, (name, run.__module__)))
        found.append(replace(part, seconds=time.perf_counter() - started))
    return found
