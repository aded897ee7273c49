"""The report's story of the machine: its sections' order, numbers beside the paper's, limits."""

import re

import numpy as np
import pytest
from pages import page_text

from tactgen.geometry.errors import InputError
from tactgen.validation.engine.solve import solve
from tactgen.validation.models.backbone import STATES, rocking_states
from tactgen.validation.report.page import templates
from tactgen.validation.report.report_data import Study
from tactgen.validation.report.request import check_report
from tactgen.validation.report.sections import large_motion
from tactgen.validation.report.sections.contents import sections
from tactgen.validation.report.sections.generator import MOTIONS, POSITIONS, SUPPORT, _maps_asked
from tactgen.validation.scene.load import load_scene

FEW = ("models=tmm,network", "frequency=10,100,439,1000")
ALONE = "quantities=static_tip_displacement"
RESTING = ["rod_position", "finger_force", "contact_force"]


def study(name="generator", *overrides, quick=True):
    scene, origins = load_scene(name, [*FEW, *overrides])
    return Study(scene, origins, lambda _: None, quick=quick)


@pytest.mark.parametrize(
    ("models", "compared"), [("tmm,network", False), ("tmm,axisymmetric,network", True)]
)
def test_maps_are_compared_where_two_are_asked_for(models, compared):
    """Models of the normal actuator alone; one is compared with nothing."""
    asked = _maps_asked(load_scene("generator", [f"models={models}"])[0])
    assert sorted(asked) == (["axisymmetric", "network"] if compared else [])


@pytest.fixture(scope="module")
def up(tmp_path_factory, rough_fields):
    """The scene as it is built in, with few of its quantities and rough fields."""
    few = np.linspace(0.0, 0.2, 7), np.geomspace(20e-6, 0.25e-3, 6)
    with rough_fields(tmp_path_factory.mktemp("rough")) as patch:
        patch.setattr("tactgen.tmm.reluctance.map_range.map_grid", lambda *_, **__: few)
        yield study("generator", ",".join([ALONE, *RESTING]), "frequency=439")


def test_the_story_in_order(up):
    """The machine's own sections, then those of its bimorph."""
    ids = [section.id for section in sections(up)]
    assert ids[:5] == ["positions", "support", "motions", "amplitude", "time"]
    assert ids[5:7] == ["models", "modes"]
    assert "magnetic_models" not in ids
    assert len(ids) == len(set(ids))


def test_without_current_the_normal_actuator_is_shown_at_the_papers(up):
    """Its own sections at 130 mA; where the rod rests at the scene's 0 mA."""
    assert up.scene.coil.current == 0.0
    assert up.normal.current == pytest.approx(0.130)
    names = [row.quantity for row in up.normal.comparison]
    assert "magnetic_force" in names
    assert "rod_position" not in names
    assert [row.quantity for row in up.resting] == RESTING
    assert up.resting[1].cells[0].value == pytest.approx(0.110, rel=1e-3)


def test_an_actuator_alone_without_current_is_refused_at_once():
    """Nothing moves and nothing pulls: there is nothing to report."""
    scene, _ = load_scene("reluctance", ["coil.current=0mA", "models=network"])
    with pytest.raises(InputError, match=r"coil\.current = 0 mA leaves nothing"):
        check_report(scene, quick=True)


def test_the_moment_is_held_against_what_the_contact_bears():
    """50 V: far beyond; a tenth of a volt: pressed all round."""
    moment, quiet = (
        SUPPORT.context(study("generator", ALONE, "frequency=439", *changes))["moment"]
        for changes in (("coil.current=50mA", "coil.history=falling"), ("drive.voltage=0.1V",))
    )
    assert moment.largest > moment.tipping == pytest.approx(2.0 * moment.uplift)
    assert quiet.largest < quiet.uplift


def test_a_quick_report_says_what_it_leaves_out(up):
    """Large amplitudes take long; the command that gives them is named."""
    template, shown = templates().get_template("amplitude.html"), large_motion.AMPLITUDE.context(up)
    text = page_text(template.render(scene=up.scene, quick=True, number={"support": 3}, **shown))
    assert not re.search(r"\bnan\b|\bNone\b|Undefined|\binf\b", text)
    assert "Not in the quick version" in text
    assert "tactgen backbone" in text


@pytest.mark.parametrize("tilted", [False, True])
def test_rod_and_coil_in_small_motions_are_told(up, tilted):
    """An upright head, whose motions do not meet, and one that its spring tilts."""
    aside = up.scene.spring.model_copy(update={"eccentricity": 0.2e-3 if tilted else 0.0})
    of = Study(up.scene.model_copy(update={"spring": aside}), {}, lambda _: None, quick=True)
    template, shown = templates().get_template("motions.html"), MOTIONS.context(of)
    text = page_text(template.render(scene=of.scene, **shown))
    assert not re.search(r"\bnan\b|\bNone\b|Undefined|\binf\b", text)
    assert ("The head is upright" in text) is not tilted


@pytest.fixture(scope="module")
def narrow():
    """A scene whose curves cost little: a narrow band far below the peak, and its states."""
    of = study("generator", "frequency=60,80", quick=False)
    free = of.scene.model_copy(update={"load": of.scene.load.model_copy(update={"kind": "none"})})
    return of, rocking_states(free, (0.1,))


def test_both_states_are_those_of_the_paper(narrow):
    """Pressed by the spring on the upper stop, by the pull of 50 mA on the lower; kept."""
    _, found = narrow
    assert [state.state for state in found] == ["not activated", "held"]
    assert found[0].contact_force == pytest.approx(0.110, rel=1e-3)
    assert found[1].contact_force > 0.3
    assert not any(state.refused for state in found)
    for state in found:
        (curve,) = state.curves
        asked = ["load.kind=none", "drive.voltage=0.1V", "frequency=60", *STATES[state.state]]
        scene, _ = load_scene("generator", asked)
        expected = solve(scene, ("tmm",), ("tip_displacement",)).quantities[0].value[0]
        assert abs(curve.displacement[0]) == pytest.approx(abs(expected), rel=1e-3)


def test_a_bimorph_on_other_supports_has_no_such_sections():
    """Nothing magnetic is shown, or computed, for the paper's springs."""
    machine = {"positions", "support", "motions", "amplitude", "time"}
    few = "models=tmm", "frequency=100", ALONE
    paper = study("paper", *few)
    assert not machine & {section.id for section in sections(paper)}
    alone = study("paper", *few, "support.kind=contact", "coil.current=0mA")
    assert machine <= {section.id for section in sections(alone)}
    assert POSITIONS.context(alone) is None
    assert MOTIONS.context(alone) is None
    assert len(SUPPORT.context(alone)["rows"]) == 3
