"""The report on the normal actuator: complete, honest about assumptions, nothing else run."""

import re
import subprocess
import sys
from types import SimpleNamespace

import numpy as np
import pytest
from pages import page_text

from tactgen.tmm.reluctance.coenergy_fit import read_map
from tactgen.validation.command_line.cli import main
from tactgen.validation.engine.solve import solve
from tactgen.validation.report.page import write_report
from tactgen.validation.report.reluctance_data import NormalActuator
from tactgen.validation.report.report_data import Study
from tactgen.validation.report.sections.reluctance import _deviations
from tactgen.validation.scene.load import load_scene
from tactgen.validation.show.export import scene_solids

NORMAL = ["magnetic_models", "magnetic_field", "characteristics"]
BOTH = "quantities=tip_displacement,magnetic_force"


def make(folder, name, *overrides):
    scene, origins = load_scene(name, overrides)
    steps = []
    page = write_report(scene, origins, folder, True, steps.append)
    return page.read_text(encoding="utf-8"), steps


def ids(html):
    return re.findall(r'<h2 id="(\w+)">', html)


def words(html):
    return page_text(html).replace("\n", " ").replace(" | ", " ")


@pytest.fixture(scope="module")
def reluctance(tmp_path_factory, rough_fields, make_plain):
    """The plain quick report of the built-in scene, with rough fields."""
    from tactgen.validation.report.sections import reluctance  # slow to import

    with rough_fields(tmp_path_factory.mktemp("rough")) as patch:
        make_plain(patch)
        patch.setattr(reluctance, "_PICTURE", {"order": 2, "refinement": 0.7})
        return make(tmp_path_factory.mktemp("reluctance"), "reluctance")


@pytest.fixture(scope="module")
def at_a_point():
    """The built-in scene without a map of the field."""
    return actuator("accuracy=1%", quantities=("magnetic_force", "incremental_inductance"))


def actuator(*overrides, models=None, quantities=None):
    scene, _ = load_scene("reluctance", overrides)
    return NormalActuator(solve(scene, models, quantities), lambda _: None)


def test_report_is_complete_and_self_contained(reluctance):
    """Sections of the normal actuator only, its checks, pictures inside the page."""
    html, *_ = reluctance
    assert ids(html) == [*NORMAL, "checks", "parameters"]
    assert not re.search(r"(?:src|href)=\"(?!data:|#)", html)
    assert html.count('<img src="data:image/png;base64,') == 1  # rod, coil and sleeve
    assert html.count("<figure><svg") == 5  # bridge, field, forces, fluxes, switching
    assert "<td>PAP-9</td>" in html
    assert not re.search(r"\bnan\b|\bNone\b|Undefined|\binf\b", words(html))


def test_report_asks_nothing_of_the_lateral_actuator(reluctance):
    """No stage, section, check or parameter of the bimorph.

    The map of the field, the costly part, is left out of a quick one, and that is said.
    """
    html, steps = reluctance
    assert "axisymmetric.map" not in steps
    assert "field at single points" in steps
    assert "not in the quick version" in html
    assert not any(step.split(".")[0] in ("lumped", "tmm", "beam", "solid") for step in steps)
    assert "<td>TMM-1</td>" not in html
    assert "<code>bimorph.length</code>" not in html
    assert "<code>rod.density</code>" not in html
    assert "<code>spring.preload</code>" in html


def test_what_is_assumed_is_said_first(reluctance):
    """Before any section: reconstructed, and agreement with the paper is no confirmation.

    After it families, switching, finger force, coil, heat, inductance: each with its unit.
    """
    html, *_ = reluctance
    head, text = words(html[: html.index("<h2 ")]), words(html)
    assert "The paper's reluctance actuator is reconstructed" in head
    assert "confirms nothing" in head
    for wanted in (
        "pull-in", "drop-out", "holding", "Spring force minus magnetic force",
        "resistance 125.8 Ω", "current density in the wire 350 A/mm&sup2;", "not plausible",
        "electrical time constant",
    ):  # fmt: skip
        assert wanted in text, wanted


@pytest.mark.usefixtures("undrawn")
def test_network_alone(tmp_path, monkeypatch, make_plain):
    """Without the field there is no picture of it, and the bridge ends at the network.

    What is said of the paper's spring stands there.
    """
    make_plain(monkeypatch)
    html, steps = make(tmp_path, "reluctance", "models=network")
    assert ids(html) == ["magnetic_models", "characteristics", "checks", "parameters"]
    assert "no field model ran" in html
    assert not any("axisymmetric" in step or "field" in step for step in steps)
    check_words(
        words(html),
        ("stays at the upper stop until", "the preload was set to this value",
         "The turns were chosen so that", "the network's force differs from the field's"),
        ("floats", "the scene sets a different", "circuit differs from"),
    )  # fmt: skip


