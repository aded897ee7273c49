"""The report's section about the machine: predicted numbers beside the paper's, and its limits."""

import re

import pytest

from tactgen.validation.report.page import templates
from tactgen.validation.report.sections.contents import sections
from tactgen.validation.report.sections.machine import MACHINE, machine_section
from tactgen.validation.report.study import Study
from tactgen.validation.scene.scene import load_scene

FEW = ("models=tmm,network", "frequency=10,100,439,1000")


def study(name="generator", *overrides):
    scene, origins = load_scene(name, [*FEW, *overrides])
    return Study(scene, origins, lambda _: None, quick=True)


@pytest.fixture(scope="module")
def held():
    """The scene held down by 50 mA, and what its section shows."""
    of = study("generator", "coil.current=50mA", "coil.history=falling")
    return of, machine_section(of)


def test_rows_are_the_scenes_own_support(held):
    """The state of the scene is that which its quantities were computed with."""
    of, shown = held
    springs = of.scene.held
    row = next(r for r in shown["rows"] if r.state == "50 mA, falling")
    assert row.rotational_stiffness == springs.rotational_stiffness
    assert row.first_frequency == of.solution.get("short_circuit_frequencies", "tmm").value[0]
    assert row.place.kind == "lower stop"
    up = next(r for r in shown["rows"] if "110 mN" in r.state)
    assert up.rotational_stiffness == pytest.approx(0.24, abs=0.005)
    assert [r.first_frequency for r in shown["rows"][:3]] == sorted(
        r.first_frequency for r in shown["rows"][:3]
    )


def test_the_moment_is_held_against_what_the_contact_bears(held):
    """50 V: far beyond; a tenth of a volt: pressed all round."""
    moment = held[1]["moment"]
    assert moment["largest"] > moment["tipping"] == pytest.approx(2.0 * moment["uplift"])
    quiet = machine_section(study("generator", "drive.voltage=0.1V"))["moment"]
    assert quiet["largest"] < quiet["uplift"]


def test_the_section_in_words(held):
    """All three parts, with both supplies' poles, and no number that is none."""
    of, shown = held
    html = templates().get_template("machine.html").render(scene=of.scene, **shown)
    text = re.sub(r"\s+", " ", re.sub(r"<svg.*?</svg>|<[^>]+>", " ", html, flags=re.DOTALL))
    for wanted in (
        "all places at 50 mA", "lower stop", "50 mA, falling", "calibrated", "current held",
        "voltage held", "outside their validity", "by symmetry neither drive",
    ):  # fmt: skip
        assert wanted in text, wanted
    assert not re.search(r"\bnan\b|\bNone\b|Undefined|\binf\b", text)


def test_a_bimorph_on_other_supports_has_no_such_section():
    """Nothing magnetic is shown, or computed, for the paper's springs."""
    paper = study("paper", "models=tmm", "quantities=tip_displacement")
    assert machine_section(paper) is None
    assert MACHINE not in sections(paper)
    alone = study("paper", "models=tmm", "quantities=tip_displacement",
                  "support.kind=contact", "coil.current=0mA")  # fmt: skip
    assert MACHINE in sections(alone)
    shown = machine_section(alone)
    assert not shown["magnetic"]
    assert len(shown["rows"]) == 3
