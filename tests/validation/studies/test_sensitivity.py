"""Derivatives by any model: published numbers, exact laws, identities of physics, error bars."""

import json
from types import SimpleNamespace

import numpy as np
import pytest

from tactgen.geometry.errors import InputError
from tactgen.validation.command_line.cli import main
from tactgen.validation.engine import derivatives as engine
from tactgen.validation.engine.derivatives import derivatives, extrapolated
from tactgen.validation.engine.solve import solve
from tactgen.validation.scene.load import load_scene
from tactgen.validation.studies import sensitivity
from tactgen.validation.studies.length_map import actuator, tip_slopes
from tactgen.validation.studies.sensitivity import all_columns, changed_scenes, readable_keys


def columns(name, quantities, *sets, model="tmm", keys=None):
    """Columns of sensitivities; the scene's own frequencies unless `sets` has others."""
    overrides = [f"models={model}", f"quantities={quantities}", *sets]
    scene, _ = load_scene(name, overrides)
    return all_columns(scene, changed_scenes(name, overrides), keys)[0]


def refused(capsys, *arguments):
    assert main(["sensitivity", *arguments]) == 2
    return capsys.readouterr().err


@pytest.mark.heavy
def test_published_sensitivities_of_the_first_frequency():
    """At 14 mm density and c_s rule; two digits are stated: half a unit of the second."""
    (column,) = columns("prototype", "short_circuit_frequencies", "modes=1")
    found = column.logarithmic
    assert found["piezo.density"] == pytest.approx(-0.46, abs=0.005)
    assert found["support.rotational_stiffness"] == pytest.approx(0.43, abs=0.005)
    assert found["piezo.s11"] == pytest.approx(-0.061, abs=5e-4)
    assert found["shim.density"] == pytest.approx(-0.042, abs=5e-4)
    for key in ("piezo.eps33", "piezo.quality_factor", "piezo.loss_tangent", "shim.shear_modulus",
                "beam.shear_correction"):  # fmt: skip
        assert abs(found[key]) < 0.01


def test_published_sensitivities_of_peak_and_minimum():
    """Peak velocity at 14 mm by d_s and c_s; the loaded 20 mm actuator at 1 kHz by c_s and ρ_p."""
    keys = ["support.rotational_damping", "support.rotational_stiffness", "piezo.density"]
    (peak,) = columns("prototype", "tip_velocity", "frequency=781.609", keys=keys)
    assert peak.logarithmic[keys[0]] == pytest.approx(-0.96, abs=0.005)
    assert peak.logarithmic[keys[1]] == pytest.approx(1.1, abs=0.05)
    slopes = tip_slopes(actuator(load_scene("paper")[0]), keys, 1000.0)
    assert slopes["support.rotational_stiffness"] == pytest.approx(-4.1, abs=0.05)
    assert slopes["piezo.density"] == pytest.approx(4.6, abs=0.05)
    (dip,) = columns("paper", "tip_displacement", "frequency=1000", keys=keys)
    for key in keys:
        assert dip.logarithmic[key] == pytest.approx(slopes[key], abs=dip.bars[key] + 1e-7)


def test_exact_laws_within_the_bars():
    """Static deflection goes as l², motion as the voltage; f of a clamped beam as 1/√density."""
    # shear does not bend a beam under pure moment, and the springs carry no force
    laws = {"bimorph.length": 2.0, "beam.shear_correction": 0.0, "drive.voltage": 1.0}
    (static,) = columns("paper", "static_tip_displacement", keys=[*laws])
    for key, exact in laws.items():
        assert static.logarithmic[key] == pytest.approx(exact, abs=1e-9)
        assert static.bars[key] < 1e-6
    (mode,) = columns("prototype", "short_circuit_frequencies", "support.kind=clamped", "modes=1",
                      keys=["piezo.density", "shim.density"])  # fmt: skip
    densities = mode.logarithmic["piezo.density"] + mode.logarithmic["shim.density"]
    assert abs(densities + 0.5) <= mode.bars["piezo.density"] + mode.bars["shim.density"]


