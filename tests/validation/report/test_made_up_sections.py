"""Sections of the report whose solids are beams, or whose numbers are made up: what they show."""

from types import SimpleNamespace

import numpy as np
import pytest
from approved import described, figure_text

from tactgen.tmm.generator.network_pull import network_pull
from tactgen.validation.engine.results import Quantity
from tactgen.validation.engine.solve import solve
from tactgen.validation.models.bimorph import joint_compliance
from tactgen.validation.models.bimorph.joint_compliance import (
    SupportCompliance,
    SupportStudy,
    fitted_springs,
    frequency_on,
    tab_by_beam,
)
from tactgen.validation.report.figures import bimorph, display, magnetic_field
from tactgen.validation.report.sections import bridge, gallery, machine
from tactgen.validation.report.sections import display as display_section
from tactgen.validation.scene.scene import load_scene

#: Rotation per moment of slot, glue and rod (rad/(N m)), and displacement per force (m/N).
JOINT = SupportCompliance(np.array([[2e-6, -1e-4], [-1e-4, 0.9]]))


@pytest.fixture(scope="module")
def support():
    """Return the section on a support whose solid tabs are beams, with its scene."""
    with pytest.MonkeyPatch.context() as patch:
        yield made_of_beams(patch)


def made_of_beams(monkeypatch):
    scene = load_scene("bimorph_on_rod", ["load.kind=none"])[0]
    lengths = 1e-3 * np.arange(0.0, 3.1, 0.5)
    tabs = [SupportCompliance(np.zeros((2, 2))), *(tab_by_beam(scene, at) for at in lengths[1:])]
    study = SupportStudy(scene, lengths, tabs, JOINT, 1.5e-3)
    monkeypatch.setattr(joint_compliance, "support_study", lambda *_: study)
    monkeypatch.setattr(joint_compliance, "joint_by_solids", lambda chain: {"whole": JOINT})
    by_beam = SupportCompliance(0.5 * JOINT.matrix)
    by_modulus = dict.fromkeys(((None, m, True) for m in joint_compliance.GLUE_MODULI), by_beam)
    monkeypatch.setattr(
        joint_compliance,
        "joint_by_beam",
        lambda chain, modulus, *, rod: by_modulus[chain, modulus, rod],
    )
    drawn = []
    monkeypatch.setattr(bridge, "support_plot", lambda *given: drawn.append(given) or "plot")
    found = bridge._support(SimpleNamespace(scene=scene, announce=lambda _: None), None)
    return scene, study, found, drawn


def test_the_tab_that_gives_the_fitted_stiffness(support, approved):
    """Alone L = EI/c_s; in the rod shorter by what slot, glue and rod turn."""
    scene, study, found, _ = support
    bending = tab_by_beam(scene, 1e-3).rotational_stiffness * 1e-3
    stiffness = scene.support.rotational_stiffness
    assert found["alone"] == pytest.approx(bending / stiffness, rel=1e-6)
    assert found["by_beam"] == pytest.approx(found["alone"], rel=1e-6)
    assert found["in_rod"] == pytest.approx(found["alone"] - 0.9 * bending, rel=1e-6)
    whole = found["at_in_rod"]
    assert whole.rotational_stiffness == pytest.approx(stiffness, rel=1e-6)
    for modulus, rotation, tab in found["glue"]:
        assert rotation == 0.45
        assert tab == pytest.approx(found["alone"] - 0.45 * bending, rel=1e-6)
        assert modulus in joint_compliance.GLUE_MODULI
    assert study.target == stiffness
    approved(described(found))


def test_each_tab_stands_beside_its_beam_and_in_the_rod(support):
    """A row a length: the longer and the softer its base, the lower the frequency."""
    scene, study, found, _ = support
    assert [row[0] for row in found["tabs"]] == study.lengths.tolist()
    for length, alone, by_beam, whole, frequency in found["tabs"]:
        if length:
            assert alone.matrix == pytest.approx(by_beam.matrix, rel=1e-6)
        else:
            assert by_beam is None
        assert whole.matrix[1, 1] == pytest.approx(alone.matrix[1, 1] + 0.9, rel=1e-6)
        assert frequency == frequency_on(scene, whole)
    frequencies = [row[-1] for row in found["tabs"]]
    assert frequencies == sorted(frequencies, reverse=True)


