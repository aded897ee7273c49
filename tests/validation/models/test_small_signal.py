"""The machine's quantities by the models of the bimorph, on the magnetic model's map."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from tactgen.geometry.device.parameters import Device
from tactgen.geometry.errors import InputError
from tactgen.tmm.beam import transfer_matrix as tmm
from tactgen.tmm.generator.small_signal import machine
from tactgen.tmm.ports.multiport import respond
from tactgen.tmm.reluctance.coenergy_fit import fit, thinned
from tactgen.tmm.reluctance.map_range import map_grid, network_map
from tactgen.tmm.reluctance.network import network_samples
from tactgen.validation.catalogue.models import map_model
from tactgen.validation.catalogue.quantities import quantities_of
from tactgen.validation.engine.solve import make_plan, solve
from tactgen.validation.models.classes import map_of
from tactgen.validation.models.reluctance.field import AxisymmetricModel
from tactgen.validation.models.small_signal import HalvedMap, machine_of
from tactgen.validation.scene import scene as scenes
from tactgen.validation.scene.load import load_scene

UP = ("support.kind=contact", "coil.current=0mA", "frequency=10,100,446,800,1000")
HELD = ("support.kind=contact", "coil.current=50mA", "coil.history=falling", *UP[2:])
NAMES = quantities_of("generator")


@cache
def answers(*overrides, models=("tmm",), quantities=NAMES):
    scene, _ = load_scene("paper", overrides)
    solution = solve(scene, models, quantities, modelling=False)
    return {(q.model, q.name): q for q in solution.quantities}


def test_the_support_and_the_machine_tell_one_lateral_motion():
    """Without the rod's lateral mass, its lever and the lateral damping, which a support's springs
    leave out, the machine is the support to rounding; they are worth 1e-4 up to 100 Hz and, where
    the resonance is passed, some percent."""
    names = ("lateral_tip_per_voltage", "tip_displacement")
    overrides = (*UP, "load.kind=none")
    found = answers(*overrides, quantities=names)
    springs = found["tmm", names[1]].value / 50.0
    scene, _ = load_scene("paper", overrides)
    linear = machine_of(scene, map_of(scene)).fine
    turning, axial = linear.mass[1, 1], linear.mass[2, 2]
    damping = np.diag([0.0, *np.diag(linear.damping)[1:]])
    light = replace(linear, mass=np.diag([0.0, turning, axial]), damping=damping)
    ports = tmm.multiport(scene.device, scene.support, scene.beam, np.array(scene.frequency))
    alone = respond(machine(ports, light), {"voltage": 1.0, "current": 0.0}).motion["w_tip"]
    np.testing.assert_allclose(alone, springs, rtol=1e-9)
    off = np.abs(found["tmm", names[0]].value / springs - 1.0)
    assert (off[:2] > 0.0).all()
    assert (off[:2] < 1e-4).all()
    assert (off < 0.06).all()


def test_models_of_one_theory_agree():
    """Beam elements and tmm within 1e-6 on one map, far below its bars; lumped has statics and one
    mode."""
    found = answers(*HELD, models=("tmm", "beam", "lumped"))
    for name in NAMES:
        exact, beam, lumped = (found[model, name] for model in ("tmm", "beam", "lumped"))
        off = np.abs(beam.value - exact.value)
        assert (off <= 1e-6 * np.abs(exact.value)).all(), name
        at_10_hertz = lumped.value[0] == pytest.approx(exact.value[0], rel=1e-4, abs=1e-30)
        assert at_10_hertz, name


def test_series_wiring_halves_the_voltage_of_a_layer():
    """So a volt moves the tip half.  A bimorph on springs, as the paper's, is refused."""
    name = ("lateral_tip_per_voltage",)
    one, two = (
        answers(*UP, f"bimorph.wiring={wiring}", quantities=name)["tmm", *name].value
        for wiring in ("parallel", "series")
    )
    np.testing.assert_allclose(two, 0.5 * one, rtol=1e-9)
    scene, _ = load_scene("paper", ["frequency=100"])
    with pytest.raises(InputError, match=r"set support\.kind=contact"):
        make_plan(scene, ["tmm"], ["axial_poles"])


DOWN = ("load.kind=none", "frequency=100,500", "coil.current=50mA", "coil.history=falling")
#: How much more pull and flux than the network the field of these tests has.
MORE = 1.1


@pytest.fixture
def field(monkeypatch, own_store):
    """Let the field's map be the network's times a factor, and count how often it is solved."""
    solved = []

    def larger(self):
        solved.append(1)
        samples = network_samples(self.scene.device, *map_grid(self.scene.device))
        names = ("flux_linkage", "force", "coenergy", "incremental_inductance", "force_error")
        more = {name: MORE * getattr(samples, name) for name in names}
        return fit(replace(samples, model=self.name, **more))

    monkeypatch.setattr(AxisymmetricModel, "_map", larger)
    monkeypatch.setattr(scenes, "_FIELD_MAPS", {})
    return solved


