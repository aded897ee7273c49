"""The bridge from the beam to the solid: every step measured, predicted and added up."""

import math
from dataclasses import replace

import numpy as np
import pytest

from tactgen.fem.piezo.ports import direct_multiport
from tactgen.fem.piezo.solid import assemble
from tactgen.geometry.bimorph.bimorph_bricks import LEVELS, BrickParts, bimorph_bricks
from tactgen.geometry.device.parameters import Piezo
from tactgen.tmm.beam.sections import energy_shear_correction, laminate_section
from tactgen.tmm.ports.elements import attach
from tactgen.tmm.ports.multiport import respond
from tactgen.validation.catalogue.detection import DISPLAY_THRESHOLD
from tactgen.validation.engine.model import Refined
from tactgen.validation.engine.reading import read
from tactgen.validation.engine.solve import solve
from tactgen.validation.models.bimorph.beam_values import Values, beam_values
from tactgen.validation.models.bimorph.bridge import bridge, solid_values
from tactgen.validation.models.bimorph.bridge.assumptions import Assumptions, solid_steps
from tactgen.validation.models.bimorph.bridge.end_effect import end_effect
from tactgen.validation.models.bimorph.bridge.solid_values import (
    SolidCase,
    far_section,
    solve_solid,
    solve_static,
)
from tactgen.validation.models.bimorph.bridge.stepped import SteppedSolid, bridged, stepped
from tactgen.validation.models.bimorph.bridge.width import width_study
from tactgen.validation.models.bimorph.solid import level_for
from tactgen.validation.models.display.crosstalk import crosstalk
from tactgen.validation.report.request import prepared
from tactgen.validation.scene.scene import load_scene


def clamped(*overrides):
    return load_scene("paper", ["support.kind=clamped", "load.kind=none", *overrides])[0]


def with_energy_shear(scene):
    factor = energy_shear_correction(scene.device)
    return scene.model_copy(
        update={"beam": scene.beam.model_copy(update={"shear_correction": factor})}
    )


def beam_like(scene, level=0):
    nothing = Assumptions()
    return solve_solid(
        SolidCase(
            nothing.scene(scene),
            nothing.ceramic(scene.piezo.ceramic()),
            uniform_field=True,
            level=level,
        )
    )


@pytest.mark.parametrize("material", ["M1876", "PZT-5H"])
def test_beam_like_solid_is_the_beam(material):
    """With a beam's constants and a linear potential a slender solid is TMM, to 1e-3.

    What is left is the ends: at 60 mm far less than asked for, even on the coarsest bricks.
    """
    scene = with_energy_shear(clamped("bimorph.length=60 mm", f"piezo.material={material}"))
    step = beam_like(scene).values.step_from(beam_values(scene))
    assert np.abs(step).max() < 1e-3
    assert abs(step.deflection) < 1e-5
    assert abs(step.first_frequency) < 1e-5


def test_shear_factor_must_be_that_of_the_energy():
    """On a short beam, where shear counts, 5/6 is off by far more than the energy's factor."""
    scene = clamped("bimorph.length=10 mm")
    solid = beam_like(scene).values.first_frequency
    mended, usual = (
        abs(solid / beam_values(s).first_frequency - 1.0) for s in (with_energy_shear(scene), scene)
    )
    assert usual > 5e-3
    assert mended < 0.1 * usual


@pytest.fixture(scope="module", params=[0, pytest.param(1, marks=pytest.mark.heavy)])
def level(request):
    """How fine the bricks are of which a bridge is built."""
    return request.param


@pytest.fixture(scope="module")
def rungs(level):
    return bridge(clamped(), lambda _: None, level=level)


def test_steps_add_up(rungs, level):
    """The product of all steps leads from TMM to the scene's own solid."""
    for quantity in Values._fields:
        product = math.prod(1.0 + getattr(rung.step, quantity) for rung in rungs[1:])
        whole = getattr(rungs[-1].values, quantity) / getattr(rungs[0].values, quantity)
        assert product == pytest.approx(whole, rel=1e-12)
    solid = solve_solid(SolidCase(clamped(), level=level))
    # the shear factor, which only beams have, is all that differs
    assert rungs[-1].values == pytest.approx(solid.values, rel=1e-9)


def test_section_of_the_solid_is_the_closed_form(rungs, level):
    """As long as nothing happens across the width, section and closed form are one theory."""
    names = [rung.name for rung in rungs]
    for name in ("three dimensions", "field varies", "d33 and d15"):
        rung = rungs[names.index(name)]
        # the section's constants are differences of two solids: their rounding, and ends
        # that have not died out entirely over half the length, nor on the coarsest bricks
        apart = np.subtract(rung.section, rung.predicted)
        assert np.abs(apart).max() < (5e-6, 2e-6)[level]
    varies = rungs[names.index("field varies")]
    assert varies.step == pytest.approx(varies.predicted, abs=2e-4)
    assert varies.step.deflection < -0.01