def test_frequencies_on_the_support_as_built(support):
    """On springs, on the whole, without coupling; and the tab that has the springs' frequency."""
    scene, study, found, _ = support
    assert found["on_springs"] == frequency_on(scene, fitted_springs(scene))
    built = study.at(1.5e-3, in_rod=True)
    assert found["on_whole"] == frequency_on(scene, built)
    assert found["uncoupled"] == frequency_on(scene, SupportCompliance(np.diag(np.diag(
        built.matrix))))  # fmt: skip
    assert found["uncoupled"] != found["on_whole"]
    same = study.at(found["same_frequency"], in_rod=True)
    # interpolated over the lengths
    assert frequency_on(scene, same) == pytest.approx(found["on_springs"], rel=5e-3)
    # ten times softer sideways: a little lower
    assert -0.05 < found["soft_lateral"] < 0.0


def test_the_curves_are_those_of_beam_solid_and_whole(support):
    """Rotation per moment by length, and the length at which each meets the fitted one."""
    _, study, found, ((lengths, curves, target, best),) = support
    assert found["support_plot"] == "plot"
    assert target == pytest.approx(1.0 / study.target)
    alone = curves["solid, tab alone"]
    assert curves["beam, tab alone"] == pytest.approx(alone, rel=1e-6)
    assert curves["solid, tab, glue and rod"] == pytest.approx(alone + 0.9)
    for name, values in curves.items():
        assert np.interp(best[name], lengths, values) == pytest.approx(target, rel=1e-6), name


@pytest.fixture
def figures(monkeypatch):
    """Return figures as they are, not as text."""
    for module in (bimorph, display):
        monkeypatch.setattr(module, "svg", lambda figure: figure)


def test_the_support_is_drawn_in_millimetres(figures, approved):
    """A curve a name, a point where it meets the fitted value; none where it never does."""
    lengths = np.array([0.0, 1e-3, 2e-3])
    curves = {"beam": 1e3 * lengths, "solid": 2e3 * lengths, "whole": 0.1 + lengths}
    best = {"beam": 1.5e-3, "solid": 0.75e-3, "whole": np.nan}
    (axis,) = bimorph.support_plot(lengths, curves, 1.5, best).axes
    lines = {line.get_label(): line for line in axis.lines}
    for name, values in curves.items():
        assert lines[name].get_xdata() == pytest.approx([0.0, 1.0, 2.0])
        assert lines[name].get_ydata() == pytest.approx(values)
    points = [line.get_xydata()[0].tolist() for line in axis.lines if line.get_marker() == "o"]
    assert points == [pytest.approx([1.5, 1.5]), pytest.approx([0.75, 1.5])]
    level = [line for line in axis.lines if list(line.get_ydata()) == [1.5, 1.5]]
    assert len(level) == 1
    said = {text.get_text(): text for text in axis.texts}
    assert set(said) == {"1.50 mm", "0.75 mm", "fitted, 1/c_s"}
    assert said["1.50 mm"].xy == pytest.approx((1.5, 1.5))
    assert axis.get_xlim() == pytest.approx((0.0, 2.0))
    assert axis.get_ylim()[0] == 0.0
    assert [text.get_text() for text in axis.get_legend().get_texts()] == list(curves)
    approved(figure_text(axis.figure))


def quantity(name, value, *, model="tmm", frequency=None, classes=None, unit="1"):
    value = np.asarray(value)
    return Quantity(name, model, value, unit, np.zeros(value.shape), "", 0.0, frequency, classes)


