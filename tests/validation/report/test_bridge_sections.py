"""The report's sections on bridge, support and material, in full."""

import re

import pytest
from pages import page_text

from tactgen.geometry.bimorph import bricks as bimorph_bricks
from tactgen.validation.report.page import templates
from tactgen.validation.report.report_data import Study
from tactgen.validation.report.sections.model_differences import (
    bridge_section,
    holding_section,
    material_section,
)
from tactgen.validation.scene.scene import load_scene

SECTIONS = {"bridge": bridge_section, "holding": holding_section, "material": material_section}


def texts(scene, *overrides, quick):
    """Return the text of each section that the scene has."""
    study = Study(*load_scene(scene, overrides), lambda _: None, quick=quick)
    pages = templates()
    found = {name: made for name, make in SECTIONS.items() if (made := make(study)) is not None}
    common = {
        "scene": study.scene,
        "solution": study.solution,
        "quick": quick,
        "number": {name: at for at, name in enumerate(["models", *found], start=1)},
    }
    html = {n: pages.get_template(f"{n}.html").render(common | made) for n, made in found.items()}
    return {name: page_text(text) for name, text in html.items()}


@pytest.mark.usefixtures("own_store", "coarse_bricks")
def test_quick_report_has_the_bridge_alone(monkeypatch, few_bricks):
    """What takes tetrahedra or a dozen solids is left to the full report."""
    monkeypatch.setattr(bimorph_bricks, "LEVELS", few_bricks)
    few = ("modes=2", "frequency=1000", "quantities=static_tip_displacement")
    shown = texts("j1", "mesh.level=2", "models=tmm,solid", *few, quick=True)
    assert list(shown) == ["bridge"]
    assert "For someone who designs with the transfer-matrix model" in shown["bridge"]


def test_a_clamp_leads_nowhere_near_the_rod():
    """On the rod no bridge from a clamp is drawn, nor its causes named, whatever solid is asked."""
    scene, origins = load_scene("bimorph_on_rod", ["models=tmm,cad"])
    study = Study(scene, origins, lambda _: None, quick=True)
    assert study.steps is None
    assert study.causes is None


def test_nothing_to_lead_to():
    """Without a solid the section says so and the others are left out."""
    shown = texts("paper", "models=lumped,tmm", quick=False)
    assert list(shown) == ["bridge"]
    assert "The solid model was not asked for" in shown["bridge"]


@pytest.mark.heavy
@pytest.mark.parametrize("scene", ["paper", "bimorph_on_rod"])
def test_full_sections(scene):
    """Every number is there, both materials, the refused sets with their reason."""
    field = "cad" if scene == "bimorph_on_rod" else "solid"
    shown = texts(scene, "mesh.level=2", f"models=tmm,{field}", quick=False)
    assert list(shown) == list(SECTIONS)
    for text in shown.values():
        assert not re.search(r"\bnan\b|\bNone\b|Undefined", text)
    if scene == "paper":
        assert "PZT-5H" in shown["bridge"]
    else:
        assert "Not drawn for a bimorph in the rod" in shown["bridge"]
    assert ("slot, glue and rod" in shown["holding"]) == (scene == "bimorph_on_rod")
    assert "only d33 between" in shown["material"]
