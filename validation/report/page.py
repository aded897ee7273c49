"""Write the report: solve, gather the sections, render, put the file in place."""

from __future__ import annotations

import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

from tactgen.geometry.files import writable_folder, write_text, written_whole
from tactgen.validation.report.provenance import FILE, SUMS, read_record, recorded, seal
from tactgen.validation.report.report_data import Study
from tactgen.validation.report.request import check_report
from tactgen.validation.report.sections.contents import sections, work_ahead
from tactgen.validation.report.summary import counted, summary
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
    with study.ahead(work_ahead(study)):
        page = _page(study, started)
    (out / SUMS).unlink(missing_ok=True)  # of an earlier report, which this one makes untrue
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
        "counts": counted(study),
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
    last = {"sections": bodies, "date": time.strftime("%Y-%m-%d"), "viewer_assets": viewer}
    return environment.get_template("page.html").render(common | summary(study) | last)
