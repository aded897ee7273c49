"""Pictures of studies: which one the axes ask for, and that it shows the study's numbers."""

import pytest

from tactgen.geometry.errors import InputError
from tactgen.validation.scene.scene import scene_values
from tactgen.validation.studies.whatif import pictures
from tactgen.validation.studies.whatif.definition import Statement
from tactgen.validation.studies.whatif.study import run_study


@pytest.fixture
def drawn(monkeypatch):
    """Return a function that draws a study and gives its figure instead of text."""
    monkeypatch.setattr(pictures, "svg", lambda figure: figure)

    def draw(*vary, models=("tmm",), quantities=("static_tip_displacement",), **more):
        values, _ = scene_values("prototype", ["frequency=100,500"])
        study = run_study(Statement("prototype", values, vary, models, quantities, **more))
        return study, pictures.study_picture(study)

    return draw


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
