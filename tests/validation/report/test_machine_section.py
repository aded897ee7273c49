"""The report's story of the machine: its sections' order, numbers beside the paper's, limits."""

import json
import re
from dataclasses import replace

import numpy as np
import pytest
from approved import in_text, page_text

from tactgen.geometry.errors import InputError
from tactgen.validation.engine.solve import solve
from tactgen.validation.models.amplitude.deflection import LoadedDeflection
from tactgen.validation.models.amplitude.held_head import STATES
from tactgen.validation.models.amplitude.states import rocking_states
from tactgen.validation.report.page import summary, templates
from tactgen.validation.report.request import check_report
from tactgen.validation.report.sections import large_motion
from tactgen.validation.report.sections.contents import sections
from tactgen.validation.report.sections.machine import MOTIONS, POSITIONS, SUPPORT, _maps_asked
from tactgen.validation.report.study import Study
from tactgen.validation.scene.scene import load_scene
from tactgen.validation.studies.uncertainty import propagation

FEW = ("models=tmm,network", "frequency=10,100,439,1000")
NUMBER = {"support": 3}


def study(name="generator", *overrides, quick=True):
    scene, origins = load_scene(name, [*FEW, *overrides])
    return Study(scene, origins, lambda _: None, quick=quick)


def page(section, of, shown):
    template = templates().get_template(f"{section.id}.html")
    return template.render(scene=of.scene, quick=of.quick, number=NUMBER, **shown)


def words(section, of, shown):
    """What a section says."""
    html = page(section, of, shown)
    text = re.sub(r"\s+", " ", re.sub(r"<svg.*?</svg>|<[^>]+>", " ", html, flags=re.DOTALL))
    assert not re.search(r"\bnan\b|\bNone\b|Undefined|\binf\b", text)
    return text


@pytest.mark.parametrize(
    ("models", "compared"),
    [("tmm,network", []), ("tmm,beam", []), ("tmm,axisymmetric,network", True)],
)
def test_maps_are_compared_where_two_are_asked_for(models, compared):
    """Models of the normal actuator alone; one is compared with nothing."""
    asked = _maps_asked(load_scene("generator", [f"models={models}"])[0])
    assert sorted(asked) == (["axisymmetric", "network"] if compared else [])


@pytest.fixture(scope="module")
def up():
    """The scene as it is built in."""
    return study()


@pytest.fixture(scope="module")
def held():
    """The scene held down by 50 mA."""
    return study("generator", "coil.current=50mA", "coil.history=falling")


@pytest.fixture(scope="module")
def support_held(held):
    """What the section on the support shows of it, with its figures in words."""
    with pytest.MonkeyPatch.context() as patch:
        in_text(patch)
        return SUPPORT.context(held)


def test_the_story_in_order(up):
    """Device, positions, support, response, amplitude, time, limits; then what backs it."""
    ids = [section.id for section in sections(up)]
    assert ids[:8] == [
        "what", "positions", "support", "response", "motions", "amplitude", "time", "drive_limits",
    ]  # fmt: skip
    assert ids[8:10] == ["models", "modes"]
    assert not {"length", "voltage", "holding", "audit"} & set(ids)
    assert len(ids) == len(set(ids))


def test_without_current_the_normal_actuator_is_shown_at_the_papers(up):
    """Its own sections at 130 mA; where the rod rests at the scene's 0 mA."""
    assert up.scene.coil.current == 0.0
    assert up.normal.current == pytest.approx(0.130)
    names = [row.quantity for row in up.normal.comparison]
    assert "magnetic_force" in names
    assert "rod_position" not in names
    assert [row.quantity for row in up.resting] == ["rod_position", "finger_force", "contact_force"]
    assert up.resting[1].cells[0].value == pytest.approx(0.110, rel=1e-3)
    ran = [step.stage for step in up.plan.run]
    assert {"tmm.ports", "network.point", "network.rest"} <= set(ran)
    assert not {skip.stage for skip in up.plan.skipped} & set(ran)