def check_words(text, there, not_there):
    assert not re.search(r"\bnan\b|\bNone\b|Undefined|\binf\b", text)
    assert [wanted for wanted in there if wanted not in text] == []
    assert [wrong for wrong in not_there if wrong in text] == []


@pytest.mark.usefixtures("own_store", "undrawn")
def test_a_current_that_is_not_reached_is_said(tmp_path, monkeypatch, make_plain):
    """Words instead of a number wherever pull-in is shown, and no picture fails."""
    make_plain(monkeypatch)
    small = np.linspace(0.0, 0.06, 13), np.geomspace(20e-6, 0.25e-3, 12)
    monkeypatch.setattr("tactgen.tmm.reluctance.map_range.map_grid", lambda _: small)
    html, _ = make(tmp_path, "reluctance", "models=network", "coil.current=40 mA")
    there = ("No current up to 60 mA moves the rod", "not reached")
    check_words(words(html), there, ("snaps down",))


def test_network_is_held_against_the_field(at_a_point):
    """Differences are those of the two values; the field stands last as the reference."""
    force = next(row for row in at_a_point.comparison if row.quantity == "magnetic_force")
    network, field = force.cells
    assert (field.model, field.verdict) == ("axisymmetric", "reference")
    assert network.difference == pytest.approx(network.value / field.value - 1.0)
    assert network.verdict == "explained"
    last = at_a_point.steps[-2:]
    assert [step.values["magnetic_force"] for step in last] == pytest.approx(
        [network.value, field.value]
    )


def test_paper_is_judged_by_the_field_where_there_is_one(at_a_point):
    """The quick version has no map of the field, but what the paper says is asked of the field."""
    by_field = at_a_point.point(0.13, 0.2e-3).force
    by_network = float(at_a_point.pull.force(0.13, 0.2e-3))
    assert by_field.value == pytest.approx(0.11, rel=0.005)  # what the turns were chosen for
    assert by_network > 1.1 * by_field.value
    # one number everywhere: the one in the table of models
    shown = at_a_point.solution.get("magnetic_force", "axisymmetric")
    assert (by_field.value, by_field.error) == (shown.value, shown.error)


def test_inductances_are_those_of_the_quantities():
    """The coil's table takes single points: at the scene's state it repeats the model's values."""
    made = actuator("models=network")
    found = made.point(made.current, made.gap, mapped=True)
    for name in ("inductance", "incremental_inductance"):
        assert getattr(found, name).value == made.solution.get(name, "network").value


def test_parts_follow_what_is_asked():
    """An actuator is shown if a model and a quantity of it are asked for, else left alone."""

    def parts(*overrides):
        few = "models=tmm,network", "frequency=10"
        scene, origins = load_scene("paper", (*few, *overrides))
        study = Study(scene, origins, lambda _: None, quick=True)
        return study.lateral, study.normal is not None

    assert parts(BOTH) == (True, True)
    assert parts("quantities=tip_displacement") == (True, False)
    assert parts("quantities=magnetic_force") == (False, True)


@pytest.mark.heavy
def test_report_of_both_actuators(tmp_path):
    """All sections of a quick one, headlines and parameters of both."""
    html, _ = make(tmp_path, "paper", "models=lumped,tmm,network,axisymmetric", BOTH)
    assert ids(html) == [
        "models", "modes", "response", "drive_limits", "uncertainty", "magnetic_models",
        "characteristics", "measurements", "checks", "parameters",
    ]  # fmt: skip
    text = words(html)
    for headline in ("static tip displacement", "magnetic force at 130 mA, 200 µm"):
        assert headline in text[: text.index("What could be wrong")]
    assert "<code>bimorph.length</code>" in html
    assert "<code>coil.turns</code>" in html
    assert not re.search(r"\bnan\b|\bNone\b|Undefined|\binf\b", text)


#: Reports of either actuator alone, each in a process of its own that begins with what both need.
ALONE = """
import os, sys
from matplotlib.backends.backend_svg import FigureCanvasSVG
import tactgen.validation.report.report_data as study
from tactgen.validation.show import figures
figures.lay_out = lambda _: None  # slow, of no concern here, as drawing is
FigureCanvasSVG.print_svg = lambda _, file, **__: file.write("<svg></svg>")
from tactgen.validation.report.sections.contents import sections
from tactgen.validation.scene.load import load_scene
for name, models in (("prototype", "lumped,tmm"), ("reluctance", "network")):
    child = os.fork()
    if child:
        if os.waitpid(child, 0)[1]:
            sys.exit(1)
        continue
    scene, origins = load_scene(name, (f"models={models}",))
    made = study.Study(scene, origins, lambda _: None, quick=True)
    for section in sections(made):
        if section.id not in ("what", "stress", "uncertainty", "length", "voltage"):  # slow, shared
            section.context(made)
    made.parameters
    print(name, *sys.modules, flush=True)
    os._exit(0)
"""