def test_peaks_of_a_sweep_have_sensitivities_of_their_own():
    """Mean power goes as the base's acceleration squared, the frequency stays; as two peaks say."""
    sets = ["support.kind=clamped", "load.kind=none", "drive.voltage=0 V", "circuit.kind=load",
            "circuit.resistance=20 kohm", "frequency=1700:2600:9"]  # fmt: skip
    keys, moved = ["drive.base_acceleration", "bimorph.length"], "bimorph.length={} mm"
    *at, peak = columns(
        "prototype", "circuit_power", *sets, "drive.base_acceleration=1 g", keys=keys
    )
    assert (peak.extreme, {column.extreme for column in at}) == ("largest", {""})
    assert peak.label.endswith(f"largest {peak.frequency:.4g} Hz")
    assert peak.value > max(column.value for column in at)
    assert peak.logarithmic[keys[0]] == pytest.approx(2.0, abs=1e-6)
    length = load_scene("prototype")[0].bimorph.length
    less, more = (
        solve(load_scene("prototype", [*sets, "drive.base_acceleration=1 g",
              moved.format(1e3 * length * by)])[0], ("tmm",), ("circuit_power",)).quantities[0]
        for by in (0.999, 1.001)
    )  # fmt: skip
    slope = np.log(more.extreme.value / less.extreme.value) / np.log(1.001 / 0.999)
    assert peak.logarithmic[keys[1]] == pytest.approx(slope, rel=1e-4)  # its truncation: 1e-6


def test_threshold_voltage_falls_as_the_displacement_rises():
    """Columns only where the threshold is stated, up to 1 kHz."""
    keys = ["bimorph.length", "piezo.d31"]
    found = columns("paper", "threshold_voltage", "frequency=10,100,2000", keys=keys)
    moved = columns("paper", "tip_displacement", "frequency=10,100", keys=keys)
    assert [c.frequency for c in found] == [10.0, 100.0]
    scene, _ = load_scene("paper", ["frequency=10,100"])
    values = solve(scene, ("tmm",), ("threshold_voltage",)).quantities[0].value
    for voltage, tip, value in zip(found, moved, values, strict=True):
        assert voltage.value == pytest.approx(value, rel=1e-12)
        for key in keys:
            bar = voltage.bars[key] + tip.bars[key]
            assert abs(voltage.logarithmic[key] + tip.logarithmic[key]) <= bar + 1e-12


def test_beam_elements_and_transfer_matrices_have_the_same_derivatives():
    key = "bimorph.length"
    one, other = columns(
        "prototype", "short_circuit_frequencies", "modes=1", model="tmm,beam", keys=[key]
    )
    assert (one.model, other.model) == ("tmm", "beam")
    assert abs(one.logarithmic[key] - other.logarithmic[key]) <= one.bars[key] + other.bars[key]
    assert other.bars[key] < 1e-4


def test_one_co_energy_map_gives_force_and_inductance():
    """∂W'/∂g is minus the pull, ∂²W'/∂i² the incremental inductance."""
    names = ("coenergy", "flux_linkage", "magnetic_force", "incremental_inductance")
    scene, _ = load_scene("reluctance", ["models=network"])
    changed = changed_scenes("reluctance", ["models=network"])
    found = derivatives(scene, changed, "network", names, ["gap", "coil.current"])
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
        answer = SimpleNamespace(
            name="f", value=np.ones(count), error=np.zeros(count), extreme=None
        )
        return SimpleNamespace(get=lambda *_: answer)

    counts = iter([2, 2, 2, 2, 3])
    monkeypatch.setattr(engine, "solve", lambda *_, **__: solved(next(counts)))
    with pytest.raises(InputError, match="changes how many values f has by tmm"):
        derivatives(scene, lambda *_: scene, "tmm", ["f"], ["bimorph.length"], lambda _: None)


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