def test_crosstalk_is_drawn_in_percent_by_the_last_model(figures, approved):
    """On logarithmic axes where no frequency is 0; nothing where no model knows it."""
    f = (10.0, 100.0)
    first = quantity("crosstalk_near", [0.1, 0.1], frequency=f)
    near = quantity("crosstalk_near", [0.03 + 0.04j, 0.02], model="beam", frequency=f)
    far = quantity("crosstalk_far", [0.01, 0.005], model="beam", frequency=f)
    unknown = quantity("crosstalk_none", [np.nan, np.nan], model="beam", frequency=f)
    (axis,) = display.crosstalk_plot([first, near, far, unknown]).axes
    assert [line.get_label() for line in axis.lines] == [
        "crosstalk near, beam",
        "crosstalk far, beam",
    ]
    assert axis.lines[0].get_ydata() == pytest.approx([5.0, 2.0])
    assert axis.lines[1].get_xdata() == pytest.approx(f)
    assert (axis.get_xscale(), axis.get_yscale()) == ("log", "log")
    slow = quantity("crosstalk_near", [0.1, 0.1], frequency=(0.0, 10.0))
    assert display.crosstalk_plot([slow]).axes[0].get_xscale() == "linear"
    assert display.crosstalk_plot([]) == display.crosstalk_plot([unknown]) == ""
    approved(figure_text(axis.figure))


def test_units_are_listed_by_the_last_model(approved):
    """A row a unit, a column a quantity of that model."""
    classes = ("r1c1", "r1c2")
    asked = [
        quantity("crosstalk_largest", 0.1),
        quantity("short_circuit_frequencies", [1.0, 2.0], classes=classes, unit="Hz"),
        quantity("short_circuit_frequencies", [3.0, 4.0], classes=classes, unit="Hz", model="beam"),
        quantity("static_tip_displacement", [5.0, 6.0], classes=classes, unit="m", model="beam"),
    ]
    found = display_section._units(asked)
    assert found["model"] == "beam"
    assert [unit for _, unit in found["labels"]] == ["Hz", "m"]
    assert found["rows"] == [
        ("r1c1", [(3.0, "Hz"), (5.0, "m")]),
        ("r1c2", [(4.0, "Hz"), (6.0, "m")]),
    ]
    assert display_section._units(asked[:1]) is None
    approved(described(found))


def test_the_displays_section_has_its_parts_and_its_narrowest_gaps(monkeypatch, approved):
    """Two pictures, one cut along a column; ten gaps, and how many are wider."""
    from tactgen.validation.export import display_view
    from tactgen.validation.view import pictures

    scene = load_scene("display", ["models=tmm", "display.rows=1", "display.columns=2"])[0]
    drawn = []

    def picture(parts, cut=None):
        drawn.append((parts, cut))
        return b"png"

    monkeypatch.setattr(display_view, "drawn_parts", lambda scene: "parts")
    monkeypatch.setattr(pictures, "assembly_picture", picture)
    plotted = []
    from tactgen.validation.report.figures import display as figures

    monkeypatch.setattr(figures, "crosstalk_plot", lambda asked: plotted.append(asked) or "plot")
    over = quantity("crosstalk_largest", [0.1], frequency=(10.0,))
    alone = quantity("pull_one_driven", 0.1)
    other = quantity("tip_displacement", [0.1], frequency=(10.0,))
    study = SimpleNamespace(
        scene=scene, announce=lambda _: None,
        solution=SimpleNamespace(quantities=[over, alone, other]),
    )  # fmt: skip
    found = display_section.display_section(study)
    assert drawn == [("parts", None), ("parts", 500.0 * scene.display.pitch)]
    assert plotted == [[over]]
    gaps = display_section.clearances(scene.device, scene.display)
    assert found["gaps"] == gaps[:10]
    assert found["gaps"][0].gap == min(one.gap for one in gaps)
    assert found["wider"] + 10 == len(gaps)
    assert found["mass"] == pytest.approx(sum(line.count * line.mass for line in found["bill"]))
    assert found["height"] == pytest.approx(45e-3, abs=1e-3)
    assert [row.cells for row in found["numbers"]] == [(alone,)]
    approved(described({k: v for k, v in found.items() if k != "numbers"}))


