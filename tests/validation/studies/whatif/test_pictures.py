"""Pictures of studies: which one the axes ask for, and that it shows the study's numbers."""

from dataclasses import replace

import numpy as np
import pytest

from tactgen.validation.scene.load import scene_values
from tactgen.validation.studies.whatif import pictures
from tactgen.validation.studies.whatif.aim_evaluation import parse_aims, verdicts
from tactgen.validation.studies.whatif.definition import Statement
from tactgen.validation.studies.whatif.study import run_study

STATIC = ("static_tip_displacement",)
FIRST = "first(short_circuit_frequencies)"
FAST = f"{FIRST} >= 500 Hz"


@pytest.fixture
def drawn(monkeypatch):
    """Return a function that draws a study and gives its figure instead of text."""
    monkeypatch.setattr(pictures, "svg", lambda figure: figure)

    def draw(*vary, models=("tmm",), quantities=STATIC, **more):
        values, _ = scene_values("prototype", ["frequency=100,500", "modes=1"])
        study = run_study(Statement("prototype", values, vary, models, quantities, **more))
        return study, pictures.study_picture(study)

    return draw


def test_lines_show_the_values_with_their_bars(drawn):
    """A line for each model and choice, in the order of the axis."""
    study, figure = drawn("bimorph.length=16mm,14mm", "load.kind=none,finger")
    (side,) = figure.axes
    free = side.containers[0]
    assert free.get_label() == "tmm none"
    np.testing.assert_allclose(free.lines[0].get_xdata(), [14.0, 16.0])
    values = [1e9 * float(study.answers[n]["tmm"].quantities[0].value) for n in (2, 0)]
    np.testing.assert_allclose(free.lines[0].get_ydata(), values)


def test_maps_are_of_the_first_two_axes_with_others_in_their_middle(drawn):
    _, figure = drawn("bimorph.length=14mm:16mm:3", "bimorph.width=1.5mm:2mm:2", "gap=1mm,2mm,3mm",
                      "load.kind=none,finger")  # fmt: skip
    titles = [side.get_title() for side in figure.axes if side.get_title()]
    assert titles == ["tmm none gap = 2 mm", "tmm finger gap = 2 mm"]


def test_samples_are_points_over_each_drawn_axis(drawn):
    _, figure = drawn("bimorph.length=normal(20mm,2%)", "bimorph.width=1.5mm:2.1mm", samples=5)
    assert [side.get_xlabel() for side in figure.axes] == [
        "bimorph.length (mm)",
        "bimorph.width (mm)",
    ]
    assert all(side.containers[0].lines[0].get_linestyle() == "None" for side in figure.axes)


@pytest.mark.parametrize(
    ("vary", "aims", "panels"),
    [
        (("bimorph.length=14mm:22mm:5",), (FAST, "maximise static_tip_displacement"), 2),
        (("bimorph.length=14mm:22mm:3", "bimorph.width=1.5mm:2.1mm:3"), (FAST,), 1),
        (("load.kind=none,finger",), ("maximise static_tip_displacement", f"maximise {FIRST}"), 1),
    ],
)
def test_aims_are_shown_over_axes_or_over_each_other(drawn, vary, aims, panels):
    """Every judged point is in each panel once."""
    study, _ = drawn("bimorph.length=14mm,15mm")
    study = run_study(
        replace(study.statement, vary=vary, quantities=(*STATIC, "short_circuit_frequencies"))
    )
    figure = pictures.aim_picture(study, verdicts(study, parse_aims(aims)))
    assert len(figure.axes) == panels
    for side in figure.axes:
        groups = [of for of in side.containers if of.get_label() != "best"]
        assert sum(len(of.lines[0].get_xdata()) for of in groups) == len(study.points)


def test_each_model_has_a_panel_with_its_own_verdict(drawn):
    """A limit between the first frequencies of two models: one panel is met, one is not."""
    study, _ = drawn("bimorph.length=14mm,15mm")
    study = run_study(replace(
        study.statement, vary=("bimorph.length=14mm,14.001mm", "bimorph.width=2.0999mm,2.1mm"),
        models=("tmm", "lumped"), quantities=("short_circuit_frequencies",),
    ))  # fmt: skip
    first = {m: [at[m].quantities[0].value[0] for at in study.answers] for m in ("tmm", "lumped")}
    assert max(first["tmm"]) < min(first["lumped"])
    limit = 0.5 * (max(first["tmm"]) + min(first["lumped"]))
    found = verdicts(study, parse_aims([f"{FIRST} >= {limit} Hz"]))
    figure = pictures.aim_picture(study, found)
    groups = {side.get_title(): [of.get_label() for of in side.containers] for side in figure.axes}
    assert groups == {"by tmm": ["not met"], "by lumped": ["met", "best"]}