def test_laminate_theory_bounds_the_width(rungs):
    """The section's steps across the width lie between none and those of a wide plate."""
    for rung in rungs[-2:]:
        for quantity in ("deflection", "capacitance"):
            plate, own = getattr(rung.predicted, quantity), getattr(rung.section, quantity)
            assert plate < own < 0.0


def test_narrow_strip_and_wide_plate_are_reached():
    """The far section goes from the strip's constants to laminate theory's as the width grows."""
    narrow, middle, wide = width_study(clamped(), (0.05, 1.0, 8.0), level=0)
    for key in ("bending", "moment", "capacitance"):
        a, b, c = (getattr(point, key) for point in (narrow, middle, wide))
        assert 0.0 < a < b < c < 1.0
        # side edges count by thickness over width: 0.13 of it narrow, 0.04 wide
        assert a < 0.2
        assert c > 0.95


def test_far_section_is_exact_where_there_is_theory():
    """Two lengths give back the laminate's constants for a solid without width effects."""
    scene = with_energy_shear(clamped())
    state = Assumptions(varying_field=True)
    case = SolidCase(state.scene(scene), state.ceramic(scene.piezo.ceramic()))
    found = far_section(case, solve_static(case))
    expected = laminate_section(scene.device, scene.beam, poisson=False, d32=False)
    for name in ("EI", "K", "C"):
        assert getattr(found, name) == pytest.approx(getattr(expected, name), rel=1e-6)


@pytest.mark.parametrize("material", ["M1876", "PZT-5H"])
def test_nothing_is_left_unexplained(material):
    """Section and ends explain the solid to 0.05 %, of effects ten times that.

    The rest is of the third order in thickness over length, and of the coarsest bricks.
    """
    found = end_effect(clamped(f"piezo.material={material}"), level=0)
    assert np.abs(found.rest).max() < 5e-4
    assert abs(found.effect.deflection) > 5e-3


@pytest.mark.usefixtures("few")
def test_impossible_sets_are_passed_over():
    """Where a set on the way could not exist, its change is made with the next."""
    scene = clamped()
    strong = scene.model_copy(update={"piezo": Piezo(eps33=4500.0)})
    with_d32 = Assumptions(varying_field=True, poling_constants=True, d32=True)
    with pytest.raises(ValueError, match="negative energy"):
        with_d32.ceramic(strong.piezo.ceramic()).check_admissible()
    found = bridge(strong, lambda _: None, level=0, sections=False)
    assert found[-1].name == "d32 and Poisson's effect"
    assert np.isfinite(found[-1].step).all()


def test_glue_has_no_laminate_theory_but_a_bridge():
    """With glue between the layers the rungs are measured and no closed form is made up."""
    found = bridge(clamped("bimorph.glue_thickness=20 um"), lambda _: None, level=0, sections=False)
    assert all(np.isnan(rung.predicted.deflection) for rung in found[2:])
    # glue keeps its Poisson ratio, which is all that is not a beam's
    assert found[2].step.first_frequency == pytest.approx(0.0, abs=1e-3)


@pytest.fixture
def few(monkeypatch, few_bricks):
    """Divide the solid into few bricks, for what holds on any."""
    monkeypatch.setattr(solid_values, "LEVELS", few_bricks)


@pytest.mark.usefixtures("few")
def test_bridge_of_the_sprung_bimorph_is_that_of_its_own_solid():
    """On springs the frequencies are the sprung ones, deflection and capacitance as clamped."""
    scene = load_scene("paper", ["load.kind=none"])[0]
    found = bridge(scene, lambda _: None, level=0, sections=False)
    assert found[0].first_frequency == pytest.approx(445.91, abs=0.01)
    own = solve_solid(SolidCase(scene, level=0))
    assert found[-1].values == pytest.approx(own.values, rel=1e-9)


