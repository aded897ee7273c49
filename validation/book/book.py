"""The verification book: an index, one page a case, and the matrix of requirements."""

from __future__ import annotations

import datetime as dt
import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from itertools import groupby
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from tactgen.geometry.arrays import Floats
from tactgen.geometry.files import write_text
from tactgen.validation.engine.origin import this_origin
from tactgen.validation.evidence.calibration import shipped
from tactgen.validation.evidence.case import Case
from tactgen.validation.evidence.faults import cached_rows
from tactgen.validation.evidence.fit_record import CURVE
from tactgen.validation.evidence.judgement import shares_plot
from tactgen.validation.evidence.verification import (
    GROUPS,
    VERDICTS,
    Division,
    Verified,
    division,
    next_division,
    remembered,
)
from tactgen.validation.show.figures import BLUE, DARK, GREY, ORANGE, new_figure, panels, svg
from tactgen.validation.show.page import page_templates

#: Problems with a known answer, and why nothing here is compared with it.
UNANSWERED = {
    "ANSYS VM190: magnetomotive force round a loop":
        "the enclosed current is an input of both formulations (right-hand side and source field), "
        "so the loop integral would test nothing",
    "ANSYS VM310: electrostatic pull-in":
        "no model here has an electrostatic force; the magnetic equivalent is the case SNAP",
    "NAFEMS LE1 and LE10; stresses of NAFEMS tests 5H and R0031/1 and of ANSYS VM34 and VM231, "
    "whose field strength, too":
        "box cases give displacements, forces and charges and have no elliptic edges; stresses "
        "and fields are evaluated for the bimorph of the model solid only",
    "ANSYS VM174: large deflection of a bimetal strip":
        "all models of the bimorph are linear; small deflections are the cases VM35 and VM144",
    "ANSYS VM183: two masses on springs":
        "its answer is a system of two equations; every response here solves a larger one",
    "NASA's example of a grid convergence index (0.97050, 0.96854, 0.96178)":
        "error bars here are not a grid convergence index; each names its method, and "
        "tactgen coverage tests them",
}  # fmt: skip

KINDS = ("at rest", "eigenvalue", "driven, with losses")
_STATIC = "magnetostatics has none"
#: By way of dividing, the rows that show the order of each kind, or why no order can be seen.
DIVISIONS: dict[str, tuple[tuple[str, ...] | str, ...]] = {
    "beam elements of degree five": (
        "exact on uniform pieces: no convergence to observe", ("BEAMO-1",), ("BEAMO-3",),
    ),
    **{
        f"bricks of degree {p}": (
            (f"MMSB-{4 * p - 3}",), (f"ROD-{p}", *((f"CYLO-{p - 1}",) if p in (2, 3) else ())),
            (f"MMSB-{4 * p - 1}",),
        )
        for p in (1, 2, 3, 4)
    },
    **{
        f"quadratic {cells}": (
            (f"MMSC-{6 * i + 1}", f"MMSC-{6 * i + 5}"), (f"MMSE-{2 * i + 1}",),
            (f"MMSC-{6 * i + 3}",),
        )
        for i, cells in enumerate((
            "tetrahedra, straight", "tetrahedra, curved", "hexahedra, rectangular",
        ))
    },
    **{
        f"quads of a half section, order {p}": (
            (f"AXIO-{p - 1}", f"AXIO-{p + 3}"), _STATIC, _STATIC,
        )
        for p in (2, 4)
    },
    **{
        f"{words}, straight and curved": (
            (f"MAGO-{4 * i + 1}", f"MAGO-{4 * i + 3}"), _STATIC, _STATIC,
        )
        for i, words in enumerate((
            "second-order edge elements (A)", "quadratic scalar potential (φ)",
        ))
    },
}  # fmt: skip


@dataclass(frozen=True)
class Page:
    """One case with its rows and figures."""

    group: str
    case: Case
    rows: tuple[Verified, ...]
    convergence: Convergence

    @property
    def file(self) -> str:
        """Name of the page."""
        return f"{self.group}-{self.case.id}.html".lower()

    @property
    def verdict(self) -> str:
        """The worst verdict of its rows."""
        verdicts = {row.verdict for row in self.rows}
        return next(v for v in ("fail", "explained", "pass", "skipped") if v in verdicts)


