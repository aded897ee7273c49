"""A study as one self-contained page: aims, sliders over its axes, the picture, the table."""

from __future__ import annotations

import html
import math
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

from tactgen.geometry.errors import InputError
from tactgen.geometry.files import write_text
from tactgen.validation.catalogue.models import gives
from tactgen.validation.catalogue.quantities import QUANTITIES
from tactgen.validation.show.page import data_script, plain_page, table
from tactgen.validation.studies.whatif.aim_evaluation import Verdict, sentences
from tactgen.validation.studies.whatif.output_files import (
    column,
    heading,
    sample_statistics,
    statistics_rows,
    table_rows,
)
from tactgen.validation.studies.whatif.pictures import aim_picture, study_picture
from tactgen.validation.studies.whatif.study import Study

#: File of the page, and the script that moves it.
FILE = "study.html"
_SCRIPT = Path(__file__).with_name("slider.js")
#: Most points that sliders move over, which a browser reads whole.
_MOST = 20_000


def write_page(folder: Path, study: Study, found: Sequence[Verdict] | None = None) -> Path:
    """Write the page, whole or not at all; `found` is what the models say of the aims."""
    stated = study.statement
    axes = ", ".join(f"{axis.key} = {axis.text}" for axis in stated.axes)
    samples = f", {stated.samples} samples" if stated.samples else ""
    asked = f"Scene {stated.scene}; {axes}{samples}; models {', '.join(stated.models)}."
    parts = [f"<p>{html.escape(f'{asked} {stated.conditions}')}</p>"]
    if warnings := (*study.without_effect, *study.warnings):
        listed = "".join(f"<li>{html.escape(words)}</li>" for words in warnings)
        parts += ["<h2>What could be wrong</h2>", f"<ul>{listed}</ul>"]
    if found is not None:
        text = html.escape("\n".join(sentences(study, found)))
        parts += ["<h2>Aims</h2>", f'<pre style="white-space: pre-wrap">{text}</pre>']
        if found:
            parts += _figure(lambda: aim_picture(study, found))
    # a grid of points over axes of which one at least is a number
    is_grid = not stated.zipped and not stated.samples and stated.size <= _MOST
    if is_grid and any(axis.numeric for axis in stated.axes):
        parts += _sliders(study)
    parts += ["<h2>Picture</h2>", *_figure(lambda: study_picture(study))]
    if statistics := sample_statistics(study):
        parts += ["<h2>Statistics</h2>", table(*statistics_rows(study, statistics))]
    heads, rows, left_out = table_rows(study)
    parts += ["<h2>Points</h2>", table(heads, rows)]
    shown = f"{left_out}. " if left_out else ""
    parts.append(
        f"<p>{shown}Bars are numerical: how far a number is from the same model solved exactly. In "
        "brackets stands how far it may be from the most detailed model. All numbers are in "
        "study.csv and study.nc.</p>"
    )
    return write_text(folder / FILE, plain_page(f"What if: {stated.scene}", parts))


def _figure(draw: Callable[[], str]) -> list[str]:
    try:
        return [f"<figure>{draw()}</figure>"]
    except InputError as error:  # no axis is a number
        return [f"<p>No picture: {html.escape(str(error))}</p>"]


def _sliders(study: Study) -> list[str]:
    stated = study.statement
    names = [name for name in stated.quantities if QUANTITIES[name].unit != "SI"]
    data = {
        "axes": [
            {"key": a.key, "unit": a.unit, "numeric": a.numeric, "values": list(a.values)}
            for a in stated.axes
        ],
        "quantities": [
            {"name": name, "unit": QUANTITIES[name].unit, "label": heading(study, name)}
            for name in names
        ],
        "models": [
            {"model": m, "numbers": {n: _numbers(study, m, n) for n in names if gives(m, n)}}
            for m in stated.models
        ],
    }  # fmt: skip
    return [
        "<h2>Slide</h2>",
        '<div id="sliders"></div><div class="wide"><table id="answers"></table></div>',
        '<p><label>Curve of <select id="quantity"></select></label></p>',
        '<figure><svg id="curve" viewBox="0 0 900 320" role="img"></svg></figure>',
        data_script("study-data", data),
        f"<script>{_SCRIPT.read_text(encoding='utf-8')}</script>",
    ]


def _numbers(study: Study, model: str, name: str) -> dict[str, list[Any]]:
    """Values, bars and texts of a quantity at all points, null where there are none."""
    shown = column(study, model, name)
    return {
        "value": [s.value if s and math.isfinite(s.value) else None for s in shown],
        "bar": [float(f"{s.error:.3g}") if s and math.isfinite(s.error) else None for s in shown],
        "text": [s.text if s else "no value" for s in shown],
    }
