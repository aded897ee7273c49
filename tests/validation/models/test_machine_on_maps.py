"""The machine on the co-energy map of the magnetic model that is asked for."""

from dataclasses import replace

import numpy as np
import pytest

from tactgen.geometry.device.parameters import Device
from tactgen.tmm.reluctance.coenergy_fit import fit, thinned
from tactgen.tmm.reluctance.map_range import map_grid, network_map
from tactgen.tmm.reluctance.network import network_samples
from tactgen.validation.catalogue.models import map_model
from tactgen.validation.engine.solve import make_plan, solve
from tactgen.validation.models.reluctance.field import AxisymmetricModel
from tactgen.validation.models.small_signal import HalvedMap
from tactgen.validation.scene import scene as scenes
from tactgen.validation.scene.load import load_scene

HELD = ("load.kind=none", "frequency=100,500", "coil.current=50mA", "coil.history=falling")
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
    return load_scene("generator", [*HELD, f"models={models}", *overrides])[0]


def test_of_those_asked_for_the_one_that_knows_most():
    """Without any the network; what is asked of solve goes before what the scene says."""
    assert map_model(("tmm", "beam")) == "network"
    assert map_model(("axisymmetric", "tmm", "network")) == "axisymmetric"
    assert map_model(("network", "magnetic3d")) == "magnetic3d"
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