def test_keys_next_to_whose_values_nothing_fits_are_left_out_and_named(monkeypatch):
    """Of all that a model reads; nothing is said where all can be varied."""
    scene, _ = load_scene("prototype", ["models=lumped", "quantities=static_tip_displacement"])

    def changed(key, value):
        if key == "bimorph.length" and value > scene.bimorph.length:
            raise InputError("too long")

    some, said = readable_keys(scene, changed, "lumped")
    assert {"bimorph.width", "bimorph.piezo_thickness", "piezo.d31"} <= set(some)
    assert not {"bimorph.length", "modes", "frequency", "mesh.level", "coil.turns"} & set(some)
    assert "bimorph.length" in said
    few = ["bimorph.length", "bimorph.width", "coil.turns"]
    monkeypatch.setattr(sensitivity, "number_keys", lambda _: few)
    assert readable_keys(scene, lambda key, value: None, "lumped") == (few[:2], "")


CONTACT = ("--set", "support.kind=contact")
FREE, WIDTH = ("--set", "load.kind=none"), ("--key", "bimorph.width")
#: Width that falls along the ceramic.
TAPER = ("--set", "bimorph.width_profile=0 mm: 2.1 mm, 20 mm: 1 mm")


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["--key", "coil.turns"], "coil.turns"),
        (["--key", "frequency"], "is a choice"),
        (["--key", "c_s"], 'did you mean "support.rotational_stiffness"'),
        (["--key", "bimorph.tab_length"], "is 0, and there is no percentage of 0"),
        (["--key", "shim.transverse_modulus"], "follows from others"),
        (["--key", "load.mass"], 'has no effect with load.kind = "finger"'),
        ([*CONTACT, "--key", "support.rotational_stiffness"], 'with support.kind = "contact"'),
        ([*WIDTH, *TAPER], "with bimorph.width_profile, which gives it"),
        (["--key", "bimorph.length", *TAPER], "cannot be varied: next to its value"),
        (["--key", "bimorph.width_profile", *TAPER], "is a profile, whose points"),
        (["--model", "beam", "--key", "coil.turns"], "has no effect with models = beam"),
        (["--quantity", "threshold_voltage", "--set", "piezo.d31=0 pC/N", *WIDTH], "piezo.d31"),
        (["--quantity", "dynamic_stiffness"], "is a matrix"),
        (["--quantity", "tip_velocity", "--frequency", "5000"], "10 to 1000 Hz"),
        (["--quantity", "tip_velocity", "--frequency", "0", *FREE, *WIDTH], "is 0"),
    ],
)
def test_what_has_no_sensitivity_is_refused_in_one_sentence(arguments, words, capsys):
    error = refused(capsys, "paper", *arguments)
    assert words in error
    assert error.count("\n") == 1


def test_tables_for_people_and_json(capsys):
    """At most eight columns for people, all in JSON; no digit cut off however narrow."""
    arguments = ["sensitivity", "paper", "--frequency", "10:1000:20", "--key", "piezo.density",
                 "--quantity", "tip_displacement", "--quantity", "capacitance_free"]  # fmt: skip
    assert main(arguments) == 0
    out, err = capsys.readouterr()
    assert max(map(len, out.splitlines())) < 160
    assert "1000 Hz" in out
    assert "modelling" in out
    assert "8 of 22 columns are shown" in err
    assert main([*arguments, "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert len(found["sensitivities"]) == 22
    assert all(column["modelling_error"] > 0.0 for column in found["sensitivities"])
    last, key = found["sensitivities"][-1], "piezo.density"
    assert last["derivatives"][key] * 7900.0 / last["value"] == pytest.approx(
        last["logarithmic"][key]
    )
    assert found["ranges"][key]["low"] < 7900.0 < found["ranges"][key]["high"]


def test_without_a_model_the_scene_says_which_actuator(capsys):
    assert main(["sensitivity", "reluctance", "--key", "gap"]) == 0
    out = capsys.readouterr().out
    assert "magnetic" in out
    assert "network: central differences" in out
