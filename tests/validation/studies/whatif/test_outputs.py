"""What a study writes: pictures, statistics, its page and files that open elsewhere."""

import csv
import json
import re
from dataclasses import replace

import numpy as np
import pytest

from tactgen.validation.command_line.cli import main
from tactgen.validation.engine.answers import Answer, representative
from tactgen.validation.engine.solve import solve
from tactgen.validation.scene.load import load_scene, scene_values
from tactgen.validation.studies.whatif import output_files, pictures
from tactgen.validation.studies.whatif.aim_evaluation import parse_aims, verdicts
from tactgen.validation.studies.whatif.definition import Statement
from tactgen.validation.studies.whatif.netcdf_file import dataset
from tactgen.validation.studies.whatif.output_files import (
    sample_statistics,
    statistics_lines,
    write_statistics,
)
from tactgen.validation.studies.whatif.page import write_page
from tactgen.validation.studies.whatif.study import run_study

STATIC, MODES = "static_tip_displacement", "short_circuit_frequencies"
FAST = f"first({MODES}) >= 500 Hz"


def made(*vary, at="100,500", models=("tmm",), quantities=(STATIC,), **more):
    values, _ = scene_values("prototype", [f"frequency={at}", "modes=1"])
    return run_study(Statement("prototype", values, vary, models, quantities, **more))


@pytest.fixture
def drawn(monkeypatch):
    """Return a function that draws a study and gives its figure instead of text."""
    monkeypatch.setattr(pictures, "svg", lambda figure: figure)
    return pictures.study_picture


def test_lines_show_the_values_with_their_bars(drawn):
    """A line for each model and choice, in the order of the axis."""
    study = made("bimorph.length=16mm,14mm", "load.kind=none,finger")
    (side,) = drawn(study).axes
    free = side.containers[0]
    assert free.get_label() == "tmm none"
    np.testing.assert_allclose(free.lines[0].get_xdata(), [14.0, 16.0])
    values = [1e9 * float(study.answers[n]["tmm"].quantities[0].value) for n in (2, 0)]
    np.testing.assert_allclose(free.lines[0].get_ydata(), values)


def test_maps_are_of_two_axes_and_samples_points_over_each(drawn):
    """Of the first two, the others in their middle; points without a line."""
    figure = drawn(made("bimorph.length=14mm:16mm:3", "bimorph.width=1.5mm:2mm:2",
                        "gap=1mm,2mm,3mm", "load.kind=none,finger"))  # fmt: skip
    titles = [side.get_title() for side in figure.axes if side.get_title()]
    assert titles == ["tmm none gap = 2 mm", "tmm finger gap = 2 mm"]
    figure = drawn(made("bimorph.length=normal(20mm,2%)", "bimorph.width=1.5mm:2.1mm", samples=5))
    labels = [side.get_xlabel() for side in figure.axes]
    assert labels == ["bimorph.length (mm)", "bimorph.width (mm)"]
    assert all(side.containers[0].lines[0].get_linestyle() == "None" for side in figure.axes)


@pytest.mark.usefixtures("drawn")
@pytest.mark.parametrize(
    ("vary", "aims", "panels"),
    [
        (("bimorph.length=14mm:22mm:5",), (FAST, f"maximise {STATIC}"), 2),
        (("bimorph.length=14mm:22mm:3", "bimorph.width=1.5mm:2.1mm:3"), (FAST,), 1),
        (("load.kind=none,finger",), (f"maximise {STATIC}", f"maximise first({MODES})"), 1),
    ],
)
def test_aims_are_shown_over_axes_or_over_each_other(vary, aims, panels):
    """Every judged point is in each panel once."""
    study = made(*vary, quantities=(STATIC, MODES))
    figure = pictures.aim_picture(study, verdicts(study, parse_aims(aims)))
    assert len(figure.axes) == panels
    for side in figure.axes:
        groups = [of for of in side.containers if of.get_label() != "best"]
        assert sum(len(of.lines[0].get_xdata()) for of in groups) == len(study.points)


@pytest.fixture(scope="module")
def sampled():
    """Six draws of the width at two lengths by two models; one draw has no answer by tmm."""
    axes = ("bimorph.length=14mm,16mm", "bimorph.piezo_thickness=normal(0.26mm,2%)")
    found = made(*axes, models=("tmm", "lumped"), samples=6)
    first = {**found.answers[0], "tmm": Answer("failed", "why")}
    return replace(found, answers=(first, *found.answers[1:]))


