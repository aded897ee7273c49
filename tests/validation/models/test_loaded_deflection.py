"""Deflection under load where the head may rock: linear at small voltages, refusals."""

from types import SimpleNamespace

import numpy as np
import pytest

from tactgen.fem.piezo import reduction_files as kept_reductions
from tactgen.geometry.errors import InputError
from tactgen.tmm.ports.elements import attach
from tactgen.tmm.ports.multiport import respond
from tactgen.validation.evidence.cases import amplitude as amplitude_measurements
from tactgen.validation.models import backbone as states
from tactgen.validation.models.backbone import (
    STATES,
    LoadedDeflection,
    held_head,
    loaded_deflection,
    voltage_for,
)
from tactgen.validation.models.bimorph import solid as meshes
from tactgen.validation.models.five_port import five_port
from tactgen.validation.scene.scene import load_scene


def loaded(state):
    return load_scene("paper", ("support.kind=contact", "models=tmm", *STATES[state]))[0]


@pytest.mark.parametrize("kind", ["finger", "none"])
def test_a_state_has_curves_without_its_load_and_a_deflection_under_it(monkeypatch, kind):
    """None where the scene has no load; the voltage is the size of the scene's."""
    asked = []
    place = SimpleNamespace(contact_force=0.5)

    def head(scene):
        return SimpleNamespace(place=place, load=scene.load.kind)

    monkeypatch.setattr(states, "held_head", head)
    monkeypatch.setattr(
        states,
        "backbone",
        lambda head, volts, *_: asked.append((head.load, volts)) or SimpleNamespace(curves=()),
    )
    monkeypatch.setattr(
        states, "loaded_deflection", lambda head, volts, *_: asked.append((head.load, volts)) or 1.0
    )  # fmt: skip
    scene = load_scene("paper", (f"load.kind={kind}", "drive.voltage=-7 V"))[0]
    found = states._state(scene, "held", (3.0,), lambda _: None)
    assert (found.contact_force, found.deflection) == (0.5, None if kind == "none" else 1.0)
    assert asked == [("none", (3.0,)), (kind, 7.0)][: 1 if kind == "none" else 2]


def test_a_state_that_is_refused_says_why_beside_what_was_found(monkeypatch):
    def refused(*_):
        raise InputError("no orbit")

    place = SimpleNamespace(contact_force=0.5)
    monkeypatch.setattr(states, "held_head", lambda scene: SimpleNamespace(place=place))
    monkeypatch.setattr(states, "backbone", refused)
    scene = load_scene("paper", ("load.kind=none",))[0]
    found = states._state(scene, "held", (3.0,), lambda _: None)
    assert found == states.RockingState("held", 0.5, (), None, "no orbit")


@pytest.mark.heavy
def test_at_50_v_the_head_takes_what_the_linear_support_does_not():
    """At 30 Hz, not activated: less than the linear 39 um, since the head rocks."""
    scene = loaded("not activated")
    head = held_head(scene)
    port = attach(five_port(scene, "tmm")(np.array([30.0])), scene.ends)
    linear = float(np.abs(respond(port, {"voltage": 50.0}).motion["w_tip"][0]))
    found = loaded_deflection(head, 50.0, (30.0, 30.1))
    assert 0.5 * linear < np.abs(found.displacement[0]) < 0.95 * linear


def test_the_fitted_line_is_even_in_frequency():
    """However unevenly the branch was met."""
    at = np.geomspace(10.0, 1000.0, 40)
    line = LoadedDeflection(at, (5e-5 - 3e-8 * at).astype(complex), "")
    assert line.fitted_slope == pytest.approx(-3e-8, rel=1e-9)


def test_what_is_not_reached_is_said():
    """One sentence with the largest voltage allowed."""
    with pytest.raises(InputError, match=r"1e\+06 um at 60 Hz is not reached with 0.001 V"):
        voltage_for(held_head(loaded("held")), 60.0, 1.0, 1e-3)


@pytest.mark.parametrize(("extreme", "size"), [("largest", 5.0), ("smallest", 1.0)])
def test_extremes_of_a_loaded_deflection(monkeypatch, extreme, size):
    """Of the state and under the load that were asked for."""

    def loaded(state, load):
        assert (state, load) == ("held", "pad")
        return SimpleNamespace(displacement=np.array([3.0 + 4.0j, -2.0, 1.0j]))

    monkeypatch.setattr(amplitude_measurements, "_loaded", loaded)
    assert amplitude_measurements.extreme_deflection("held", extreme, "pad") == size


@pytest.mark.parametrize("model", ["solid", "cad"])
def test_ports_of_a_solid_know_no_support_and_reach_its_harmonics(monkeypatch, model):
    """Reduced for what is asked and five times as much, to a thousandth of the accuracy."""
    asked = []

    def pair(scene):
        asked.append((scene.support.kind, scene.models))
        return SimpleNamespace(meshes=("fine", "coarse"))

    def reduced(device, mesh, reach, *, tolerance):
        asked.append((mesh, reach.tolist(), tolerance))
        return SimpleNamespace(multiport=lambda frequencies: 2.0 * frequencies)

    monkeypatch.setattr(meshes, "mesh_pair", pair)
    monkeypatch.setattr(kept_reductions, "reduced_solid", reduced)
    scene, _ = load_scene("paper", ["frequency=20,300", "accuracy=0.02"])
    assert five_port(scene, model)(np.ones(2)).tolist() == [2.0, 2.0]
    assert asked == [("clamped", (model,)), ("fine", [0.0, 1500.0], pytest.approx(2e-5))]
    with pytest.raises(InputError, match='"network" has no ports; use one of tmm, lumped, beam'):
        five_port(scene, "network")
