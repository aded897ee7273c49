"""The page of a study: it holds what the study says, needs nothing else, says what is in it."""

import json
import re

import numpy as np
import pytest

from tactgen.validation.engine.answers import representative
from tactgen.validation.scene.load import scene_values
from tactgen.validation.studies.whatif import output_files as text_table
from tactgen.validation.studies.whatif.aim_evaluation import parse_aims, verdicts
from tactgen.validation.studies.whatif.definition import Statement
from tactgen.validation.studies.whatif.page import write_page
from tactgen.validation.studies.whatif.study import run_study

STATIC, MODES = ("static_tip_displacement",), "short_circuit_frequencies"


def written(folder, *vary, models=("tmm",), quantities=STATIC, **more):
    """Return the study, its page, and the data that the page's sliders move over."""
    values, _ = scene_values("prototype", ["accuracy=0.1", "modes=1", "frequency=100"])
    study = run_study(Statement("prototype", values, vary, models, quantities, **more))
    page = write_page(folder, study).read_text(encoding="utf-8")
    data = re.search(r'id="study-data">(.*?)</script>', page)
    return study, page, json.loads(data[1]) if data else None


@pytest.mark.usefixtures("undrawn")
def test_the_pages_numbers_are_the_studys(tmp_path):
    """The last axis runs fastest; a quantity that a model does not give is not there."""
    study, page, data = written(
        tmp_path, "bimorph.length=14mm,16mm", "load.kind=none,finger",
        models=("tmm", "lumped"), quantities=(*STATIC, "tip_displacement"),
    )  # fmt: skip
    assert [grid["model"] for grid in data["models"]] == ["tmm", "lumped"]
    assert [of["values"] for of in data["axes"]] == [[0.014, 0.016], ["none", "finger"]]
    assert set(data["models"][1]["numbers"]) <= {*STATIC, "tip_displacement"}
    for grid in data["models"]:
        for name in grid["numbers"]:
            said = [
                np.abs(q.value).ravel()[0]
                for answers in study.answers
                for q in answers[grid["model"]].quantities if q.name == name
            ]  # fmt: skip
            np.testing.assert_allclose(grid["numbers"][name]["value"], said)
    assert not re.findall(
        r"""(?:src|href)=["'](?!#|data:)|<link|url\((?!#)|import\(|fetch\(""", page
    )


def test_a_study_over_words_has_no_picture_and_says_why(tmp_path):
    """What has no answer is headed by its name alone."""
    study, page, data = written(tmp_path, "load.kind=none,finger")
    assert data is None
    assert "<p>No picture: no axis is a number" in page
    assert text_table.heading(study, STATIC[0]) == STATIC[0]
    assert text_table.heading(study, "capacitance_free") == "capacitance_free"


def test_a_long_table_is_thinned_and_says_so(monkeypatch):
    """Evenly spaced points along each axis, every model at each; where the rest is, if known."""
    monkeypatch.setattr(text_table, "_SHOWN", 12)
    values, _ = scene_values("prototype", ["modes=1"])
    axes = ("bimorph.length=14mm:18mm:5", "bimorph.width=2mm:2.1mm:2")
    study = run_study(Statement("prototype", values, axes, ("lumped", "tmm"), STATIC))
    _, _, *lines, last = text_table.table_lines(study, "look there")
    rows = [line.split() for line in lines]
    assert [(row[0], row[2], row[4]) for row in rows] == [
        (length, width, model)
        for length in ("14", "16", "18") for width in ("2", "2.1") for model in ("lumped", "tmm")
    ]  # fmt: skip
    assert last == "6 of 10 points are shown; look there"
    monkeypatch.setattr(text_table, "_SHOWN", 20)
    assert len(text_table.table_lines(study, "look there")) == 2 + 20


def test_samples_have_no_sliders_but_a_picture(tmp_path):
    _, page, data = written(tmp_path, "bimorph.length=normal(14mm,1%)", samples=4)
    assert data is None
    assert "<svg" in page


@pytest.mark.usefixtures("undrawn")
def test_the_page_begins_with_what_the_aims_say(tmp_path):
    """Words and picture stand before the sliders."""
    study, _, _ = written(tmp_path, "bimorph.length=14mm:22mm:5", quantities=(*STATIC, MODES))
    aim = f"first({MODES}) >= 500 Hz"
    found = verdicts(study, parse_aims([aim]))
    page = write_page(tmp_path, study, found).read_text(encoding="utf-8")
    said = f"{len(found[0].met)} of 5 points meet {aim}".replace(">", "&gt;")
    assert page.index("<h2>Aims</h2>") < page.index(said) < page.index("<h2>Slide</h2>")


#: Notes a page's answers, curve and what is said of both.
NOTE = """
const cells = () => all('#answers td').map((cell) => cell.textContent);
const marks = () => all('#curve circle').map((mark) => +mark.getAttribute('cx'));
const note = (name) => {
  found[name] = { cells: cells(), marks: marks(), label: one('#curve').getAttribute('aria-label'),
    said: one('#slider-0').getAttribute('aria-valuetext') };
};
"""


def test_sliders_and_choices_change_what_is_shown(tmp_path, driven):
    """In a browser: the study's own values at each stop, one key from point to point.

    A point without a value has no mark: not that of another point that happens to have one.
    """
    study, page, data = written(
        tmp_path, "bimorph.length=16mm,14mm,15mm", "load.kind=none,finger",
        models=("tmm", "lumped"), quantities=(*STATIC, "tip_displacement"),
    )  # fmt: skip
    values = data["models"][0]["numbers"][STATIC[0]]["value"]
    without = [value if place != 3 else None for place, value in enumerate(values)]
    found = driven(
        page.replace(json.dumps(values), json.dumps(without), 1),
        NOTE
        + """note('first'); set('#slider-0', 0); note('shortest'); set('#slider-0', 2);
        note('longest'); set('#sliders select', 1, 'change'); note('finger');
        set('#slider-0', 0); note('none'); set('#slider-0', 2);
        set('#quantity', 1, 'change'); note('other');
        found.stops = +one('#slider-0').max + 1;""",
        "--disable-gpu",
    )
    assert found["stops"] == 3
    # 14 mm under the finger, by tmm
    assert [len(found[at]["marks"]) for at in ("none", "finger")] == [1, 2]
    assert found["none"]["marks"] == found["shortest"]["marks"][:1]
    said = [found[at]["said"] for at in ("shortest", "first", "longest")]
    assert said == ["14 mm", "15 mm", "16 mm"]
    # the marks of both models stand together, further right at each stop
    marks = [found[at]["marks"] for at in ("shortest", "first", "longest")]
    assert all(len(pair) == 2 and pair[0] == pair[1] for pair in marks)
    assert marks[0] < marks[1] < marks[2]
    # cells: name, tmm and lumped; points: 16, 14, 15 mm, each free and touched
    for at, point in (("longest", 0), ("shortest", 2), ("first", 4), ("finger", 1)):
        for column, model in ((1, "tmm"), (2, "lumped")):
            shown = representative(study.answers[point][model].quantities[0])
            assert found[at]["cells"][column] == shown.text
    assert found["finger"]["label"] == "static_tip_displacement over bimorph.length by tmm, lumped"
    assert found["other"]["label"] == "tip_displacement over bimorph.length by tmm, lumped"