def test_small_motions_by_a_models_own_map(approved):
    """By the network: what its pull says where the rod rests, and the fastest pole's frequency."""
    scene = load_scene("generator", ["models=tmm,network", "coil.current=60 mA", "load.kind=none"])[
        0
    ]
    found = machine._on_map(scene, "network")
    gap = scene.device.gap + scene.rest[0].lift
    pull, current = network_pull(scene.device), scene.coil.current
    inductance = pull.incremental_inductance(current, gap)
    assert found.model == "network"
    assert found.incremental_inductance.value == pytest.approx(float(inductance), rel=1e-3)
    assert abs(found.motional.value) == pytest.approx(
        abs(float(pull.motional_coefficient(current, gap))), rel=1e-2
    )
    assert found.axial_stiffness.value > 0.0
    assert found.rocking_stiffness.value > 0.0
    moved = solve(
        scene.model_copy(update={"frequency": (1e-3,)}), ("tmm",), ("axial_tip_per_current",)
    ).quantities[0].value[0]  # fmt: skip
    slow = found.motional.value / found.axial_stiffness.value
    assert abs(moved) == pytest.approx(abs(slow), rel=2e-2)
    assert np.sign(slow) == -np.sign(moved.real)  # what pulls at the gap moves the tip down
    approved(described(found))


def test_cells_are_named_and_stills_are_of_the_first_modes(monkeypatch):
    """Only of the short circuit, as many as the section has room for, each with its words."""
    from tactgen.validation.view import shading, stills

    states = [SimpleNamespace(circuit=c, name=f"{c} {n}") for n in (1, 2, 3, 4, 5, 6)
              for c in ("short", "open")]  # fmt: skip
    words = lambda result, state: SimpleNamespace(  # noqa: E731
        title=state.name, number="3 Hz", detail="bending"
    )
    asked = []
    monkeypatch.setattr(shading, "words_of", words)
    monkeypatch.setattr(stills, "still", lambda result, state, picture: asked.append(
        (state.name, picture.shade)) or b"png")  # fmt: skip
    said = []
    found = gallery._stills(SimpleNamespace(states=states), said.append)
    names = [f"short {n + 1}" for n in range(gallery._MODES)]
    assert [name for name, _ in asked] == names
    assert {shade for _, shade in asked} == {shading.SHADES[0]}
    assert [one["caption"] for one in found] == [f"{name}: 3 Hz, bending" for name in names]
    assert all(one["png"].startswith("data:image/png;base64,") for one in found)
    assert said == [f"picture of {name}" for name in names]


@pytest.mark.parametrize("across", [1, 2, 4])
def test_each_gauss_point_has_a_patch_of_its_own(across):
    """Patches fill the intervals, and every point lies within its own."""
    lines = np.array([0.0, 1.0, 4.0])
    edges = magnetic_field._patches(lines, across)
    points = np.concatenate([
        0.5 * (a + b) + 0.5 * (b - a) * np.polynomial.legendre.leggauss(across)[0]
        for a, b in ((0.0, 1.0), (1.0, 4.0))
    ])  # fmt: skip
    assert edges.size == points.size + 1
    assert (edges[:-1] < points).all()
    assert (points < edges[1:]).all()
    assert set(lines) <= set(edges)


def test_steps_of_a_bridge_are_bars_from_where_the_last_one_ended(figures, approved):
    """In percent of the start; the whole from 0; marks at what a closed form says of a step."""
    made = [SimpleNamespace(
        name=name, deflection=value, first_frequency=value, capacitance=value,
        predicted=SimpleNamespace(deflection=0.05, first_frequency=0.05, capacitance=0.05),
        section=SimpleNamespace(deflection=np.nan, first_frequency=np.nan, capacitance=np.nan),
        step=SimpleNamespace(deflection=0.1, first_frequency=0.1, capacitance=0.1),
    ) for name, value in (("start", 2.0), ("up", 2.2), ("down", 1.98))]  # fmt: skip
    figure = bimorph.bridge_plot(made, "whole")
    approved(figure_text(figure))
    for axis in figure.axes:
        bars = [(bar.get_x(), bar.get_width()) for bar in axis.patches]
        assert bars == [pytest.approx(b) for b in ((0.0, 10.0), (10.0, -11.0), (0.0, -1.0))]
        assert axis.lines[0].get_xdata() == pytest.approx([5.0, 15.5])
