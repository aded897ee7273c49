"""Write the verification book: an index, one page a case, and the matrix of requirements."""

from __future__ import annotations

import datetime as dt
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import groupby
from pathlib import Path
from typing import Any, NamedTuple

from tactgen.geometry.files import write_text
from tactgen.validation.book.figures import Convergence, Scatter, converged, scatter, scattered
from tactgen.validation.book.orders import DIVISIONS, KINDS
from tactgen.validation.engine.origin import this_origin
from tactgen.validation.evidence.case import Case
from tactgen.validation.evidence.faults import kept_rows
from tactgen.validation.evidence.verification import VERDICTS, Verified
from tactgen.validation.show.page import page_templates


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
