"""The report's sections on bridge, support and material, in full."""

import pickle
import re

import pytest
from pages import page_text

from tactgen.fem.piezo.solid import assemble
from tactgen.validation.engine.solve import solve
from tactgen.validation.models.bimorph.bridge import solid_values
from tactgen.validation.report.page import templates
from tactgen.validation.report.sections import bridge
from tactgen.validation.report.sections.bridge import (
    bridge_section,
    holding_section,
    material_section,
)
from tactgen.validation.report.study import Study
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
    monkeypatch.setattr(solid_values, "LEVELS", few_bricks)
    few = ("modes=2", "frequency=1000", "quantities=static_tip_displacement")
    shown = texts("j1", "mesh.level=2", "models=tmm,solid", *few, quick=True)
    assert list(shown) == ["bridge"]
    assert "For someone who designs with the transfer-matrix model" in shown["bridge"]


def test_every_response_and_mode_has_its_row_of_steps(monkeypatch, few_bricks):
    """As the full report shows them, made by another process: what has no value has no line."""
    assembled = []

    def counted(*args, lossy, **more):
        assembled.append(lossy)
        return assemble(*args, lossy=lossy, **more)

    monkeypatch.setattr(solid_values, "LEVELS", few_bricks)
    monkeypatch.setattr(solid_values, "assemble", counted)
    few = ("modes=2", "models=tmm,solid", "quantities=tip_displacement", "load.kind=none")
    scene, origins = load_scene("paper", [*few, "frequency=5Hz,1000Hz"])
    study = Study(scene, origins, lambda _: None, quick=False)
    found = pickle.loads(pickle.dumps(bridge._stepped(study)))
    rows = {row["names"][0]: row for row in found["rows"]}
    assert rows["tip displacement"]["names"] == ["tip displacement", "tip velocity"]
    assert rows["input current"]["names"] == ["input current", "admittance"]
    assert "dynamic stiffness" not in rows
    # a free tip gives no power, and of 5 Hz the threshold is not known
    assert "load power" not in rows
    assert len(rows["blocked force"]["lines"]) == bridge._FREQUENCIES
    assert len(rows["threshold voltage"]["lines"]) == bridge._FREQUENCIES - 1
    own = solve(scene, ("tmm",), ("short_circuit_frequencies",)).quantities[0].value
    assert [at * (1.0 + together) for at, _, together in rows["short circuit frequencies"]["lines"]
            ] == pytest.approx(own, rel=1e-9)  # fmt: skip
    for row in rows.values():
        for _, shares, together in row["lines"]:
            assert len(shares) == len(found["steps"])
            assert sum(shares) == pytest.approx(together, abs=1e-12)
    part = templates().get_template("bridge.html")
    shown = page_text(part.render(
        bridge=[{"material": "any", "rungs": study.rungs, "plot": "", "ends": None}],
        stepped=found, scene=study.scene, quick=True, number={"models": 1}, widths=[],
    ))  # fmt: skip
    # steps of one number and of many are told of one lossless system each; sections ask others
    solids = len(found["steps"]) - 1
    assert (assembled.count(True), assembled.count(False)) == (solids, 2 * solids)
    assert "tip displacement, tip velocity" in shown
    assert not re.search(r"\bnan\b|\binf\b", shown)


def test_a_clamp_leads_nowhere_near_the_rod():
    """On the rod no bridge from a clamp is drawn, nor its causes named, whatever solid is asked."""
    scene, origins = load_scene("bimorph_on_rod", ["models=tmm,solid"])
    study = Study(scene, origins, lambda _: None, quick=True)
    assert study.rungs is None
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
        assert "unexplained" in shown["bridge"]
    else:
        assert "Not drawn for a bimorph in the rod" in shown["bridge"]
    assert "elastic rod" in shown["holding"]
    assert "only d33 between" in shown["material"]
