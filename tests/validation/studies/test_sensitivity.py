"""Derivatives by any model, and what ranges of the parameters do to the headline numbers."""

import json
from types import SimpleNamespace

import numpy as np
import pytest

from tactgen.geometry.device import parameters as p
from tactgen.geometry.device.materials import PRINTED
from tactgen.geometry.errors import InputError
from tactgen.geometry.units import Unit
from tactgen.validation.command_line.cli import main
from tactgen.validation.engine import derivatives as engine
from tactgen.validation.engine.derivatives import derivatives, extrapolated
from tactgen.validation.engine.solve import solve
from tactgen.validation.scene.load import load_scene
from tactgen.validation.scene.variation import with_materials_as_keys, with_values
from tactgen.validation.studies import parameter_uncertainty as study
from tactgen.validation.studies import sensitivity
from tactgen.validation.studies.length_map import actuator, tip_slopes
from tactgen.validation.studies.parameter_uncertainty import (
    SampledNumbers,
    left_out,
    parameter_uncertainty,
    range_text,
    targets,
    uncertain_parameters,
    values_and_errors,
)
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
    for voltage, tip in zip(found, moved, strict=True):
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
        (slope, bar), exact = given.slopes[key], sign * of.quantity.value
        assert abs(slope - exact) <= bar + of.quantity.error
        assert abs(slope - exact) <= 5e-3 * abs(exact)


def test_a_key_that_changes_how_many_values_there_are_is_refused(monkeypatch):
    """As resonances that come and go: there is no difference to take."""
    scene, _ = load_scene("paper", [])

    counts = iter([2, 2, 2, 2, 3])

    def solved(*_, **__):
        ones = np.ones(next(counts))
        answer = SimpleNamespace(name="f", value=ones, error=0.0 * ones, extreme=None)
        return SimpleNamespace(get=lambda *_: answer)

    monkeypatch.setattr(engine, "solve", solved)
    with pytest.raises(InputError, match="changes how many values f has by tmm"):
        derivatives(scene, lambda *_: scene, "tmm", ["f"], ["bimorph.length"], lambda _: None)