def test_an_actuator_alone_without_current_is_refused_at_once():
    """Nothing moves and nothing pulls: there is nothing to report."""
    scene, _ = load_scene("reluctance", ["coil.current=0mA", "models=network"])
    with pytest.raises(InputError, match=r"coil\.current = 0 mA leaves nothing"):
        check_report(scene, quick=True)


@pytest.mark.usefixtures("undrawn")
def test_positions_over_the_current(up, approved):
    """The loop of the model that is asked for, with both switching currents; all places."""
    shown = POSITIONS.context(up)
    (loop,) = shown["loops"]
    assert loop.model == "network"
    assert loop.loop.currents[-1] > loop.switching.pull_in.value
    assert [current for current, _ in shown["places"]] == [0.0, 0.05]
    kinds = [[place.kind for place in found] for _, found in shown["places"]]
    assert kinds == [["upper stop"], ["upper stop", "unstable", "lower stop"]]
    assert "pull-in" in shown["loop"]
    text = words(POSITIONS, up, shown)
    assert "The scene's current is 0" in text
    assert "all places at 50 mA" in text
    approved(page_text(page(POSITIONS, up, shown)))


def test_rows_are_the_scenes_own_support(held, support_held, approved):
    """The state of the scene is that which its quantities were computed with."""
    shown = support_held
    springs = held.scene.held
    row = next(r for r in shown["rows"] if r.state == "50 mA, falling")
    assert row.rotational_stiffness == springs.rotational_stiffness
    assert row.first_frequency == held.solution.get("short_circuit_frequencies", "tmm").value[0]
    assert row.place.kind == "lower stop"
    alone = next(r for r in shown["rows"] if "110 mN" in r.state)
    assert alone.rotational_stiffness == pytest.approx(0.24, abs=0.005)
    assert [r.first_frequency for r in shown["rows"][:3]] == sorted(
        r.first_frequency for r in shown["rows"][:3]
    )
    text = words(SUPPORT, held, shown)
    for wanted in ("calibrated", "predicted", "outside their validity"):
        assert wanted in text, wanted
    approved(page_text(page(SUPPORT, held, shown)))


@pytest.mark.usefixtures("undrawn")
def test_the_moment_is_held_against_what_the_contact_bears(support_held):
    """50 V: far beyond; a tenth of a volt: pressed all round."""
    moment = support_held["moment"]
    assert moment["largest"] > moment["tipping"] == pytest.approx(2.0 * moment["uplift"])
    quiet = SUPPORT.context(study("generator", "drive.voltage=0.1V"))["moment"]
    assert quiet["largest"] < quiet["uplift"]


@pytest.mark.usefixtures("undrawn")
def test_small_motions_in_words(held, up, approved):
    """Poles by both supplies; without current those of the rod held down, and it says so."""
    text = words(MOTIONS, held, MOTIONS.context(held))
    for wanted in ("current held", "voltage held", "by symmetry neither drive"):
        assert wanted in text, wanted
    shown = MOTIONS.context(up)
    assert shown["of"].coil.current == 0.05
    assert "Without current the coil neither pulls" in words(MOTIONS, up, shown)
    approved(page_text(page(MOTIONS, up, shown)))


def test_a_quick_report_says_what_it_leaves_out(up):
    """Large amplitudes take long; the command that gives them is named."""
    amplitude = words(large_motion.AMPLITUDE, up, large_motion.AMPLITUDE.context(up))
    assert "Not in the quick version" in amplitude
    assert "tactgen backbone" in amplitude