def test_mean_deviation_and_percentiles_are_those_of_the_answers(sampled, tmp_path):
    """At each length over its own draws, printed and written; a draw without an answer is left
    out."""
    each = sample_statistics(sampled)
    found = {(one.at["bimorph.length"], one.model): one for one in each}
    assert set(found) == {(length, m) for length in (0.014, 0.016) for m in ("tmm", "lumped")}
    assert [found[0.014, m].count for m in ("tmm", "lumped")] == [5, 6]
    for (length, model), one in found.items():
        values = [
            q.value for point, m, answer in sampled.rows for q in answer.quantities
            if (point["bimorph.length"], m) == (length, model)
        ]  # fmt: skip
        assert one.mean == pytest.approx(np.mean(values), rel=1e-12)
        assert one.deviation == pytest.approx(np.std(values, ddof=1), rel=1e-9)
        assert one.percentiles == pytest.approx(np.percentile(values, [5, 50, 95]), rel=1e-12)
    assert len(statistics_lines(sampled, each)) == 2 + len(each)
    with write_statistics(tmp_path, sampled, each).open(newline="", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    assert [float(row["percentile_95"]) for row in rows] == [one.percentiles[2] for one in each]
    assert [float(row["bimorph.length (m)"]) for row in rows] == [0.014, 0.016] * 2


def test_one_draw_has_no_deviation_and_steps_have_no_statistics():
    one = made("gap=normal(0.2mm,2%)", samples=1)
    (found,) = sample_statistics(one)
    assert np.isnan(found.deviation)
    assert "-" in statistics_lines(one, [found])[-1].split()
    stepped = made("gap=0.1mm,0.2mm")
    assert sample_statistics(stepped) == statistics_lines(stepped, []) == []


def written(folder, *vary, **more):
    """Return the study, its page, and the data that the page's sliders move over."""
    study = made(*vary, at="100", **more)
    page = write_page(folder, study).read_text(encoding="utf-8")
    data = re.search(r'id="study-data">(.*?)</script>', page)
    return study, page, json.loads(data[1]) if data else None


@pytest.mark.usefixtures("undrawn")
def test_the_pages_numbers_are_the_studys(tmp_path):
    """The last axis runs fastest; a quantity that a model does not give is not there."""
    study, page, data = written(
        tmp_path, "bimorph.length=14mm,16mm", "load.kind=none,finger",
        models=("tmm", "lumped"), quantities=(STATIC, "tip_displacement"),
    )  # fmt: skip
    assert [grid["model"] for grid in data["models"]] == ["tmm", "lumped"]
    assert [of["values"] for of in data["axes"]] == [[0.014, 0.016], ["none", "finger"]]
    assert set(data["models"][1]["numbers"]) <= {STATIC, "tip_displacement"}
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


def test_words_and_samples_have_no_sliders(tmp_path):
    """Over words there is no picture, and it is said why; what has no answer is headed by its name
    alone."""
    study, page, data = written(tmp_path, "load.kind=none,finger")
    assert data is None
    assert "<p>No picture: no axis is a number" in page
    for name in (STATIC, "capacitance_free"):
        assert output_files.heading(study, name) == name
    _, page, data = written(tmp_path, "bimorph.length=normal(14mm,1%)", samples=4)
    assert data is None
    assert "<svg" in page


def test_a_long_table_is_thinned_and_says_so(monkeypatch):
    """Evenly spaced points along each axis, every model at each; where the rest is, if known."""
    monkeypatch.setattr(output_files, "_SHOWN", 12)
    axes = ("bimorph.length=14mm:18mm:5", "bimorph.width=2mm:2.1mm:2")
    study = made(*axes, models=("lumped", "tmm"))
    _, _, *lines, last = output_files.table_lines(study, "look there")
    rows = [line.split() for line in lines]
    assert [(row[0], row[2], row[4]) for row in rows] == [
        (length, width, model)
        for length in ("14", "16", "18") for width in ("2", "2.1") for model in ("lumped", "tmm")
    ]  # fmt: skip
    assert last == "6 of 10 points are shown; look there"
    monkeypatch.setattr(output_files, "_SHOWN", 20)
    assert len(output_files.table_lines(study, "look there")) == 2 + 20


@pytest.mark.usefixtures("undrawn")
def test_the_page_begins_with_what_the_aims_say(tmp_path):
    """Words and picture stand before the sliders."""
    study = made("bimorph.length=14mm:22mm:5", quantities=(STATIC, MODES))
    found = verdicts(study, parse_aims([FAST]))
    page = write_page(tmp_path, study, found).read_text(encoding="utf-8")
    said = f"{len(found[0].met)} of 5 points meet {FAST}".replace(">", "&gt;")
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
        models=("tmm", "lumped"), quantities=(STATIC, "tip_displacement"),
    )  # fmt: skip
    values = data["models"][0]["numbers"][STATIC]["value"]
    without = [value if place != 3 else None for place, value in enumerate(values)]
    before, after = (json.dumps(of, separators=(",", ":")) for of in (values, without))
    found = driven(
        page.replace(before, after, 1),
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
    assert found["other"]["label"] == "tip_displacement over bimorph.length by tmm, lumped"


@pytest.mark.usefixtures("undrawn")
def test_the_files_open_elsewhere(tmp_path, capsys):
    """netCDF by xarray with names, units, bars and provenance; CSV with the same numbers."""
    xarray = pytest.importorskip("xarray")
    assert main([
        "whatif", "prototype", "--vary", "bimorph.length=14mm:18mm:3", "--vary",
        "bimorph.bare_above=1mm,16mm", "--vary", "gap=normal(200um,10um)", "--sample", "2",
        "--model", "tmm", "--model", "network", "--quantity", "tip_displacement",
        "--quantity", MODES, "--quantity", "magnetic_force",
        "--frequency", "10,500", "--set", "modes=2", "--out", str(tmp_path),
    ]) == 0  # fmt: skip
    assert "refused" in capsys.readouterr().err
    assert sorted(p.name for p in tmp_path.iterdir()) == [
        "statistics.csv", "study.csv", "study.html", "study.json", "study.nc",
    ]  # fmt: skip
    scene, _ = load_scene(
        "prototype", ["bimorph.length=16mm", "bimorph.bare_above=1mm", "frequency=10,500"]
    )
    alone = solve(scene, ("tmm",), ("tip_displacement",)).quantities[0]
    with xarray.open_dataset(tmp_path / "study.nc") as data:
        assert data.sizes == {
            "model": 2, "bimorph.length": 3, "bimorph.bare_above": 2, "sample": 2,
            "frequency": 2, "mode": 2,
        }  # fmt: skip
        assert data["gap"].dims == ("sample",)
        assert data["bimorph.length"].attrs["units"] == "m"
        assert data.attrs["scene"] == "prototype"
        assert len(data.attrs["scene_sha256"]) == 64
        place = {"model": "tmm", "bimorph.length": 0.016, "bimorph.bare_above": 1e-3}
        at = data.sel(place).isel(sample=1)
        assert (int(at.status), at.reason.item()) == (0, "")
        refused = data.sel(model="tmm").isel({"bimorph.bare_above": 1, "bimorph.length": 0})
        assert data.status.attrs["flag_meanings"].split()[int(refused.status[0])] == "refused"
        assert np.isnan(refused.short_circuit_frequencies).all()
        assert at.short_circuit_frequencies_class.values.tolist() == ["bending_x"] * 2
        np.testing.assert_array_equal(at.tip_displacement_re, alone.value.real)
        np.testing.assert_array_equal(at.tip_displacement_im, alone.value.imag)
        np.testing.assert_array_equal(at.tip_displacement_uncertainty, alone.error)
        force = data.magnetic_force.sel(model="network").values.ravel()
    with (tmp_path / "study.csv").open(newline="", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    assert list(rows[0])[:3] == ["bimorph.length (m)", "bimorph.bare_above (m)", "gap (m)"]
    assert {r["class"] for r in rows if r["quantity"] == MODES and r["value"]} == {"bending_x"}
    mine = [float(r["value"]) for r in rows if r["quantity"] == "magnetic_force" and r["value"]]
    assert mine == force[np.isfinite(force)].tolist()
    response = next(
        r for r in rows if r["quantity"] == "tip_displacement" and r["status"] == "ok"
        and float(r["bimorph.length (m)"]) == 0.016
    )  # fmt: skip
    assert float(response["frequency"]) == 10.0
    assert complex(float(response["value"]), float(response["value_im"])) == alone.value[0]
    missing = next(r for r in rows if r["status"] == "refused")
    assert (missing["value"], missing["uncertainty"]) == ("", "")
    assert "bimorph.bare_above" in missing["reason"]


def test_a_study_over_frequency_is_a_sweep():
    """Frequency is an axis of the arrays then, once; what nothing answers is no array."""
    study = made("frequency=100,500", "load.kind=none,table", quantities=("tip_displacement",))
    found = dataset(study).variables["tip_displacement"]
    assert found.dims == ("model", "frequency", "load.kind")
    scene, _ = load_scene("prototype", ["frequency=100,500", "load.kind=none"])
    sweep = solve(scene, ("tmm",), ("tip_displacement",)).quantities[0].value
    np.testing.assert_array_equal(found.values[0, :, 0], sweep)
    assert np.isnan(found.values[0, :, 1]).all()
    unanswered = tuple({"tmm": Answer("refused", "why")} for _ in study.answers)
    nothing = dataset(replace(study, answers=unanswered))
    assert set(nothing.data_vars) == {"status", "reason", "seconds"}