def write_book(rows: Sequence[Verified], out: Path, announce: Callable[[str], None]) -> Path:
    """Write the book of verified rows into a folder and return its index.

    Raises InputError if a page cannot be written.
    """
    pages = []
    for (group, name), of_case in groupby(rows, key=lambda row: (row.group, row.case.id)):
        announce(f"convergence of {name}")
        case_rows = tuple(of_case)
        pages.append(Page(group, case_rows[0].case, case_rows, converged(case_rows)))
    by_group = groupby(rows, key=lambda row: row.group)
    scatters = {group: found for group, of in by_group if (found := scatter(list(of)))}
    common: dict[str, Any] = {
        "pages": pages, "subjects": GROUPS, "scatters": scatters,
        "scatter_plot": scattered(scatters) if scatters else "",
        "provenance": _provenance(), "faults": cached_rows(), "unanswered": UNANSWERED,
        "kinds": KINDS, "divisions": DIVISIONS,
        "page_of": {row.check.id: page for page in pages for row in page.rows},
        "counts": {v: sum(r.verdict == v for r in rows) for v in VERDICTS},
    }  # fmt: skip
    environment = page_templates("tactgen.validation.book")

    def write(name: str, template: str, **values: Any) -> Path:
        return write_text(out / name, environment.get_template(template).render(**common, **values))

    for page in pages:
        write(page.file, "case.html", page=page)
    write("matrix.html", "matrix.html")
    known = {name: {**part, "figure": _curves(part)} for name, part in shipped().items()}
    write("modelling.html", "modelling.html", modelling=known)
    return write("index.html", "index.html")


def _provenance() -> dict[str, str]:
    """What made the book: program, commit where there is one, libraries, machine."""
    origin = this_origin()
    return {
        "program": f"{origin.program} {origin.version}",
        "commit": origin.commit,
        "libraries": ", ".join(f"{name} {version}" for name, version in origin.libraries.items()),
        "Python": origin.python,
        "machine": origin.machine,
        "date": dt.datetime.now(dt.UTC).strftime("%Y-%m-%d"),
    }


@dataclass(frozen=True)
class Scatter:
    """Measured values over references of a group's rows that have one number to meet."""

    #: (n,) Absolute values; a row whose signs differ is left out and counted as a fail anyway
    measured: Floats
    reference: Floats
    #: exp of the mean of ln(measured/reference), with the half variance of a log-normal
    bias: float
    spread: float  #: Standard deviation of ln(measured/reference): the relative scatter


def scatter(rows: Sequence[Verified]) -> Scatter | None:
    """Scatter of the rows that were to agree, or None if fewer than two have a number.

    Rows that differ for a stated reason are not counted: they say nothing about the models.
    """
    pairs = [
        (row.outcome.measured, row.check.reference)
        for row in rows
        if row.outcome is not None
        and row.verdict in ("pass", "fail")
        and isinstance(row.check.reference, float | int)
        and row.outcome.measured * row.check.reference > 0.0
    ]
    if len(pairs) < 2:
        return None
    measured, reference = np.abs(np.array(pairs)).T
    logarithms = np.log(measured / reference)
    spread = float(logarithms.std(ddof=1))
    bias = math.exp(float(logarithms.mean()) + 0.5 * spread**2)
    return Scatter(measured, reference, bias, spread)


#: Errors below this are rounding, and drawn here.
_ROUNDING = 1e-16
#: Lines of errors, and of changes from level to level.
_STYLES = (("o-", BLUE), ("s--", GREY))


class Curve(NamedTuple):
    """Relative errors or changes over sizes."""

    name: str
    sizes: Sequence[int]
    errors: Sequence[float]


def convergence(curves: Sequence[Curve], measure: str, tolerance: float) -> str:
    """Relative errors over a measure of fineness, with the row's tolerance."""
    figure, axis = panels(6.4, 3.4)
    for curve, (mark, color) in zip(curves, _STYLES[: len(curves)], strict=True):
        axis.plot(
            curve.sizes, np.maximum(np.abs(curve.errors), _ROUNDING), mark, color=color,
            label=curve.name,
        )  # fmt: skip
    axis.set_yscale("log")
    if tolerance > 0.0:
        axis.axhline(tolerance, color=ORANGE, linestyle=":", linewidth=1.0, label="tolerance")
    sizes = sorted({size for curve in curves for size in curve.sizes})
    if sizes[0] > 0:
        axis.set_xscale("log")
    axis.set_xticks(sizes, [f"{size:,}".replace(",", " ") for size in sizes])
    axis.minorticks_off()
    axis.set_xlabel(measure)
    axis.set_ylabel("relative")
    axis.legend(fontsize=8, labelcolor=DARK)
    return svg(figure)


