"""The report's section about the display: all parts, numbers by their models, no number that is
none; and its page and still."""

import re

import numpy as np
import pytest

from tactgen.validation.report.page import templates
from tactgen.validation.report.report_data import Study
from tactgen.validation.report.sections.contents import sections
from tactgen.validation.report.sections.display import _numbers, display_section
from tactgen.validation.scene.load import load_scene
from tactgen.validation.show.display import swing, travelling_wave
from tactgen.validation.show.view import Look, view

SMALL = ("models=tmm,network", "frequency=10,100,439", "display.rows=1", "display.columns=2")


@pytest.fixture(scope="module")
def study():
    scene, origins = load_scene("display", SMALL)
    return Study(scene, origins, lambda _: None, quick=True)


@pytest.mark.heavy
def test_the_section_in_words(study):
    """Parts, gaps, leads, neighbours and units, in one section before the checks."""
    ids = [section.id for section in sections(study)]
    assert ids.index("display") == ids.index("checks") - 1
    shown = display_section(study)
    html = templates().get_template("display.html").render(scene=study.scene, **shown)
    text = re.sub(r"\s+", " ", re.sub(r"<svg.*?</svg>|<[^>]+>", " ", html, flags=re.DOTALL))
    for wanted in (
        "1 by 2 generators", "grub screw", "No two parts overlap", "All leads have room",
        "magnetic crosstalk", "tuning range", "r1c2", "seed 1",
    ):  # fmt: skip
        assert wanted in text, wanted
    assert "nan" not in text


def test_a_number_that_no_model_knows_has_no_row(study):
    """The network knows nothing of an undriven neighbour's pull, the others are its."""
    asked = [q for q in study.solution.quantities if q.name.startswith(("pull_", "passive"))]
    assert [row.label for row, _ in _numbers(asked)] == [
        "pull all driven", "pull alternating", "pull one driven",
    ]  # fmt: skip
    assert any(np.isnan(q.value) for q in asked)


def test_the_study_of_a_display_leaves_the_normal_actuators_sections_out(study):
    """The network is asked about neighbours only; what it says of them is there."""
    assert study.normal is None
    assert study.lateral
    assert study.solution.get("magnetic_crosstalk", "network").value > 0.0


def test_a_wave_runs_along_the_display():
    """Of two units, alike and opposite each other: what each drive does, added with its phase."""
    scene, _ = load_scene("display", SMALL)
    frequency, tips = travelling_wave(scene)
    own, passed = swing(scene).tips[scene.frequency.index(frequency)]
    expected = [own - 1j * passed, passed - 1j * own]
    assert tips == pytest.approx(np.array(expected), rel=1e-6)


@pytest.mark.heavy
def test_the_display_moves_in_a_film(tmp_path):
    """A period of 24 pictures; they differ where the tips are, and the words say how much."""
    from PIL import Image

    scene, _ = load_scene("display", SMALL)
    film = tmp_path / "d.gif"
    view(scene, Look(), {"gif": film}, lambda _: None)
    with Image.open(film) as opened:
        assert opened.n_frames == 24
        pictures = []
        for k in (0, 12):
            opened.seek(k)
            pictures.append(np.asarray(opened.convert("RGB"), dtype=int))
    assert (np.abs(pictures[0] - pictures[1]).max(axis=2) > 60).sum() > 200