def generator(models, *overrides):
    return load_scene("generator", [*DOWN, f"models={models}", *overrides])[0]


def test_of_those_asked_for_the_one_that_knows_most():
    """Without any the network; what is asked of solve goes before what the scene says."""
    for models, expected in (
        (("tmm", "beam"), "network"), (("axisymmetric", "tmm", "network"), "axisymmetric"),
        (("network", "magnetic3d"), "magnetic3d"),
    ):  # fmt: skip
        assert map_model(models) == expected
    scene = generator("tmm,axisymmetric")
    assert scene.asking(("tmm",)).map_model == "axisymmetric"
    assert scene.asking(("tmm", "network")).map_model == "network"


def test_the_plan_shows_the_map_and_solves_none(field):
    """For the machine always; for what stands on the contact where a current pulls."""
    scene, still = generator("tmm,axisymmetric"), generator("tmm,axisymmetric", "coil.current=0mA")
    assert set(make_plan(scene, ["tmm"], ["axial_poles"]).keys) == {
        "axisymmetric.map", "tmm.machine",
    }  # fmt: skip
    lateral = ["short_circuit_frequencies"]
    assert {"axisymmetric.map", "tmm.modes"} <= set(make_plan(scene, ["tmm"], lateral).keys)
    assert "tmm.machine" not in make_plan(scene, ["tmm"], lateral).keys
    assert "axisymmetric.map" not in make_plan(still, ["tmm"], lateral).keys
    keys = [make_plan(generator(m), ["tmm"], ["axial_poles"]).keys["tmm.machine"]
            for m in ("tmm", "tmm,network", "tmm,axisymmetric")]  # fmt: skip
    assert keys[0] == keys[1] != keys[2]
    turned = make_plan(generator("tmm,axisymmetric", "coil.turns=600"), ["tmm"], lateral).keys
    assert turned["tmm.modes"] != make_plan(scene, ["tmm"], lateral).keys["tmm.modes"]
    assert not field


def test_contact_and_machine_take_its_pull(field):
    """A pull that is 10 % larger presses harder, by what the spring leaves; one solution for all,
    also for the next run, and the reader is told whose it is."""
    names = ("short_circuit_frequencies", "lateral_tip_per_voltage", "axial_tip_per_current")
    one, other = (solve(generator(m), ("tmm",), names) for m in ("tmm", "tmm,axisymmetric"))
    assert len(field) == 1
    assert set(other.stages.seconds) == set(other.plan.keys)
    (told,) = [w for w in other.warnings if "coil.current" in w]
    assert "model axisymmetric" in told
    spring = one.scene.spring
    forces = [s.rest[0].contact_force for s in (one.scene, generator("tmm,axisymmetric"))]
    held = spring.preload + spring.stiffness * (one.scene.gap - spring.stop_gap)
    # pressed harder the head is 30 nm lower, in a gap of 20 um: up to twice 1.5e-3 more pull
    assert forces[1] + held == pytest.approx(MORE * (forces[0] + held), rel=3e-3)
    for name in names:
        a, b = (s.get(name, "tmm").value for s in (one, other))
        assert (np.abs(a - b) > 1e-3 * np.abs(a)).all()
    solve(generator("tmm,axisymmetric"), ("tmm",), names[:1])
    scenes._FIELD_MAPS.clear()
    solve(generator("tmm,axisymmetric"), ("tmm",), names[:1])  # from the store
    assert len(field) == 1


def test_slopes_that_agree_by_chance_count_as_those_around():
    """Where ∂λ/∂i of a map and of half its samples cross, they still count as apart."""
    whole = network_map(Device())
    half, _ = thinned(whole)
    gap, currents = 0.1e-3, np.linspace(0.3, 0.9, 200) * whole.current_limit
    apart = half.incremental_inductance(currents, gap) - whole.incremental_inductance(currents, gap)
    k = int(np.flatnonzero(apart[1:] * apart[:-1] < 0.0)[0])
    share = apart[k] / (apart[k] - apart[k + 1])
    at = float(currents[k] + share * (currents[k + 1] - currents[k]))
    here, there, moved = (
        float(of.incremental_inductance(at, gap)) for of in (whole, half, HalvedMap(whole, half))
    )
    counted, crossing = abs(moved - here), abs(there - here)
    assert crossing < 0.1 * np.abs(apart).max()
    assert 0.1 * np.abs(apart).max() < counted < 2.0 * np.abs(apart).max()
