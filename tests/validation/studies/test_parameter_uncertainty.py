"""Ranges of the parameters, what they do to the headline numbers, and how that is shown."""

import numpy as np
import pytest

from tactgen.geometry.device import parameters as p
from tactgen.geometry.device.material_library import LIBRARY
from tactgen.geometry.device.materials import PRINTED
from tactgen.geometry.units import Unit
from tactgen.validation.command_line.cli import main
from tactgen.validation.engine.solve import solve
from tactgen.validation.scene.load import load_scene
from tactgen.validation.scene.variation import with_values
from tactgen.validation.studies import parameter_uncertainty as study
from tactgen.validation.studies.parameter_uncertainty import (
    SampledNumbers,
    left_out,
    parameter_uncertainty,
    range_text,
    targets,
    uncertain_parameters,
    values_and_errors,
)

GROUPS = [
    group
    for group in vars(p).values()
    if isinstance(group, type)
    and issubclass(group, p.Parameters)
    and group not in (p.Parameters, p.Device)
]


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


def test_printed_digits_are_half_a_unit():
    """h_p is printed as 0.26 mm and c_s as 0.24 Nm."""
    printed = p.spreads(p.Bimorph())["piezo_thickness"]
    assert printed[:2] == pytest.approx((0.255e-3, 0.265e-3))
    assert printed[2:] == (PRINTED, True)
    assert p.spreads(p.Support())["rotational_stiffness"][:2] == pytest.approx((0.235, 0.245))


def test_own_values_have_the_range_of_their_kind():
    """Somebody else's number is not known to the paper's digits; the reason says it is assumed."""
    own = p.spreads(p.Piezo(density=3950.0, d31=-770e-12))
    assert own["d31"][:2] == pytest.approx((-1.2 * 770e-12, -0.8 * 770e-12))
    assert own["density"].low == pytest.approx(0.98 * 3950.0)
    layer = p.spreads(p.Bimorph(piezo_thickness=0.2e-3))["piezo_thickness"]
    assert (layer.low, layer.high) == pytest.approx((0.19e-3, 0.21e-3))
    assert layer.reason == "assumed: layer thickness ± 5 %"
    assert layer.whose == "assumed"


def test_own_values_of_other_kinds_keep_the_range_as_it_is_meant():
    """A range of a reconstruction goes in proportion; a tolerance of cutting stays an amount.

    But 0.1 mm would make a length of 50 um negative; the reason says so.
    """
    assert p.spreads(p.Bimorph(length=14e-3))["length"][:2] == pytest.approx((13.9e-3, 14.1e-3))
    assert p.spreads(p.Rod(radius=1.24e-3))["radius"][:2] == pytest.approx((1.116e-3, 1.364e-3))
    spread = p.spreads(p.Bimorph(length=50e-6))["length"]
    assert spread[:2] == pytest.approx((0.995 * 50e-6, 1.005 * 50e-6))
    assert "in proportion" in spread.reason


@pytest.mark.parametrize("name", LIBRARY)
def test_every_ceramic_has_ranges(name):
    """A published material is known as makers vouch for it, and no better."""
    found = p.spreads(p.Piezo(material=name))
    assert set(found) == set(LIBRARY[name].reduced())
    for key, value in LIBRARY[name].reduced().items():
        assert found[key].low < value < found[key].high


def test_ranges_of_the_models_parameters_only():
    """All of the paper's but the voltage; the rod's with the rod."""
    found = uncertain_parameters(load_scene("paper")[0])
    assert "drive.voltage" not in found
    assert range_text("bimorph.width", found["bimorph.width"]) == "2.05 to 2.15 mm"
    assert found["bimorph.width"].whose == "printed"
    assert found["piezo.eps33"].whose == "tables"
    with_rod = uncertain_parameters(load_scene("bimorph_on_rod")[0])
    assert {"rod.radius", "glue.youngs_modulus"} <= with_rod.keys()


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


def test_stated_tolerances_come_first():
    """Before the range of a kind; what tmm does not read is named."""
    stated = ["bimorph.shim_thickness=0.25 ± 0.04 mm", "coil.turns=560 ± 5", "gap=0.2 ± 0.01 mm"]
    scene, _ = load_scene("prototype", stated)
    found = uncertain_parameters(scene)
    assert found["bimorph.shim_thickness"].reason == "stated: ± 0.04 mm"
    thickness = found["bimorph.shim_thickness"]
    assert range_text("bimorph.shim_thickness", thickness) == "0.21 to 0.29 mm"
    assert found["bimorph.width"].whose == "printed"
    assert "coil.turns" not in found
    omitted = left_out(scene)
    assert "gap" in omitted
    assert "coil.turns" in omitted


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
    assert "…" not in out.replace(" … ", "")
    assert "16.719 nF" in out
    assert "ill-conditioned" in out
