"""Write the verification book: an index, one page a case, and the matrix of requirements."""

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
from tactgen.validation.book.orders import DIVISIONS, KINDS
from tactgen.validation.engine.results import this_origin
from tactgen.validation.evidence.case import Case, Refinement
from tactgen.validation.evidence.faults import kept_rows
from tactgen.validation.evidence.verification import (
    VERDICTS,
    Division,
    Verified,
    division,
    next_division,
    remembered,
)
from tactgen.validation.show.figures import BLUE, DARK, GREY, ORANGE, new_figure, panels, svg
from tactgen.validation.show.page import page_templates


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
    "closed forms, transfer matrices, circuits and harmonic balance divide nothing into elements, "
    "and what is solved on a mesh of the model's own choice has the bar that the model states"
)


class Convergence(NamedTuple):
    """Figure and caption, or the reason why there is none."""

    figure: str
    words: str


def converged(rows: Sequence[Verified]) -> Convergence:
    """Convergence of the first row of a case that has coarser levels."""
    case = rows[0].case
    if case.refinement is not None:
        return _errors(rows[0].group, case.id, case.refinement)
    run = [row for row in rows if row.found is not None]
    if not run:
        return Convergence("", "none of its rows was run; run them with --heavy")
    for row in run:
        levels = list(_levels(row))
        if len(levels) > 1:
            return _values(row, levels)
    return Convergence("", _WITHOUT)


def _levels(row: Verified) -> Iterator[Division]:
    """Yield a row's measurements, from its own level to coarser ones.

    Where there is no coarser one, then on the next finer.
    """
    assert row.found is not None
    yield row.found
    if row.found.kind is None:
        return
    other = next_division(row.group, row.case, row.check)
    while other is not None and other.new:
        yield other
        if not 0 < other.below < _LEVELS:
            return
        other = division(row.group, row.case, row.check, other.below + 1)


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
        f"Expected: {finest.kind.theory}; what is left of the error at the end is the model's or "
        "the reference's"
    )
    return Convergence(convergence(curves, measure, check.tolerance), words)


def _errors(group: str, name: str, refinement: Refinement) -> Convergence:
    """Errors by which a case shows its order."""
    errors = [
        remembered(group, f"{name} {level}", partial(refinement.error, level))
        for level in refinement.levels
    ]
    curve = Curve("error", refinement.levels, errors)
    return Convergence(
        convergence([curve], "intervals along an edge", 0.0), f"theory: {refinement.order}"
    )


class Unanswered(NamedTuple):
    """A problem with a known answer, and why nothing here is held against it."""

    problem: str
    why: str


UNANSWERED: tuple[Unanswered, ...] = (
    Unanswered(
        "ANSYS VM190: magnetomotive force round a loop",
        "the current that a loop encloses is put in, into the right side of one potential and the "
        "source field of the other, so that its return tests nothing",
    ),
    Unanswered(
        "ANSYS VM310: electrostatic pull-in",
        "no model here has an electrostatic force; its magnetic twin is the case SNAP",
    ),
    Unanswered(
        "NAFEMS LE1 and LE10; stresses of NAFEMS tests 5H and R0031/1 and of ANSYS VM34 and VM231, "
        "whose field strength, too",
        "boxes give displacements, forces and charges, and have no elliptic edges; stresses and "
        "fields are read off the model solid's own bimorph only",
    ),
    Unanswered(
        "ANSYS VM174: large deflection of a bimetal strip",
        "all models of the bimorph are linear; small deflections are the cases VM35 and VM144",
    ),
    Unanswered(
        "ANSYS VM183: two masses on springs",
        "its answer is the solution of two equations, of which every response here has more",
    ),
    Unanswered(
        "NASA's example of a grid convergence index (0.97050, 0.96854, 0.96178)",
        "error bars here are no grid convergence index: how they are made stands beside each, and "
        "tactgen coverage judges them",
    ),
)


#: What each group is about, for the reader who was not there.
SUBJECTS = {
    "beams": "Beams in closed form and from handbooks, by the models lumped and tmm; two as solids",
    "laminates": "Exact laminates in cylindrical bending, bimetal strips, PVDF, a patch in shear",
    "resonators": "Piezoelectric resonators of IEEE Std 176, patch test of a free block",
    "elastic": "Elastic bodies: cube, plates, torsion, rods",
    "coils": "Coils in air: inductance, force, field, circuit",
    "iron": "Bodies of iron: shielding, demagnetising factor, a slotted gap",
    "orders": "Observed orders of convergence, each with an absolute bound",
    "bimorph": "The lateral actuator: exact beam, job J1, models against each other, the paper",
    "reluctance": "The normal actuator: fields and circuits, TEAM problem 20, the paper",
    "motion": "The machine in time: oscillators with known motions, circuits, the paper's Fig 16",
    "amplitude": "Large amplitudes: oscillators with known answers, the paper's Figs 8, 14 and 15",
    "display": "The display: crosstalk, units that differ, the field between units, what fits",
    "misprints": "Printed targets that are wrong or coarse, with the proof",
}


@dataclass(frozen=True)
class Page:
    """One case with its rows and figures."""

    group: str
    case: Case
    rows: tuple[Verified, ...]
    convergence: Convergence
    sketch: str

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
    by_case = groupby(rows, key=lambda row: (row.group, row.case.id))
    pages = [_page(tuple(of_case), announce) for _, of_case in by_case]
    scatters = _scatters(rows)
    common: dict[str, Any] = {
        "pages": pages,
        "subjects": SUBJECTS,
        "scatters": scatters,
        "scatter_plot": scattered(scatters) if scatters else "",
        "provenance": _provenance(),
        "faults": kept_rows(),
        "unanswered": UNANSWERED,
        "kinds": KINDS,
        "divisions": DIVISIONS,
        "page_of": {row.check.id: page for page in pages for row in page.rows},
        "counts": {v: sum(r.verdict == v for r in rows) for v in VERDICTS},
    }
    render = _environment()
    for page in pages:
        write_text(out / page.file, render("case.html", page=page, **common))
    write_text(out / "matrix.html", render("matrix.html", **common))
    return write_text(out / "index.html", render("index.html", **common))


def _page(rows: tuple[Verified, ...], announce: Callable[[str], None]) -> Page:
    group, case = rows[0].group, rows[0].case
    announce(f"convergence of {case.id}")
    return Page(group, case, rows, converged(rows), case.setup() if case.setup else "")


def _scatters(rows: Sequence[Verified]) -> dict[str, Scatter]:
    found = {
        group: scatter(list(of_group)) for group, of_group in groupby(rows, key=lambda r: r.group)
    }
    return {group: s for group, s in found.items() if s is not None}


def _environment() -> Callable[..., str]:
    environment = page_templates("tactgen.validation.book")

    def render(name: str, **values: Any) -> str:
        return environment.get_template(name).render(**values)

    return render


def _provenance() -> dict[str, str]:
    """Provenance of the book: program, commit, libraries, machine."""
    origin = this_origin()
    return {
        "program": f"{origin.program} {origin.version}",
        "commit": origin.commit,
        "libraries": ", ".join(f"{name} {version}" for name, version in origin.libraries.items()),
        "Python": origin.python,
        "machine": origin.machine,
        "date": dt.datetime.now(dt.UTC).strftime("%Y-%m-%d"),
    }