def _curves(part: dict[str, Any]) -> str:
    """Share of modelling errors within a multiple of those stated, a curve for each number."""
    curves = {
        f"{kind}: {name.replace('_', ' ')}": row["curve"]
        for kind, fit in part.items() if isinstance(fit, dict) and "evidence" in fit
        for name, row in fit["evidence"]["errors"].items()
    }  # fmt: skip
    return shares_plot(curves, CURVE, "stated error", fontsize=6, labelcolor=DARK)


def scattered(groups: dict[str, Scatter]) -> str:
    """All groups' values over their references, on one logarithmic square."""
    figure = new_figure(6.4, 5.6)
    axis = figure.add_subplot()
    low = min(float(s.reference.min()) for s in groups.values())
    high = max(float(s.reference.max()) for s in groups.values())
    axis.loglog([low, high], [low, high], color=GREY, linewidth=1.0)
    marks = "os^Dv<>Pp*hX"
    for mark, (name, found) in zip(marks, groups.items(), strict=False):
        axis.loglog(
            found.reference, found.measured, mark, label=name, markersize=5,
            markerfacecolor="none",
        )  # fmt: skip
    axis.set_xlabel("reference (SI or the case's own units)")
    axis.set_ylabel("computed")
    axis.grid(visible=True, alpha=0.25)
    axis.legend(fontsize=8, labelcolor=DARK)
    return svg(figure)


#: How many levels coarser than its own a case is solved: they cost less each time.
_LEVELS = 3
_WITHOUT = (
    "closed forms, transfer matrices, circuits and harmonic balance have no mesh; where the model "
    "chooses its own mesh, the model's error estimate is used"
)


class Convergence(NamedTuple):
    """The figure, empty where there is none; what it shows, or why there is none."""

    figure: str
    words: str


def converged(rows: Sequence[Verified]) -> Convergence:
    """How the first of a case's rows that can be solved more coarsely converges."""
    case = rows[0].case
    if case.refinement is not None:
        levels, error, order = case.refinement
        errors = [
            remembered(rows[0].group, f"{case.id} {level}", partial(error, level))
            for level in levels
        ]
        figure = convergence([Curve("error", levels, errors)], "intervals along an edge", 0.0)
        return Convergence(figure, f"theory: {order}")
    run = [row for row in rows if row.found is not None]
    if not run:
        return Convergence("", "none of its rows has been run; run them with --heavy")
    for row in run:
        divisions = list(_levels(row))
        if len(divisions) > 1:
            return _values(row, divisions)
    return Convergence("", _WITHOUT)


def _levels(row: Verified) -> Iterator[Division]:
    """Yield what a row measures, from its own level to coarser ones as far as they differ.

    Where there is no coarser one, then on the next finer.
    """
    assert row.found is not None
    yield row.found
    other = next_division(row.group, row.check) if row.found.kind else None
    while other is not None and other.new:
        yield other
        if not 0 < other.below < _LEVELS:
            return
        other = division(row.group, row.check, other.below + 1)


def _values(row: Verified, levels: Sequence[Division]) -> Convergence:
    """Errors against the reference where it is one number, and changes to the finest."""
    levels, check = sorted(levels, key=lambda level: level.below), row.check
    finest = levels[0]
    assert finest.kind is not None
    measure = finest.kind.measure if all(level.count for level in levels) else "level"
    sizes = [level.count if measure != "level" else -i for i, level in enumerate(levels)]
    scale = max(abs(level.value) for level in levels) or 1.0
    curves = [Curve("change to the finest", sizes[1:],
                    [abs(level.value - finest.value) / scale for level in levels[1:]])]  # fmt: skip
    reference = check.reference
    if not isinstance(reference, tuple) and reference != 0.0:
        errors = [abs(level.value / reference - 1.0) for level in levels]
        curves.insert(0, Curve("error", sizes, errors))
    words = (
        f"row {check.id}, from right to left each point with {finest.kind.coarser}. "
        f"Expected: {finest.kind.theory}; the error left at the finest level is that of the "
        "model or the reference"
    )
    return Convergence(convergence(curves, measure, check.tolerance), words)