@pytest.fixture(scope="module")
def loaded():
    """The modules that a report of either actuator alone has loaded, by its scene."""
    command = [sys.executable, "-c", ALONE]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    return {names[0]: set(names) for names in map(str.split, done.stdout.splitlines())}


@pytest.mark.heavy
def test_lateral_report_imports_nothing_magnetic(loaded):
    """A scene that asks for the bimorph alone loads no magnetic model, check or plot."""
    lateral = loaded["prototype"]
    assert "tactgen.validation.report.sections.bimorph" in lateral
    assert not lateral & {
        "tactgen.fem.magnetics.axisymmetric", "tactgen.fem.magnetics.axisymmetric_field",
        "tactgen.tmm.reluctance.network", "tactgen.validation.evidence.cases.reluctance",
        "tactgen.validation.report.sections.reluctance",
    }  # fmt: skip


@pytest.mark.heavy
def test_normal_report_imports_nothing_piezoelectric(loaded):
    """The other way round: no solid, no beam elements, no lateral sections."""
    normal = loaded["reluctance"]
    assert "tactgen.tmm.reluctance.network" in normal
    assert not normal & {
        "tactgen.fem.piezo.solid", "tactgen.fem.piezo.modes", "tactgen.fem.piezo.ports",
        "tactgen.fem.beam",
        "tactgen.validation.evidence.cases.audit",
        "tactgen.validation.report.sections.bimorph",
    }  # fmt: skip


def test_map_is_exported(tmp_path, capsys):
    """The most detailed model's map that the scene asks for, as netCDF that reads back."""
    file = tmp_path / "map.nc"
    assert main(["export", "reluctance", "--set", "models=network", "--map", str(file)]) == 0
    assert capsys.readouterr().out.splitlines() == [str(file)]
    found, solved = read_map(file), actuator("models=network").pull
    assert found.samples.model == "network"
    # whose map it is can be told from the file alone
    for value in ("coil.turns = 560", "rod.radius = 0.00064", "sleeve.length = 0.0187",
                  "steel.curve = team20"):  # fmt: skip
        assert value in found.samples.device
    assert float(found.force(0.1, 1e-4)) == pytest.approx(float(solved.force(0.1, 1e-4)), rel=1e-12)
    assert [p.name for p in tmp_path.iterdir()] == ["map.nc"]


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        (("paper", "--map", "map.nc"), "--map needs one of the models network, axisymmetric"),
        (("reluctance", "--set", "models=magnetic3d", "--set", "mesh.kind=tetwild", "--map",
          "map.nc"), "mesh.kind = tetwild gives magnetic3d single points only"),
        (("reluctance", "--map", "map.csv"), "must end in .nc"),
    ],
)  # fmt: skip
def test_map_that_cannot_be_had_is_refused(tmp_path, monkeypatch, capsys, arguments, sentence):
    """One sentence, exit code 2, no file."""
    monkeypatch.chdir(tmp_path)
    assert main(["export", *arguments]) == 2
    error = capsys.readouterr().err
    assert sentence in error
    assert error.count("\n") == 1
    assert not list(tmp_path.iterdir())


def test_solids_are_those_of_the_actuator_asked_about():
    """Rod, coil and sleeve for a magnetic scene; the rod keeps its slot though no tab fits it."""
    scene, _ = load_scene("reluctance")
    solids = scene_solids(scene)
    assert sorted(solids) == ["coil", "rod", "sleeve"]
    r, slot = scene.rod, scene.glue.thickness
    full = np.pi * (
        r.radius**2 * (r.length + 0.2e-3 - r.flange_thickness)
        + r.flange_radius**2 * r.flange_thickness
        + r.head_radius**2 * r.head_thickness
    )
    cut = (
        (scene.bimorph.shim_thickness + 2 * slot) * (scene.bimorph.width + 2 * slot) * r.slot_depth
    )
    assert solids["rod"].Volume() * 1e-9 == pytest.approx(full - cut, rel=1e-6)


def test_deviations_are_those_of_the_network_from_the_field():
    """Over all currents and gaps; of one alone there are none."""
    field = SimpleNamespace(force=lambda current, gap: current * gap)
    network = SimpleNamespace(force=lambda current, gap: (1.0 + 0.1 * gap) * current * gap)
    actuator = SimpleNamespace(
        maps={"network": network, "axisymmetric": field}, currents=np.array([1.0, 2.0]),
        gaps=np.array([3.0, 4.0, 5.0]),
    )  # fmt: skip
    found = _deviations(actuator)
    assert found["table"] == pytest.approx(0.1 * np.array([[3.0, 4.0, 5.0]] * 2))
    assert (found["currents"] is actuator.currents, found["gaps"] is actuator.gaps) == (True, True)
    actuator.maps.pop("axisymmetric")
    assert _deviations(actuator) is None