def test_more_than_the_head_bears_is_a_known_limit(up, monkeypatch):
    """On the first page, where the drive tips the head; not where it does not."""
    said = "outside their validity"
    monkeypatch.setattr(propagation, "_EVALUATIONS", 100)
    for moment, known in (({"largest": 2e-4, "tipping": 1e-4}, True),
                          ({"largest": 5e-5, "tipping": 1e-4}, False)):  # fmt: skip
        monkeypatch.setattr(up, "shown", {"support": {"moment": moment}})
        numbers = dict.fromkeys(("models", "checks", "parameters", "bridge", "magnetic_models"), 1)
        study_of = {"scene": up.scene, "normal": up.normal, "solution": up.solution}
        given = {"quick": True, "lateral": True, "turns_are_set": True, "number": NUMBER | numbers}
        shown = summary(up) | study_of | given
        text = templates().get_template("first_page.html").render(shown)
        assert (said in text) == known
        assert "Undefined" not in text


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


@pytest.mark.usefixtures("undrawn")
def test_the_deflection_stands_beside_the_papers(narrow, monkeypatch, approved):
    """Ranges and slopes of Fig 15 for the paper's bimorph at 50 V, and for no other."""
    of, states = narrow
    at = np.linspace(10.0, 1000.0, 50)
    line = LoadedDeflection(at, (4e-5 - 3e-8 * at).astype(complex), "")
    made = tuple(replace(state, deflection=line) for state in states)
    monkeypatch.setattr(large_motion, "rocking_states", lambda *_: made)
    shown = large_motion.AMPLITUDE.context(of)
    assert shown["rows"][1].slope == pytest.approx(-3e-8)
    assert (shown["rows"][0].least, shown["rows"][0].largest) == pytest.approx((1e-5, 3.97e-5))
    text = words(large_motion.AMPLITUDE, of, shown)
    for wanted in ("3.1 µm to 24.8 µm", "13.6 µm to 72.4 µm", "What remains unexplained", "1.00"):
        assert wanted in text, wanted
    approved(page_text(page(large_motion.AMPLITUDE, of, shown)))
    other = study("generator", "frequency=60,80", "drive.voltage=40V", quick=False)
    text = words(large_motion.AMPLITUDE, other, large_motion.AMPLITUDE.context(other))
    assert "72.4" not in text


@pytest.mark.usefixtures("undrawn")
def test_the_run_in_time(up, monkeypatch, approved):
    """Phases beside the text's, errors and the current that is needed."""
    monkeypatch.setattr(large_motion, "_UNTIL", 2e-4)
    monkeypatch.setattr(large_motion, "_QUICK_ACCURACY", 0.3)
    shown = large_motion.TIME.context(up)
    (phase,) = shown["phases"]
    assert phase.name == "pressed"
    assert shown["order"] == {"pressed": phase.amplitude}
    assert shown["pull_in"].value == pytest.approx(0.1185, rel=0.01)
    assert shown["film"].count('class="tr tr-within"') == 1
    assert shown["still"].startswith("data:image/png")
    film = re.search(r'id="tr-data">(.*?)</script>', shown["film"], re.DOTALL)[1]
    assert json.loads(film.replace("<\\/", "</"))["until"] == pytest.approx(2e-4)
    text = words(large_motion.TIME, up, {**shown, "film": ""})
    for wanted in ("4 to 7 ms", "Not all four phases occur", "118.4", "energy balance"):
        assert wanted in text, wanted
    approved(page_text(page(large_motion.TIME, up, {**shown, "film": ""})))


def test_a_bimorph_on_other_supports_has_no_such_sections():
    """Nothing magnetic is shown, or computed, for the paper's springs."""
    machine = {"positions", "support", "motions", "amplitude", "time"}
    paper = study("paper", "models=tmm", "quantities=tip_displacement")
    assert not machine & {section.id for section in sections(paper)}
    alone = study("paper", "models=tmm", "quantities=tip_displacement",
                  "support.kind=contact", "coil.current=0mA")  # fmt: skip
    assert machine <= {section.id for section in sections(alone)}
    assert POSITIONS.context(alone) is None
    assert MOTIONS.context(alone) is None
    assert len(SUPPORT.context(alone)["rows"]) == 3
