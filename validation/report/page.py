"""Write the report: solve, gather the sections, render, put the file in place."""

from __future__ import annotations

import math
import tempfile
import time
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from tactgen.geometry.files import writable_folder, write_text, written_whole
from tactgen.validation.catalogue.models import MODELS
from tactgen.validation.catalogue.quantities import QUANTITIES
from tactgen.validation.engine.comparison import ComparedRow
from tactgen.validation.engine.warnings import accuracy_warnings
from tactgen.validation.models.difference import Band, expected_differences
from tactgen.validation.report.provenance import FILE, read_record, recorded, seal, unseal
from tactgen.validation.report.report_data import Study
from tactgen.validation.report.request import check_report, is_of_rest
from tactgen.validation.report.sections.contents import APPENDIX, sections
from tactgen.validation.scene.scene import Scene
from tactgen.validation.show.browser import anchor_pages, print_pdf
from tactgen.validation.show.page import assets, page_templates

if TYPE_CHECKING:
    from jinja2 import Environment

#: Name of the report's page.
PAGE = "index.html"


def write_report(
    scene: Scene, origins: dict[str, str], out: Path, quick: bool, announce: Callable[[str], None]
) -> Path:
    """Write ``index.html`` and its record into `out`; return its path.

    Raises InputError if the folder cannot be written or the scene cannot be solved.
    """
    check_report(scene, quick=quick)
    writable_folder(out)
    started = time.perf_counter()
    study = Study(scene, origins, announce, quick=quick)
    page = _page(study, started)
    unseal(out)
    written = write_text(out / PAGE, page)
    seal(out, recorded(study.solution), (PAGE,))
    return written


def print_report(browser: str, page: Path) -> Path:
    """Print a report to ``report.pdf`` beside it and return its path.

    Twice: what page each section begins on, for the contents, is known of a printed one only.

    Raises InputError if the browser does not write it.
    """
    target = page.with_name("report.pdf")
    with written_whole(target) as temporary:
        print_pdf(browser, page, temporary)
        pages = anchor_pages(temporary.read_bytes())
        with tempfile.TemporaryDirectory() as folder:
            draft = Path(folder) / page.name
            draft.write_text(_with_pages(page.read_text("utf-8"), pages), "utf-8")
            print_pdf(browser, draft, temporary)
    if page.name == PAGE and (page.parent / FILE).is_file():
        seal(page.parent, read_record(page.parent), (PAGE, target.name))
    return target


def _with_pages(html: str, pages: dict[str, int]) -> str:
    """Page with page numbers in its contents, where only print shows them."""
    for name, number in pages.items():
        html = html.replace(f'data-of="{name}"></span>', f'data-of="{name}">{number}</span>', 1)
    return html


def templates() -> Environment:
    """Report's templates, with the filters that write numbers."""
    return page_templates("tactgen.validation.report")


def _page(study: Study, started: float) -> str:
    environment = templates()
    shown = []
    for section in sections(study):
        found = section.context(study)
        if found is not None:
            study.shown[section.id] = found
            shown.append((section, found))
    numbers = {section.id: number for number, (section, _) in enumerate(shown, start=1)}
    common: dict[str, Any] = {
        "scene": study.scene,
        "solution": study.solution,
        "quick": study.quick,
        "number": numbers,
        "seconds": time.perf_counter() - started,
        "lateral": study.lateral,
        "normal": study.normal,
        "turns_are_set": study.normal is not None and study.normal.turns_are_set,
    }
    bodies = [
        {
            "id": section.id,
            "title": section.title,
            "html": environment.get_template(f"{section.id}.html").render(common | found),
        }
        for section, found in shown
    ]
    viewer = assets() if any({"viewer", "film"} & set(found) for _, found in shown) else ""
    first = {shown[0][0].id: "For the engineer"}
    first |= {next(s.id for s, _ in shown if s.id in APPENDIX): "Appendix"}
    last = {
        "sections": bodies,
        "parts": first,
        "date": time.strftime("%Y-%m-%d"),
        "viewer_assets": viewer,
    }
    return environment.get_template("page.html").render(common | summary(study) | last)


def summary(study: Study) -> dict[str, Any]:
    """Summary at the head of the page."""
    uncertain = study.parameter_uncertainty if study.lateral else []
    moment = study.shown.get("support", {}).get("moment")
    most_detailed = [row.cells[-1] for row in study.compared]
    return {
        "lateral_rows": study.comparison if study.lateral else [],
        "normal_rows": study.normal.comparison if study.normal else [],
        "spread": {
            "lateral": _spread(study.comparison if study.lateral else []),
            "normal": _spread(study.normal.comparison if study.normal else []),
        },
        "rests": any(is_of_rest(row.quantity) for row in study.compared),
        "asked_for": {
            "models": study.scene.models,
            "quantities": len({q.name for q in study.solution.quantities}),
        },
        "statuses": _statuses(study),
        "tipped": moment if moment and moment["largest"] > moment["tipping"] else None,
        "known": [u for u in uncertain if u.target.quantity.headline],
        "invariants": study.invariants,
        "unlike": sum(o.status == "explained" and not o.check.fitted for o in study.outcomes),
        "failed": sum(o.status == "fail" for o in study.outcomes),
        "parameters": study.parameters,
        "bridge": study.steps,
        "left_out": _left_out(study),
        "asked": study.asked,
        "bars": len(most_detailed),
        "missed": sum(c.error > study.scene.accuracy * abs(c.value) for c in most_detailed),
        "others_missed": list(accuracy_warnings(study.scene, study.solution.quantities)),
    }


def _statuses(study: Study) -> list[tuple[str, int]]:
    """Counts of the scene's checks by verdict, best first."""
    found = [outcome.status for outcome in study.outcomes]
    order = ("pass", "explained")
    return [(status, found.count(status)) for status in order if status in found]


def _left_out(study: Study) -> list[tuple[str, Band]]:
    """Expected error of beam theory where no solid was solved."""
    models = study.solution.models_of("bimorph")
    if not models or any(MODELS[name].theory == "solid" for name in models):
        return []
    return [(QUANTITIES[name].label, b) for name, b in expected_differences(study.scene).items()]


def _spread(rows: Sequence[ComparedRow]) -> dict[str, float]:
    """Widest error bar and the largest difference between models, as fractions.

    The difference of places of rest is none of size: of two stops models may take either.
    """
    cells = [cell for row in rows for cell in row.cells if math.isfinite(cell.value)]
    sized = [cell for row in rows if not is_of_rest(row.quantity) for cell in row.cells]
    apart = [abs(c.difference) for c in sized if math.isfinite(c.value)]
    return {
        "widest": max((c.error / abs(c.value) for c in cells if c.value), default=0.0),
        "farthest": max((size for size in apart if not math.isnan(size)), default=0.0),
    }
