"""A study as one self-contained page: its aims, sliders over its axes, the picture, the table.

The sliders go from one baked point to the next.  Where a surrogate answers for a model, the
points are a finer grid than the study's own.
"""

from __future__ import annotations

import html
import json
import math
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

from tactgen.geometry.errors import InputError
from tactgen.geometry.files import write_text
from tactgen.validation.catalogue.models import MODELS, gives
from tactgen.validation.catalogue.quantities import QUANTITIES
from tactgen.validation.engine.answers import Answer, representative
from tactgen.validation.show.page import plain_page
from tactgen.validation.studies.whatif.aim_evaluation import Verdict, sentences
from tactgen.validation.studies.whatif.axes import Axis
from tactgen.validation.studies.whatif.definition import Statement
from tactgen.validation.studies.whatif.output_files import heading, table_lines
from tactgen.validation.studies.whatif.pictures import aim_picture, study_picture
from tactgen.validation.studies.whatif.study import Study, StudySolver

#: File of the page, and the script that moves it.
FILE = "study.html"
_SCRIPT = Path(__file__).with_name("slider.js")
_BAKED = "Each value is that of the nearest point that is in this page, with its bar."
#: Values of an axis of the finer grid, by how many axes there are.
_FINE = {1: 201, 2: 31}
#: Most points of a page's grid, which is read whole by a browser.
_MOST = 20_000


def write_page(
    folder: Path,
    study: Study,
    found: Verdict | None = None,
    announce: Callable[[str], None] = lambda _: None,
) -> Path:
    """Write the page, whole or not at all; `found` is the verdict of the aims."""
    stated = study.statement
    parts = [f"<p>{html.escape(_asked(stated))}</p>"]
    if found is not None:
        parts += _aims(study, found)
    if _has_sliders(stated):
        parts += _sliders(study, announce)
    try:
        parts += ["<h2>Picture</h2>", f"<figure>{study_picture(study)}</figure>"]
    except InputError as error:  # no axis is a number
        parts.append(f"<p>No picture: {html.escape(str(error))}</p>")
    table = html.escape("\n".join(table_lines(study)))
    parts += [f'<h2>Points</h2><div class="wide"><pre>{table}</pre></div>']
    parts.append(
        "<p>The bars are numerical: how far a number is from the same model solved exactly. All "
        "numbers are in study.csv and study.nc.</p>"
    )
    return write_text(folder / FILE, plain_page(f"What if: {stated.scene}", parts))


def _aims(study: Study, found: Verdict) -> list[str]:
    """Aims in words and as a picture."""
    said = html.escape("\n".join(sentences(study, found)))
    parts = [f'<h2>Aims</h2><div class="wide"><pre>{said}</pre></div>']
    if found.judged:
        parts.append(f"<figure>{aim_picture(study, found)}</figure>")
    return parts


def _asked(stated: Statement) -> str:
    axes = ", ".join(f"{axis.key} = {axis.text}" for axis in stated.axes)
    samples = f", {stated.samples} samples" if stated.samples else ""
    return f"Scene {stated.scene}; {axes}{samples}; by {', '.join(stated.models)}."


def _has_sliders(stated: Statement) -> bool:
    """Whether the points are a grid over axes of which one at least is a number."""
    plain = not stated.zipped and not stated.samples
    return plain and stated.size <= _MOST and any(axis.numeric for axis in stated.axes)


def _sliders(study: Study, announce: Callable[[str], None]) -> list[str]:
    stated = study.statement
    grids, told = [], []
    for model in stated.models:
        given = [answers[model] for answers in study.answers]
        statement, own = stated, True
        finer = _finer(stated, model) if study.counts.interpolated else None
        if finer is not None:
            announce(f"{model}: a finer grid for the page")
            box = {a.key: (min(a.values), max(a.values)) for a in finer.axes if len(a.values) > 1}
            solver = StudySolver(finer, announce=announce, ranges=box)
            answers = solver.answers(list(finer.points()))
            statement, given, own = finer, [found[model] for found in answers], False
        grids.append(_grid(statement, model, given))
        told.append(
            f"{model}: the study's own {len(given)} points" if own
            else f"{model}: {len(given)} points interpolated between solutions"
        )  # fmt: skip
    data = {
        "axes": [
            {"key": a.key, "unit": a.unit, "numeric": a.numeric, "values": list(a.values)}
            for a in stated.axes
        ],
        "quantities": [
            {"name": name, "unit": QUANTITIES[name].unit, "label": heading(study, name)}
            for name in stated.quantities if QUANTITIES[name].unit != "SI"
        ],
        "grids": grids,
    }  # fmt: skip
    text = json.dumps(data, allow_nan=False).replace("<", "\\u003c")
    return [
        "<h2>Slide</h2>",
        f"<p>{_BAKED} {html.escape('; '.join(told))}.</p>",
        '<div id="sliders"></div><div class="wide"><table id="answers"></table></div>',
        '<p><label>Curve of <select id="quantity"></select></label></p>',
        '<figure><svg id="curve" viewBox="0 0 900 320" role="img"></svg></figure>',
        f'<script type="application/json" id="study-data">{text}</script>',
        f"<script>{_SCRIPT.read_text(encoding='utf-8')}</script>",
    ]


def _finer(stated: Statement, model: str) -> Statement | None:
    """Statement of a finer grid, if a surrogate may answer it and there is room."""
    numeric = [axis for axis in stated.axes if axis.numeric]
    if MODELS[model].quick or len(numeric) not in _FINE:
        return None
    count = _FINE[len(numeric)]
    vary = tuple(_stated_finer(axis, count) for axis in stated.axes)
    finer = replace(stated, vary=vary, models=(model,))
    return finer if finer.size <= _MOST else None


def _stated_finer(axis: Axis, count: int) -> str:
    if not axis.numeric:
        return f"{axis.key}={axis.text}"
    low, high = min(axis.values), max(axis.values)
    return f"{axis.key}={low!r} {axis.unit}:{high!r} {axis.unit}:{count}"


def _grid(stated: Statement, model: str, answers: list[Answer]) -> dict[str, Any]:
    """Model's numbers over the grid, null where there are none."""
    numbers: dict[str, Any] = {}
    for name in stated.quantities:
        if not gives(model, name):
            continue
        found = [_number(answer, name) for answer in answers]
        numbers[name] = {"value": [v for v, _ in found], "bar": [b for _, b in found]}
    return {"model": model, "axes": [list(a.values) for a in stated.axes], "numbers": numbers}


def _number(answer: Answer, name: str) -> tuple[float | None, float | None]:
    for q in answer.quantities:
        if q.name == name:
            shown = representative(q)
            return (
                shown.value if math.isfinite(shown.value) else None,
                float(f"{shown.error:.3g}") if math.isfinite(shown.error) else None,
            )
    return None, None
