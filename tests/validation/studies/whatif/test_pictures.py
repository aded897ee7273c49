"""Pictures of studies: which one the axes ask for, and that it shows the study's numbers."""

import numpy as np
import pytest
from approved import figure_text

from tactgen.geometry.errors import InputError
from tactgen.validation.scene.scene import scene_values
from tactgen.validation.studies.whatif.asked.statement import Statement
from tactgen.validation.studies.whatif.run import run_study
from tactgen.validation.studies.whatif.shown import pictures


@pytest.fixture
def drawn(monkeypatch):
    """Return a function that draws a study and gives its figure instead of text."""
    monkeypatch.setattr(pictures, "svg", lambda figure: figure)

    def draw(*vary, models=("tmm",), quantities=("static_tip_displacement",), **more):
        values, _ = scene_values("prototype", ["frequency=100,500"])
        study = run_study(Statement("prototype", values, vary, models, quantities, **more))
        return study, pictures.study_picture(study)

    return draw


def test_one_axis_is_lines_with_bars(drawn, approved):
    """A line a model and choice, in the units of the labels, a panel a quantity."""
    study, figure = drawn(
        "bimorph.length=14mm:22mm:3", "load.kind=none,finger", models=("tmm", "lumped"),
        quantities=("static_tip_displacement", "tip_displacement"),
    )  # fmt: skip
    static, response = figure.axes
    assert "µm" in static.get_ylabel() or "nm" in static.get_ylabel()
    assert "(mm)" in response.get_xlabel()
    labels = [text.get_text() for text in static.get_legend().get_texts()]
    assert labels == ["tmm none", "tmm finger", "lumped none", "lumped finger"]
    line = static.containers[0].lines[0]
    np.testing.assert_allclose(line.get_xdata(), [14.0, 18.0, 22.0])
    q = study.answers[0]["tmm"].quantities[0]
    factor = 1e9 if "nm" in static.get_ylabel() else 1e6
    np.testing.assert_allclose(line.get_ydata()[0], factor * q.value, rtol=1e-12)
    approved(figure_text(figure))


def test_two_axes_are_contours_and_more_a_tornado(drawn, approved):
    length, width = "bimorph.length=14mm:22mm:3", "bimorph.width=1.5mm:2.1mm:3"
    _, figure = drawn(length, width)
    assert [axis.get_xlabel() for axis in figure.axes[:1]] == ["bimorph.length (mm)"]
    assert figure.axes[0].collections
    approved(figure_text(figure), "contours")
    _, figure = drawn(length, width, "support.rotational_stiffness=0.1N*m/rad:0.4N*m/rad:3")
    (side,) = figure.axes
    assert "bimorph.length  14 mm to 22 mm" in side.get_yticklabels()[-1].get_text()
    assert len(side.patches) == 6
    approved(figure_text(figure), "tornado")


def test_swings_are_at_the_ends_with_the_others_in_the_middle():
    table = {(a, b): a + 10.0 * b for a in (1, 2, 4) for b in (0, 5, 6)}
    assert pictures.swings([(1, 2, 4), (0, 5, 6)], table) == [(51.0, 54.0), (2.0, 62.0)]


def test_samples_are_scatter_or_parallel_coordinates(drawn):
    _, figure = drawn("bimorph.length=normal(20mm,2%)", "bimorph.width=1.5mm:2.1mm", samples=5)
    assert len(figure.axes) == 2
    keys = ("bimorph.length", "bimorph.width", "bimorph.piezo_thickness", "bimorph.shim_thickness")
    sizes = ("20mm", "2.1mm", "0.26mm", "0.2mm")
    vary = [f"{key}=normal({size},1%)" for key, size in zip(keys, sizes, strict=True)]
    _, figure = drawn(*vary, "piezo.density=normal(7900kg/m^3,1%)", samples=5)
    (side,) = figure.axes
    assert len(side.lines) == 5
    assert len(side.get_xticks()) == 6


def test_what_cannot_be_drawn_is_refused(drawn):
    with pytest.raises(InputError, match="no axis is a number"):
        drawn("load.kind=none,finger")
