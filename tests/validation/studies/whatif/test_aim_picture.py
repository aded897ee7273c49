"""The picture of a study's aims: which one the axes and goals ask for, and that it is right."""

import numpy as np
import pytest
from approved import figure_text

from tactgen.validation.scene.scene import scene_values
from tactgen.validation.studies.whatif.aim.best import parse_aims, verdict
from tactgen.validation.studies.whatif.asked.statement import Statement
from tactgen.validation.studies.whatif.run import run_study
from tactgen.validation.studies.whatif.shown import aim_picture
from tactgen.validation.studies.whatif.shown.page import write_page

LENGTH, WIDTH = "bimorph.length=14mm:22mm:5", "bimorph.width=1.5mm:2.1mm:3"
QUANTITIES = ("static_tip_displacement", "short_circuit_frequencies")
FAST = "first(short_circuit_frequencies) >= 500 Hz"
FASTEST = "maximise first(short_circuit_frequencies)"
FARTHEST = "maximise abs(static_tip_displacement)"


def asked(vary, *aims, **more):
    """Return a study by transfer matrices and what the aims say of it."""
    values, _ = scene_values("prototype", ["modes=1"])
    study = run_study(Statement("prototype", values, vary, ("tmm",), QUANTITIES, **more))
    return study, verdict(study, parse_aims(aims))


@pytest.fixture
def drawn(monkeypatch):
    """Return a function that draws what aims say and gives the figure in place of text."""
    monkeypatch.setattr(aim_picture, "svg", lambda figure: figure)

    def draw(vary, *aims, **more):
        study, found = asked(vary, *aims, **more)
        return study, found, aim_picture.aim_picture(study, found)

    return draw


def legend(side):
    return [text.get_text() for text in side.get_legend().get_texts()]


def test_over_one_axis_margins_are_seen_to_cross_zero(drawn, approved):
    """What is met lies above the line, in the colour of its legend, at the axis' values."""
    study, found, figure = drawn((LENGTH,), FAST)
    (side,) = figure.axes
    met, missed = side.containers
    assert legend(side) == ["met", "not met"]
    x, y = met.lines[0].get_data()
    np.testing.assert_allclose(
        x, [1e3 * study.points[j.number]["bimorph.length"] for j in found.met]
    )
    np.testing.assert_allclose(y, [j.margins[0][0] for j in found.met], rtol=1e-12)
    assert y.min() >= 0.0 > missed.lines[0].get_ydata().max()
    assert side.get_title() == FAST
    assert side.get_ylabel() == "margin (Hz)"
    approved(figure_text(figure))


def test_two_axes_are_a_plane_with_the_best_ringed(drawn, approved):
    """Every point of the grid is there once; the ring is around the best of those that meet."""
    study, found, figure = drawn((LENGTH, WIDTH), FAST, FARTHEST)
    (side,) = figure.axes
    met, missed, ring = (np.asarray(part.get_offsets()) for part in side.collections)
    assert len(met) + len(missed) == len(study.points)
    assert len(met) == len(found.met)
    best = study.points[found.best[0].number]
    np.testing.assert_allclose(ring, [[1e3 * best["bimorph.length"], 1e3 * best["bimorph.width"]]])
    assert legend(side) == ["met", "not met", "best"]
    approved(figure_text(figure))


def test_two_goals_are_a_front(drawn, approved):
    """One over the other; the line joins what is not bettered in both, and only that."""
    _, found, figure = drawn((LENGTH, WIDTH), FASTEST, FARTHEST)
    (side,) = figure.axes
    front = next(line for line in side.lines if line.get_label() == "not bettered in both")
    assert len(front.get_xdata()) == len(found.best)
    np.testing.assert_allclose(front.get_xdata(), [j.margins[0][0] for j in found.best], rtol=1e-12)
    assert np.all(np.diff(front.get_xdata()) < 0.0)
    assert np.all(np.diff(front.get_ydata()) > 0.0)
    assert "point" in legend(side)
    assert side.get_xlabel() == f"{FASTEST}: value (Hz)"
    approved(figure_text(figure))


def test_of_more_axes_margins_are_counted(drawn, approved):
    """All points are in the bars, at their margins."""
    spread = "support.rotational_stiffness=0.1N*m/rad:0.4N*m/rad:2"
    study, _, figure = drawn((LENGTH, WIDTH, spread), FAST)
    (side,) = figure.axes
    assert sum(bar.get_height() for bar in side.patches) == len(study.points)
    approved(figure_text(figure))


def test_the_page_begins_with_what_the_aims_say(tmp_path):
    """Words and picture stand before the sliders; without aims there is neither."""
    study, found = asked((LENGTH,), FAST)
    page = write_page(tmp_path, study, found).read_text(encoding="utf-8")
    said = f"{len(found.met)} of 5 points meet {FAST}".replace(">", "&gt;")
    assert page.index("<h2>Aims</h2>") < page.index(said) < page.index("<h2>Slide</h2>")
    assert "<h2>Aims</h2>" not in write_page(tmp_path, study).read_text(encoding="utf-8")
