"""Derivatives by models other than tmm: exact ones against differences, and physics' identities."""

import json
from types import SimpleNamespace

import numpy as np
import pytest

from tactgen.geometry.errors import InputError
from tactgen.validation.command_line import cli
from tactgen.validation.engine import derivatives as engine
from tactgen.validation.engine.derivatives import derivatives, extrapolated
from tactgen.validation.scene.scene import load_scene
from tactgen.validation.studies.sensitivity import changed_scenes, readable_keys


def asked(name, sets, model, quantities, keys):
    scene, _ = load_scene(name, sets)
    return derivatives(scene, changed_scenes(name, sets), model, quantities, keys)


def test_beam_elements_and_transfer_matrices_have_the_same_derivatives(capsys):
    models = ["--model", "tmm", "--model", "beam"]
    wanted = ["--quantity", "short_circuit_frequencies", "--key", "bimorph.length", "--json",
              "--set", "modes=1"]  # fmt: skip
    assert cli.main(["sensitivity", "prototype", *models, *wanted]) == 0
    exact, difference = json.loads(capsys.readouterr().out)["sensitivities"]
    assert (exact["model"], difference["model"]) == ("tmm", "beam")
    key = "bimorph.length"
    apart = abs(exact["logarithmic"][key] - difference["logarithmic"][key])
    assert apart <= exact["uncertainty"][key] + difference["uncertainty"][key]
    assert difference["uncertainty"][key] < 1e-4


def test_one_co_energy_map_gives_force_and_inductance():
    """∂W'/∂g is minus the pull, ∂²W'/∂i² the incremental inductance."""
    names = ("coenergy", "flux_linkage", "magnetic_force", "incremental_inductance")
    found = asked("reluctance", ["models=network"], "network", names, ["gap", "coil.current"])
    energy, flux, force, inductance = found
    for given, key, of, sign in (
        (energy, "gap", force, -1.0),
        (energy, "coil.current", flux, 1.0),
        (flux, "coil.current", inductance, 1.0),
    ):
        slope, bar, exact = given.slopes[key], given.bars[key], sign * of.quantity.value
        assert abs(slope - exact) <= bar + of.quantity.error
        assert abs(slope - exact) <= 5e-3 * abs(exact)


def test_a_key_that_changes_how_many_values_there_are_is_refused(monkeypatch):
    """As resonances that come and go: there is no difference to take."""
    scene, _ = load_scene("paper", [])

    def solved(count):
        answer = SimpleNamespace(name="f", value=np.ones(count), error=np.zeros(count))
        return SimpleNamespace(get=lambda *_: answer)

    counts = iter([2, 2, 2, 2, 3])
    monkeypatch.setattr(engine, "solve", lambda *_, **__: solved(next(counts)))
    key = "bimorph.length"
    with pytest.raises(InputError, match="changes how many values f has by tmm"):
        derivatives(scene, lambda *_: scene, "tmm", ["f"], [key], lambda _: None)


def test_without_a_model_the_scene_says_which_actuator(capsys):
    assert cli.main(["sensitivity", "reluctance", "--key", "gap"]) == 0
    out = capsys.readouterr().out
    assert "magnetic" in out
    assert "network: central differences" in out


def test_an_extrapolated_difference_knows_its_truncation():
    at = 0.7 + 0.05 * np.array([0.0, 1.0, -1.0, 0.5, -0.5])
    slope, error = extrapolated(np.exp(3.0 * at), np.zeros(()), 0.05)
    off = abs(slope - 3.0 * np.exp(2.1))
    assert 0.0 < off <= error
    assert error < 1e-2 * slope


def test_scatter_of_the_values_is_in_the_error_of_a_derivative():
    """Of values that are off at random nineteen in twenty slopes are within their errors."""
    random, inside = np.random.default_rng(3), 0
    at = 0.01 * np.array([0.0, 1.0, -1.0, 0.5, -0.5])
    for _ in range(400):
        slope, error = extrapolated(2.0 * at + 1e-4 * random.normal(size=5), np.zeros(()), 0.01)
        inside += abs(slope - 2.0) <= error
    assert inside >= 0.95 * 400


def test_keys_next_to_whose_values_nothing_fits_are_left_out_and_named():
    """Of all that a model reads; nothing is said where all can be varied."""
    scene, _ = load_scene("prototype", ["models=lumped", "quantities=static_tip_displacement"])
    every, said = readable_keys(scene, lambda key, value: None, "lumped")
    assert said == ""
    assert {"bimorph.length", "bimorph.piezo_thickness", "piezo.d31"} <= set(every)
    assert not {"modes", "frequency", "mesh.level", "coil.turns"} & set(every)

    def changed(key, value):
        if key == "bimorph.length" and value > scene.bimorph.length:
            raise InputError("too long")

    some, said = readable_keys(scene, changed, "lumped")
    assert some == [key for key in every if key != "bimorph.length"]
    assert said.startswith("left out of the parameters by lumped, ")
    assert said.endswith(": bimorph.length")