def test_an_extrapolated_difference_knows_its_truncation_and_its_scatter():
    """Of values that are off at random nineteen in twenty slopes are within their errors."""
    steps = np.array([0.0, 1.0, -1.0, 0.5, -0.5])
    slope, error = extrapolated(np.exp(3.0 * (0.7 + 0.05 * steps)), np.zeros(()), 0.05)
    off = abs(slope - 3.0 * np.exp(2.1))
    assert 0.0 < off <= error
    assert error < 1e-2 * slope
    random, inside = np.random.default_rng(3), 0
    for _ in range(400):
        off = 1e-4 * random.normal(size=5)
        slope, error = extrapolated(0.02 * steps + off, np.zeros(()), 0.01)
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
        (["--key", "frequency"], "is a choice"),
        (["--key", "c_s"], 'did you mean "support.rotational_stiffness"'),
        (["--key", "bimorph.tab_length"], "is 0, and there is no percentage of 0"),
        (["--key", "shim.transverse_modulus"], "follows from others"),
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
    """At most eight columns for people, all in JSON."""
    arguments = ["sensitivity", "paper", "--frequency", "10:1000:20", "--key", "piezo.density",
                 "--quantity", "tip_displacement", "--quantity", "capacitance_free"]  # fmt: skip
    assert main(arguments) == 0
    assert "8 of 22 columns are shown" in capsys.readouterr().err
    assert main([*arguments, "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert len(found["sensitivities"]) == 22
    assert all(column["modelling_error"] > 0.0 for column in found["sensitivities"])
    last, key = found["sensitivities"][-1], "piezo.density"
    logarithmic = last["derivatives"][key] * 7900.0 / last["value"]
    assert logarithmic == pytest.approx(last["logarithmic"][key])
    assert found["ranges"][key]["low"] < 7900.0 < found["ranges"][key]["high"]
    # without a model the scene says which actuator
    assert main(["sensitivity", "reluctance", "--key", "gap"]) == 0
    assert "network: central differences" in capsys.readouterr().out


GROUPS = [
    group for group in vars(p).values()
    if isinstance(group, type) and issubclass(group, p.Parameters)
    and group not in (p.Parameters, p.Device)
]  # fmt: skip


@pytest.mark.parametrize("group", GROUPS)
def test_every_assumed_number_has_a_range(group):
    """What nobody vouches for has a range around its value, with a reason.

    Not so: what is assumed to be absent (0) or derived, and words.
    """
    made = group()
    sources, ranges = p.sources(made), p.spreads(made)
    for name, info in group.model_fields.items():
        number = any(isinstance(m, Unit) for m in info.metadata) and getattr(made, name)
        if number and sources[name].startswith("assumed"):
            assert name in ranges, name
    for name, spread in ranges.items():
        assert spread.low <= getattr(made, name) <= spread.high
        assert spread.low < spread.high
        assert spread.reason


def test_printed_and_own_values_have_the_range_that_is_meant():
    """Half a unit of a printed digit.  Somebody else's number is not known to the paper's digits; a
    range of a reconstruction goes in proportion, a tolerance of cutting stays an amount, unless it
    would make a length negative; the reason says so."""
    printed, own = p.spreads(p.Bimorph())["piezo_thickness"], p.Bimorph(piezo_thickness=0.2e-3)
    assert printed[2:] == (PRINTED, True)
    layer, short = p.spreads(own)["piezo_thickness"], p.spreads(p.Bimorph(length=50e-6))["length"]
    assert (layer.reason, layer.whose) == ("assumed: layer thickness ± 5 %", "assumed")
    assert "in proportion" in short.reason
    for spread, ends in (
        (printed, (0.255e-3, 0.265e-3)),
        (p.spreads(p.Support())["rotational_stiffness"], (0.235, 0.245)),
        (p.spreads(p.Piezo(d31=-770e-12))["d31"], (-924e-12, -616e-12)),
        (layer, (0.19e-3, 0.21e-3)),
        (p.spreads(p.Bimorph(length=14e-3))["length"], (13.9e-3, 14.1e-3)),
        (p.spreads(p.Rod(radius=1.24e-3))["radius"], (1.116e-3, 1.364e-3)),
        (short, (0.995 * 50e-6, 1.005 * 50e-6)),
    ):
        assert spread[:2] == pytest.approx(ends)


def test_ranges_of_the_models_parameters_only():
    """All of the paper's but the voltage; the rod's with the rod.  Stated tolerances come before
    the range of a kind; what tmm does not read is named."""
    found = uncertain_parameters(load_scene("paper")[0])
    assert "drive.voltage" not in found
    assert range_text("bimorph.width", found["bimorph.width"]) == "2.05 to 2.15 mm"
    assert [found[key].whose for key in ("bimorph.width", "piezo.eps33")] == ["printed", "tables"]
    with_rod = uncertain_parameters(load_scene("bimorph_on_rod")[0])
    assert {"rod.radius", "glue.youngs_modulus"} <= with_rod.keys()
    stated = ["bimorph.shim_thickness=0.25 ± 0.04 mm", "coil.turns=560 ± 5", "gap=0.2 ± 0.01 mm"]
    scene, _ = load_scene("prototype", stated)
    found, omitted = uncertain_parameters(scene), left_out(scene)
    thickness = found["bimorph.shim_thickness"]
    assert thickness.reason == "stated: ± 0.04 mm"
    assert range_text("bimorph.shim_thickness", thickness) == "0.21 to 0.29 mm"
    assert "coil.turns" not in found
    assert all(key in omitted for key in ("gap", "coil.turns"))


@pytest.fixture(scope="module")
def prototype():
    scene, _ = load_scene("prototype")
    return {row.target.label: row for row in parameter_uncertainty(scene, evaluations=1400)}


def test_headline_numbers(prototype):
    """A free tip has a peak; a loaded one a warning at 1 kHz; a loose one no statics."""
    assert "peak tip velocity" in prototype
    assert not any(row.target.ill_conditioned for row in prototype.values())
    paper = targets(load_scene("paper")[0])
    assert [t.frequency for t in paper if t.ill_conditioned] == [1000.0]
    loose = load_scene("paper", ["support.rotational_stiffness=0 N*m/rad"])[0]
    assert "static_tip_displacement" not in {t.quantity.name for t in targets(loose)}


def test_a_harvesters_numbers_are_peak_and_power():
    """The largest power of the band, which goes as the square of the acceleration."""
    scene, _ = load_scene("prototype", [
        "support.kind=clamped", "load.kind=mass", "load.mass=50 mg", "circuit.kind=load",
        "circuit.resistance=80 kohm ± 10 %", "drive.base_acceleration=1 g ± 3 %",
        "frequency=600:3000:9", "quantities=circuit_power",
    ])  # fmt: skip
    rows = {row.target.label: row for row in parameter_uncertainty(scene, evaluations=200)}
    power = rows["peak circuit power"]
    (found,) = solve(scene, ("tmm",), ("circuit_power",)).quantities
    assert power.value == pytest.approx(found.extreme.value, rel=1e-6)
    assert rows["peak frequency"].value == pytest.approx(found.extreme.frequency, rel=1e-6)
    acceleration = scene.drive.base_acceleration
    share = power.slopes["drive.base_acceleration"] * acceleration / power.value
    assert share == pytest.approx(2.0, rel=1e-6)
    circuits = (
        scene.circuit.model_copy(update={"resistance": by * scene.circuit.resistance})
        for by in (1.001, 0.999)
    )
    more, less = (
        solve(scene.model_copy(update={"circuit": circuit}), ("tmm",), ("circuit_power",))
        .quantities[0].extreme.value
        for circuit in circuits
    )  # fmt: skip
    slope = power.slopes["circuit.resistance"] * scene.circuit.resistance
    assert slope == pytest.approx((more - less) / 0.002, rel=1e-3)


def test_first_order_and_samples_agree(prototype):
    """Within these ranges all headline numbers are close to linear.

    Scatter within 12.5 %: two standard deviations, 2/√(2n), of what is estimated from
    n = 128 samples.
    """
    for label, row in prototype.items():
        assert row.sampled / row.standard == pytest.approx(1.0, abs=0.125), label
        # 95 % of a sum of uniform ranges lie within 1.7 (one range) to 2 (many) deviations
        assert 1.4 < (row.high - row.low) / (2 * row.standard) < 2.2, label
        assert row.standard < row.worst
        assert row.numerical < 1e-9 * row.value
        assert row.low < row.value < row.high


def test_sobol_indices_are_the_shares_of_first_order(prototype):
    """For a nearly linear number each total index is that parameter's share of the variance."""
    row = prototype["static tip displacement"]
    scene, _ = load_scene("prototype")
    shares = {
        key: (row.slopes[key] * (spread.high - spread.low)) ** 2 / 12 / row.standard**2
        for key, spread in uncertain_parameters(scene).items()
    }
    assert sum(shares.values()) == pytest.approx(1.0)
    for key, share in shares.items():
        index, bar = row.total[key]
        # the stated 95 % interval of the estimate, and 3 % of interaction at most
        assert abs(index - share) < bar + 0.03, key
    assert row.contributors[0][0] == "bimorph.piezo_thickness"


def test_the_study_is_repeatable(monkeypatch):
    """Seeded: twice the same numbers, to the last digit."""
    monkeypatch.setattr(study, "targets", lambda scene: targets(scene)[:2])
    scene, _ = load_scene("prototype")
    one, two = (parameter_uncertainty(scene, evaluations=30) for _ in range(2))
    assert [(r.low, r.high, r.total) for r in one] == [(r.low, r.high, r.total) for r in two]


def test_sampled_numbers_are_those_of_solve():
    """At one changed point the samples equal what any other answer would say."""
    scene, _ = load_scene("paper", ["piezo.density=7700kg/m^3", "bimorph.width=2.05mm"])
    points = {"piezo.density": np.full(2, 7700.0), "bimorph.width": np.full(2, 2.05e-3)}
    sampled = SampledNumbers(load_scene("paper")[0], points)
    for target, value, _ in values_and_errors(scene, targets(scene)):
        # the coupling factor takes the difference of two nearly equal frequencies
        assert sampled.of(target)[1] == pytest.approx(value, rel=1e-9), target


def test_slopes_of_the_peak(prototype):
    """Height and frequency of the peak move as those of other devices do."""
    scene, _ = load_scene("prototype")
    key, step = "support.rotational_stiffness", 1e-3
    ends = [
        {target: value for target, value, _ in values_and_errors(moved, targets(moved))}
        for moved in (with_values(scene, {key: 0.24 * (1.0 + sign * step)}) for sign in (1, -1))
    ]
    for label in ("peak frequency", "peak tip velocity"):
        row = prototype[label]
        slope = (ends[0][row.target] - ends[1][row.target]) / (2 * step * 0.24)
        assert row.slopes[key] == pytest.approx(slope, rel=1e-3), label


def test_constants_of_listed_materials_have_their_ranges():
    """As piezo and shim, in whose place the scene's own have no effect; of a second ceramic none
    are varied, which is said.  The numbers do not move."""
    one, other = (
        load_scene("prototype", [f"bimorph.layers={layers}", *more])[0]
        for layers, more in (
            ("brass 0.2 mm; PZT-5A 0.3 mm +x", []),
            ("shim 0.2 mm; piezo 0.3 mm +x", ["shim.material=brass", "piezo.material=PZT-5A"]),
        )
    )
    assert uncertain_parameters(one) == uncertain_parameters(other)
    assert "piezo.d31" in uncertain_parameters(one)
    assert left_out(one) == ""
    values = (list(values_and_errors(of, targets(of))) for of in (one, with_materials_as_keys(one)))
    assert next(values) == next(values)
    two, _ = load_scene("prototype", ["bimorph.layers=PZT-5A 0.3 mm -x; PZT-4 0.3 mm +x"])
    assert "constants of PZT-4 (of a second material" in left_out(two)


@pytest.mark.heavy
def test_what_samples_leave_out_is_said():
    scene, _ = load_scene("paper", ["bimorph.width_profile=0 mm: 2.1 mm, 20 mm: 1 mm"])
    for key in ("bimorph.length", "bimorph.width_profile"):
        assert key in left_out(scene)
    assert "rod.length" in left_out(load_scene("bimorph_on_rod")[0])
    assert left_out(load_scene("paper")[0]) == ""
    contact, _ = load_scene("generator")
    assert "contact.decay_length" in left_out(contact)
    assert "contact.shape" not in left_out(contact)  # a choice is no number
    known = uncertain_parameters(contact)
    assert "bimorph.length" in known
    assert not any(key.startswith("support.") for key in known)


def test_command_has_both_tables(monkeypatch, capsys):
    monkeypatch.setattr(study, "_EVALUATIONS", 64)
    asked = ["--quantity", "capacitance_free", "--key", "piezo.eps33", "--sobol"]
    assert main(["sensitivity", "paper", *asked]) == 0
    out = capsys.readouterr().out
    assert "16.719 nF" in out
    assert "ill-conditioned" in out
