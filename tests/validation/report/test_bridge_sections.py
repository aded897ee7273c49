"""The report's section on the differences between beam and solid."""

import re

import pytest
from pages import page_text

from tactgen.geometry.bimorph import bricks as bimorph_bricks
from tactgen.validation.engine.solve import solve
from tactgen.validation.report.page import templates
from tactgen.validation.report.report_data import Study
from tactgen.validation.report.sections.bimorph import bridge_section
from tactgen.validation.scene.load import load_scene


def text(scene, *overrides):
    study = Study(*load_scene(scene, overrides), lambda _: None, quick=True)
    common = {"scene": study.scene, "solution": study.solution, "quick": True}
    return page_text(templates().get_template("bridge.html").render(common | bridge_section(study)))


@pytest.mark.usefixtures("own_store", "coarse_bricks")
def test_steps_are_those_of_the_scenes_wiring(monkeypatch, few_bricks):
    """In series the terminals see a quarter of the capacitance."""
    monkeypatch.setattr(bimorph_bricks, "LEVELS", few_bricks)
    few = ("modes=2", "frequency=1000", "quantities=static_tip_displacement")
    shown = text("j1", "mesh.level=2", "models=tmm,solid", *few, "bimorph.wiring=series")
    assert "Compared with the solid, the transfer matrix gives" in shown
    assert not re.search(r"\bnan\b|\bNone\b|Undefined", shown)
    scene, _ = load_scene("j1", ["models=tmm"])
    number = float(re.search(r"TMM.*?([\d.]+) nF", shown)[1])
    parallel = float(solve(scene, ["tmm"], ["capacitance_free"]).quantities[0].value)
    assert 4.0 * number == pytest.approx(parallel * 1e9, rel=1e-4)


def test_a_clamp_leads_nowhere_near_the_rod():
    """On the rod no bridge from a clamp is drawn, whatever solid is asked."""
    scene, origins = load_scene("bimorph_on_rod", ["models=tmm,cad"])
    study = Study(scene, origins, lambda _: None, quick=True)
    assert study.steps is None
    assert "Not available for a bimorph in the rod" in page_text(
        templates()
        .get_template("bridge.html")
        .render(scene=scene, solution=None, quick=True, bridge=bridge_section(study)["bridge"])
    )


def test_without_a_solid_the_section_is_left_out():
    study = Study(*load_scene("paper", ["models=lumped,tmm"]), lambda _: None, quick=False)
    assert bridge_section(study) is None