@pytest.mark.usefixtures("few")
def test_every_quantity_is_led_from_the_beam_to_the_solid():
    """Driven under the finger, at rest and past the first mode: both ends are the models' own.

    Of the machine also its small motions, where the rod has a part that no step changes.
    """
    scene = load_scene("generator", ["frequency=10,1000", "models=tmm,solid"])[0]
    quantities = bridged(prepared(scene, quick=False))
    assert {"blocked_force", "load_power", "dynamic_stiffness"} <= set(quantities)
    assert {"lateral_tip_per_voltage", "coil_impedance"} <= set(quantities)
    beam, own = solve(scene, ("tmm",), quantities), SteppedSolid(scene, SolidCase(scene, level=0))
    solids = solid_steps(scene, level=0)
    found = {one.row.name: one for one in stepped(scene, quantities, lambda _: None, solids)}
    for name, one in found.items():
        assert one.steps[2:] == tuple(solid.name for solid in solids)
        solid = read(one.row.at_threshold(DISPLAY_THRESHOLD), own)
        count = one.values.shape[1]
        for at, value in ((0, beam.get(name, "tmm").value), (-1, solid.value)):
            np.testing.assert_allclose(one.values[at], np.abs(value)[:count], rtol=1e-9)
        with np.errstate(invalid="ignore"):
            apart = (one.values[0] - one.values[-1]) / one.size
        np.testing.assert_allclose(one.together, apart, rtol=1e-9)
    assert found["coil_impedance"].is_untouched
    assert not found["lateral_tip_per_voltage"].is_untouched
    # past the mode under the finger the same steps are worth twice as much
    tip, power = found["tip_displacement"], found["load_power"]
    assert abs(tip.together[1]) > 1.5 * abs(tip.together[0]) > 0.05
    assert tip.goes_with(found["tip_velocity"])
    assert not tip.goes_with(power)
    np.testing.assert_allclose(1.0 + power.together, (1.0 + tip.together) ** 2, rtol=1e-9)
    rungs = bridge(scene, lambda _: None, level=0, sections=False)
    for name, value in (
        ("short_circuit_frequencies", "first_frequency"),
        ("open_circuit_frequencies", "open_frequency"),
    ):
        first = [getattr(rung.values, value) for rung in rungs]
        np.testing.assert_allclose(found[name].values[:, 0], first, rtol=1e-9)
    system = assemble(scene.device, own.case.bricks(), lossy=True)
    port = attach(direct_multiport(system, np.array(scene.frequency)), scene.ends)
    moved = scene.drive.voltage * np.abs(respond(port, {"voltage": 1.0}).motion["w_tip"])
    np.testing.assert_allclose(tip.values[-1], moved, rtol=1e-9)


@pytest.mark.usefixtures("few")
def test_crosstalk_is_led_through_the_ports_of_every_step():
    """Of two units side by side: the beam's crosstalk first, that of the solid's ports last."""
    two = ("display.rows=1", "display.columns=2")
    scene = load_scene("display", ["frequency=100,785", "models=tmm,solid", *two])[0]
    assert "crosstalk_beside" in bridged(scene)
    (found,) = stepped(scene, ["crosstalk_beside"], lambda _: None, solid_steps(scene, 0))
    beam = solve(scene, ("tmm",), ["crosstalk_beside"]).get("crosstalk_beside", "tmm")
    solid = assemble(scene.device, SolidCase(scene, level=0).bricks(), lossy=True)
    ports = Refined(direct_multiport(solid, np.array(scene.frequency)), (), "")
    last = crosstalk(scene, ports).beside()
    np.testing.assert_allclose(found.values[[0, -1]], np.abs([beam.value, last.value]), rtol=1e-9)
    assert (found.together != 0.0).all()


def test_on_the_rod_the_first_solid_gives_up_two_assumptions():
    """Its bricks are joined of parts, which know no uniform field, as fine as the scene's own."""
    scene = load_scene("bimorph_on_rod", ["models=tmm,solid"])[0]
    steps = solid_steps(scene)
    whole = solid_steps(clamped())
    assert steps[0].name == f"{whole[0].name} and {whole[1].name}"
    assert [step.name for step in steps[1:]] == [step.name for step in whole[2:]]
    assert not any(step.case.uniform_field for step in steps)
    assert {step.case.level for step in steps} == {level_for(scene)}
    assert isinstance(steps[0].case.bricks(), BrickParts)


def test_shim_alone_lowers_the_frequency():
    """Of job J1 a clamp of the shim alone takes a tenth of f1, of the paper's soft shim a fifth."""
    lost = []
    for name in ("j1", "paper"):
        scene = load_scene(name, ["support.kind=clamped", "load.kind=none"])[0]
        whole, shim = (
            solve_solid(SolidCase(scene, held=held, level=0)).values.first_frequency
            for held in ("layers", "shim")
        )
        lost.append(1.0 - shim / whole)
    # a corner singularity: one division finer changes the second by 0.01, as does a second one
    assert lost[0] == pytest.approx(0.10, abs=0.01)
    assert lost[1] == pytest.approx(0.19, abs=0.02)


def test_given_mesh_is_used():
    """A case solved on a mesh of hexahedra is near the same case on bricks."""
    scene = clamped()
    bricks = bimorph_bricks(scene.device, LEVELS[0])
    case = SolidCase(scene, level=0)
    other = replace(case, mesh=bricks.corner_mesh())
    # 20-node hexahedra on the bricks' corners: a coarse mesh
    assert solve_solid(other).values == pytest.approx(solve_solid(case).values, rel=0.02)
