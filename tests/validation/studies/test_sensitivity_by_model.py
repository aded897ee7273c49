"""Derivatives by models other than tmm: exact ones against differences, and physics' identities."""

import json
from types import SimpleNamespace

import numpy as np
import pytest

from tactgen.geometry.bimorph.bimorph_bricks import BrickMeshing
from tactgen.geometry.errors import InputError
from tactgen.tmm.reluctance.circuit import CELLS, FULL, circuit
from tactgen.tmm.reluctance.flux_ladder import solve as solve_ladder
from tactgen.validation.command_line import cli
from tactgen.validation.engine import derivatives as engine
from tactgen.validation.engine.derivatives import by_differences, derivatives, extrapolated
from tactgen.validation.engine.solve import solve
from tactgen.validation.models.bimorph import solid
from tactgen.validation.models.bimorph.family import derivatives as of_solid
from tactgen.validation.scene.nearby import value_of
from tactgen.validation.scene.scene import load_scene
from tactgen.validation.studies.sensitivity import changed_scenes, readable_keys

QUICK = (
    BrickMeshing((2, 2, 2), smallest=1.0, tip=1.0, longest=20.0, pieces=(2.0, 4.0)),
    BrickMeshing((2, 2, 3), smallest=0.5, tip=1.0, longest=20.0, pieces=(2.0, 4.0)),
)
PROTOTYPE = ["mesh.level=2", "accuracy=1e-4", "modes=1", "frequency=300"]


def asked(name, sets, model, quantities, keys):
    scene, _ = load_scene(name, sets)
    return derivatives(scene, changed_scenes(name, sets), model, quantities, keys)


KEYS = ("bimorph.piezo_thickness", "support.lateral_stiffness", "bimorph.length", "piezo.eps33")
HELD = ["models=solid", *PROTOTYPE, "support.lateral_stiffness=30 N/mm"]
NAMES = ("short_circuit_frequencies", "coupling_factor", "static_tip_displacement",
         "capacitance_free", "tip_displacement")  # fmt: skip


@pytest.fixture(scope="module")
def by_solid(tmp_path_factory):
    """Return exact derivatives of the solid on coarse bricks, and keep the bricks coarse.

    With a store of its own, whose keys do not know how coarse they are.
    """
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("TACTGEN_CACHE", str(tmp_path_factory.mktemp("coarse")))
        for module in (solid, of_solid):
            patch.setattr(module, "LEVELS", QUICK)
        yield asked("prototype", HELD, "solid", NAMES, KEYS)


@pytest.mark.parametrize(
    "key", [*KEYS[:2], *(pytest.param(key, marks=pytest.mark.heavy) for key in KEYS[2:])]
)
def test_the_solids_derivatives_are_those_of_whole_solutions(key, by_solid):
    """On bricks that only stretch, single answers next to the scene differ by nothing else."""
    scene, _ = load_scene("prototype", HELD)
    value, changed = value_of(scene, key), changed_scenes("prototype", HELD)
    ends = [
        solve(changed(key, value * (1.0 + share)), ("solid",), NAMES) for share in (1e-3, -1e-3)
    ]
    for derivative in by_solid:
        name = derivative.quantity.name
        high, low = (end.get(name, "solid").value for end in ends)
        slope = (high - low) / (2e-3 * value)
        size = np.abs(derivative.quantity.value) / value
        # differences at a thousandth: truncation 1e-6, rounding of frequencies 2e-7 over it
        assert (np.abs(derivative.slopes[key] - slope) <= 3e-4 * size).all(), name


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
        # the slope is of a finer ladder than the value
        assert abs(slope - exact) <= min(bar + of.quantity.error, 2e-3 * abs(exact))


NETWORK = ("magnetic_force", "flux_linkage", "inductance")


def test_a_key_that_changes_how_many_values_there_are_is_refused(monkeypatch):
    """As resonances that come and go: there is no difference to take."""
    scene, _ = load_scene("paper", [])

    def solved(count):
        answer = SimpleNamespace(name="f", value=np.ones(count), error=np.zeros(count))
        return SimpleNamespace(get=lambda *_: answer)

    monkeypatch.setattr(engine, "solve", lambda *_: solved(2))
    near = iter([2, 2, 2, 3])
    monkeypatch.setattr(engine, "_solved", lambda *_: solved(next(near)))
    key = "bimorph.length"
    with pytest.raises(InputError, match="changes how many values f has by tmm"):
        by_differences(scene, lambda *_: scene, "tmm", ["f"], [key], lambda _: None)


@pytest.mark.parametrize(
    "key", [*(pytest.param(key, marks=pytest.mark.heavy) for key in ("gap", "coil.turns")),
            "coil.current"]
)  # fmt: skip
def test_the_networks_bars_cover_a_finer_ladder_and_are_narrow(key):
    """Against 16 times the cells; and a tenth of what independent errors would leave open."""
    sets = ["models=network"]
    scene, _ = load_scene("reluctance", sets)
    changed, value = changed_scenes("reluctance", sets), value_of(scene, key)
    wide = by_differences(scene, changed, "network", NETWORK, [key], lambda _: None)
    ends = []
    for sign in (1.0, -1.0):
        near = changed(key, value * (1.0 + 1e-3 * sign))
        at = np.array([near.coil.current]), np.array([near.gap])
        ladder = solve_ladder(circuit(near.device, at[1], FULL, 16 * CELLS), at[0])
        force, linkage = float(ladder.force[0, 0]), float(ladder.flux_linkage[0, 0])
        ends.append((force, linkage, linkage / near.coil.current))
    slopes = {
        name: (high - low) / (2e-3 * value) for name, high, low in zip(NETWORK, *ends, strict=True)
    }
    for found, other in zip(
        asked("reluctance", sets, "network", NETWORK, [key]), wide, strict=True
    ):
        name = found.quantity.name
        slope, bar = found.slopes[key], found.bars[key]
        # the other ladder's difference is right to a millionth, its square of a thousandth
        assert abs(slope - slopes[name]) <= bar + 1e-5 * abs(slope), name
        assert bar <= 0.1 * other.bars[key], name


def test_without_a_model_the_scene_says_which_actuator(capsys):
    assert cli.main(["sensitivity", "reluctance", "--key", "gap"]) == 0
    out = capsys.readouterr().out
    assert "magnetic" in out
    assert "network: central differences" in out


def test_an_extrapolated_difference_knows_its_truncation():
    at = 0.7 + 0.05 * np.array([1.0, -1.0, 0.5, -0.5])
    slope, truncated = extrapolated(np.exp(3.0 * at), 0.05)
    off = abs(slope - 3.0 * np.exp(2.1))
    assert 0.0 < off <= truncated
    assert truncated < 2e-3 * slope


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
