"""Support identification: what is recovered, an honest word on the rest, the fit's numerics."""

import re
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pytest

from tactgen.geometry.errors import InputError
from tactgen.validation.catalogue.quantities import measurable
from tactgen.validation.engine.solve import solve
from tactgen.validation.scene.load import FILE_KEYS, load_scene
from tactgen.validation.scene.variation import value_of, with_values
from tactgen.validation.studies.curve_fit import CurveModel, Fit, Misfit, starts
from tactgen.validation.studies.identify import fit_parameter, identify
from tactgen.validation.studies.identify_output import file_from
from tactgen.validation.studies.measured_data import MeasuredCurve

PROTOTYPE, ORIGINS = load_scene("prototype")
TRUTH = {"c_s": 0.24, "d_s": 4.46e-6, "c_sl": 3e6, "theta": 1e-12, "rho_p": 7900.0}
FREQUENCIES = np.linspace(10.0, 2000.0, 60)
#: The rod held down, the tip free.
HELD = ("load.kind=none", "coil.current=50mA", "coil.history=falling")
#: A factor 10 from the truth, to either side.
FAR = ("c_s=2.4 N*m/rad", "d_s=4.46e-7 N*m*s/rad")


def synthetic(
    seed=0, level=0.02, *, phase=True, noise="relative", scene=PROTOTYPE, kind="velocity",
    frequencies=FREQUENCIES,
):  # fmt: skip
    """Return a curve of the model with Gaussian noise, `level` of each value or of the largest."""
    exact = CurveModel(scene, measurable()[kind].name, frequencies, ())(np.zeros(0))
    exact = exact if phase else np.abs(exact)
    rng = np.random.default_rng(seed)
    errors = rng.standard_normal(exact.shape)
    if phase:
        errors = errors + 1j * rng.standard_normal(exact.shape)
    size = exact if noise == "relative" else np.abs(exact).max()
    values = exact + level * size * errors
    values = values if phase else np.abs(values)
    return MeasuredCurve("synthetic", kind, frequencies, values, None, np.ones(frequencies.shape))


def covered(count, fit=("c_s", "d_s"), **options):
    """Return how many of `count` seeds have each true parameter in its own interval."""
    hits = dict.fromkeys(fit, 0)
    for seed in range(count):
        found = identify(PROTOTYPE, synthetic(seed, **options), fit)
        for name in fit:
            low, high = found.get(name).interval
            hits[name] += bool(low <= TRUTH[name] <= high)
    return hits


def test_model_is_that_of_solve():
    """The fit's direct evaluation gives the very numbers of tactgen solve; of a coil's impedance
    to rounding, and it follows the lead's resistance."""
    for wiring in ("parallel", "series"):
        scene, _ = load_scene(
            "prototype", [f"bimorph.wiring={wiring}", "frequency=10,781,2000", "drive.voltage=3V"]
        )
        for quantity in (row.name for row in measurable().values() if row.actuator == "bimorph"):
            expected = solve(scene, ["tmm"], [quantity]).get(quantity, "tmm").value
            model = CurveModel(scene, quantity, np.array(scene.frequency), ())
            np.testing.assert_allclose(model(np.zeros(0)), expected, rtol=1e-12)
    scene, _ = load_scene("generator", [*HELD, "frequency=10,300,2000"])
    exact = solve(scene, ("tmm",), ("coil_impedance",)).get("coil_impedance", "tmm").value
    key = "coil.source_resistance"
    model = CurveModel(scene, "coil_impedance", np.array(scene.frequency), (key,))
    here, more = (model(np.array([value_of(scene, key) + by])) for by in (0.0, 20.0))
    np.testing.assert_allclose(here, exact, rtol=1e-12)
    np.testing.assert_allclose(more - here, 20.0, rtol=1e-9)


@pytest.mark.parametrize(
    ("phase", "factor"),
    [(True, 0.1), (False, 10.0),
     *(pytest.param(p, f, marks=pytest.mark.heavy) for p, f in ((True, 10.0), (False, 0.1)))],
)  # fmt: skip
def test_exact_data_are_recovered_from_far_starts(phase, factor):
    """Noise-free data give the parameters to 1e-6 from starts a factor 10 away, any direction."""
    for other in (0.1, 10.0):
        fit = (f"c_s={0.24 * factor} N*m/rad", f"d_s={4.46e-6 * other} N*m*s/rad")
        found = identify(PROTOTYPE, synthetic(level=0.0, phase=phase), fit)
        for name in ("c_s", "d_s"):
            assert found.get(name).value == pytest.approx(TRUTH[name], rel=1e-6)
        assert not found.warnings


@pytest.mark.heavy
@pytest.mark.parametrize(
    ("phase", "count", "least", "noise"),
    [
        (True, 12, 10, "relative"),
        *((p, 100, 90, n) for p in (True, False) for n in ("relative", "constant")),
    ],
)
def test_coverage(phase, count, least, noise):
    """2 % noise: each true value lies in its own interval in most seeds, which are fixed.

    At a true coverage of 95 % fewer than 10 of 12 has a chance of 2 %, fewer than 90 of 100 of
    1 %; of intervals half as wide (a coverage of 67 %) both parameters would pass with a chance
    of 4 % at 10 of 12, and of both kinds of curve with one of 0.1 %.
    """
    assert min(covered(count, phase=phase, noise=noise).values()) >= least


@pytest.mark.heavy
@pytest.mark.parametrize("phase", [True, False])
@pytest.mark.parametrize(
    "fit",
    [("c_s", "d_s", "c_sl", "theta"), ("c_s", "d_s", "c_sl"), ("c_s", "d_s", "rho_p")],
    ids="-".join,
)
def test_coverage_where_the_data_hardly_tell(fit, phase):
    """Also parameters that the curve hardly determines, and those they are confused with."""
    assert min(covered(100, fit, phase=phase).values()) >= 90


def test_a_far_start_ends_where_a_near_one_does():
    """Constant noise of 2 % of the peak, which is recognised, with its size."""
    data = synthetic(5, noise="constant")
    near, far = (identify(PROTOTYPE, data, fit) for fit in (("c_s", "d_s"), FAR))
    assert near.noise == far.noise == "constant"
    assert near.level == pytest.approx(0.02 * np.abs(near.fitted).max(), rel=0.26)
    for name in ("c_s", "d_s"):
        # the descent stops when the cost changes by less than 1e-13, quadratic in the values
        assert far.get(name).value == pytest.approx(near.get(name).value, rel=1e-5)


def test_one_length_is_found_where_a_sharp_peak_has_left_its_place():
    """The end of two patches, 8 % away, from magnitudes: minima of the misfit are 0.5 % wide."""
    layers = "PZT-5A 0.26 mm to 12 mm +x; brass 0.2 mm; PZT-5A 0.26 mm to 12 mm +x"
    stated = ["bimorph.length=30 mm", "bimorph.width=6 mm", f"bimorph.layers={layers}",
              "support.kind=clamped", "load.kind=mass", "load.mass=0.5 g"]  # fmt: skip
    both, frequencies = "bimorph.layers.1+3.end", np.linspace(60.0, 120.0, 60)
    truth, _ = load_scene("prototype", [*stated, f"{both}=13 mm"])
    curve = synthetic(level=0.0, phase=False, scene=truth, frequencies=frequencies)
    found = identify(load_scene("prototype", stated)[0], curve, (both,))
    assert found.estimates[0].value == pytest.approx(13e-3, rel=1e-6)


def test_nothing_beyond_the_bounds_is_tried():
    """Just below the lower one the place of measurement leaves the bimorph."""
    scene, _ = load_scene("prototype", ["measurement.below_tip=13.9 mm"])
    curve = synthetic(level=0.0, phase=False, scene=scene)
    found = identify(scene, curve, ("bimorph.length=14.1mm:14mm..20mm",))
    assert found.estimates[0].value == pytest.approx(14e-3, rel=1e-2)


def test_weights_are_inverse_variances():
    """Noise four times as large where the weight is 1/16: the level is that at the mean weight.

    Standard deviation of a level estimated from 120 residuals: 6.5 %; 4 of them.
    """
    data, calm = synthetic(3, 0.0), synthetic(3)
    rough = np.arange(60) % 2 == 1
    values = data.values + np.where(rough, 4.0, 1.0) * (calm.values - data.values)
    weight = np.where(rough, 1.0 / 16.0, 1.0)
    found = identify(PROTOTYPE, replace(data, values=values, weight=weight), noise="relative")
    # residuals are 2 % at weight 1, and so 2 % / sqrt(mean weight) at weight = mean weight
    assert found.level * np.sqrt(weight.mean()) == pytest.approx(0.02, rel=0.26)


@pytest.mark.parametrize("level", [0.0, pytest.param(0.02, marks=pytest.mark.heavy)])
def test_voltage_and_piezoelectric_constant_cannot_be_told_apart(level):
    """Only their product acts: said so wherever the fit ends, and no slope is made of rounding."""
    data = synthetic(1, level)
    found = identify(PROTOTYPE, data, ("drive.voltage", "piezo.d31"), origins=ORIGINS)
    assert found.findings[0].startswith("drive.voltage and piezo.d31")
    assert "drive.voltage * piezo.d31" in found.findings[0]
    assert not any("where the data push it" in text for text in found.findings)
    alone = identify(PROTOTYPE, data, ("piezo.d31",))
    product = found.get("drive.voltage").value * found.get("piezo.d31").value
    # both have the optimum of one sum of squares; the drift of d31 to far values leaves some
    # 1e-3 of the electrical coupling's effect on the stiffness of the shunted ceramic
    assert product == pytest.approx(alone.get("piezo.d31").value, rel=5e-3)
    for assumption in found.assumptions:
        slopes = [s for s in assumption.slopes if not np.isnan(s)]
        assert max(map(abs, slopes), default=0.0) < 10.0


@pytest.mark.parametrize("phase", [True, pytest.param(False, marks=pytest.mark.heavy)])
def test_lateral_stiffness_and_inertia_are_not_identifiable(phase):
    """Below 2 kHz c_sl and theta are not determined, and the words say so."""
    found = identify(PROTOTYPE, synthetic(4, phase=phase), ("c_s", "d_s", "c_sl", "theta"))
    for name in ("c_sl", "theta"):
        assert found.get(name).half_width > np.log(2.0)
        assert any(text.startswith(name) and "not determined" in text for text in found.findings)
    assert found.get("c_s").half_width < 0.02


def test_assumed_density_shifts_the_stiffness():
    """The slope to the density is that of fits with the density 1 % up and down."""
    data = synthetic(1)
    found = identify(PROTOTYPE, data, origins=ORIGINS)
    (density,) = (a for a in found.assumptions if a.row.key == "piezo.density")
    up, down = (
        identify(with_values(PROTOTYPE, {"piezo.density": 7900.0 * (1.0 + d)}), data)
        for d in (0.01, -0.01)
    )
    for i, name in enumerate(("c_s", "d_s")):
        slope = np.log(up.get(name).value / down.get(name).value) / np.log(1.01 / 0.99)
        # the residuals' second derivatives, left out of the slope, are of the size of the noise
        assert density.slopes[i] == pytest.approx(slope, abs=0.05)
    # the frequency fixes c_s/rho_p, so the slope is near 1
    assert density.slopes[0] == pytest.approx(1.0, abs=0.1)
    assert "piezo.eps33" not in [a.row.key for a in found.assumptions]  # no effect on velocity


def test_any_scalar_of_the_model_can_be_fitted():
    """A negative one (d31), a length, and ceramic constants through the admittance."""
    found = identify(PROTOTYPE, synthetic(1), ("piezo.d31", "bimorph.length:10..20mm"))
    estimate = found.get("piezo.d31")
    assert estimate.interval[0] < estimate.value < estimate.interval[1] < 0.0
    assert estimate.value == pytest.approx(-385e-12, rel=0.02)
    assert found.get("bimorph.length").value == pytest.approx(14e-3, rel=0.01)
    found = identify(PROTOTYPE, synthetic(1, kind="admittance"), ("piezo.eps33=3000",))
    assert found.get("piezo.eps33").value == pytest.approx(6000.0, rel=0.02)


def test_data_of_another_sign_convention_or_uncertainty_are_doubted():
    """An uncertainty a quarter of the real one is contradicted by chi2, with the factor."""
    data = synthetic(1)
    for change, words in (
        ({"values": -data.values}, "opposite sign"),
        ({"values": data.values.conj()}, "opposite sign of the phase"),
        ({"error": 0.005 * np.abs(data.values)}, "times the stated uncertainty"),
    ):
        found = identify(PROTOTYPE, replace(data, **change))
        assert any(words in text for text in found.warnings)


@pytest.mark.parametrize(("phase", "factor"), [(True, 0.5), (False, 1e3)])
def test_a_wrong_drive_voltage_is_named_with_its_factor(phase, factor):
    """Support and voltage are then found from the same data, within their noise of 2 %."""
    data = synthetic(1, phase=phase)
    found = identify(PROTOTYPE, replace(data, values=factor * data.values))
    assert any("unexplained" in text for text in found.warnings)
    (told,) = (text for text in found.warnings if "drive.voltage = " in text)
    stated = re.search(r"drive\.voltage = (\S+) V", told)
    assert float(stated[1]) == pytest.approx(factor * PROTOTYPE.drive.voltage, rel=0.02)


def test_the_right_voltage_and_an_admittance_are_not_doubted():
    """Nor is a fit that is off for another reason: a support far too stiff."""
    assert not identify(PROTOTYPE, synthetic(1)).warnings
    curve = synthetic(1, kind="admittance")
    found = identify(PROTOTYPE, replace(curve, values=2.0 * curve.values))
    assert not any("drive.voltage = " in text for text in found.warnings)
    held = identify(PROTOTYPE, synthetic(1), ("c_s=3N*m/rad:2..5N*m/rad",))
    assert any("unexplained" in text for text in held.warnings)
    assert not any("drive.voltage = " in text for text in held.warnings)


@pytest.mark.parametrize(
    ("text", "start", "low", "high"),
    [
        ("c_s", 0.24, 0.0024, 24.0),
        ("support.rotational_stiffness = 0.2 N*m/rad", 0.2, 0.002, 20.0),
        ("piezo.d31:-200..-500pC/N", -385e-12, -200e-12, -500e-12),
        ("piezo.d31:-500..-200pC/N", -385e-12, -200e-12, -500e-12),
        ("rho_p", 7900.0, 79.0, 1e5),  # no denser than the scene allows
    ],
)
def test_fit_text(text, start, low, high):
    """Start and bounds as text with units; LOW takes the unit of HIGH."""
    parameter = fit_parameter(PROTOTYPE, text)
    assert (parameter.start, parameter.low, parameter.high) == pytest.approx((start, low, high))


@pytest.mark.parametrize(
    ("fit", "words"),
    [
        ("c_s:1..", ["NAME[=START][:LOW..HIGH]", "--fit c_s="]),
        ("c_s=0.2", ['"0.2" has no unit', "rotational stiffness"]),
        ("c_s:1..2N*m/rad", ["starts support.rotational_stiffness at 0.24", "outside its bounds"]),
        ("bimorph.wiring", ["bimorph.wiring is not a number"]),
        ("piezo.eps33", ["has no effect on the velocity"]),
        ("load.mass=1mg", ["load.mass", "has no effect with load.kind"]),
        ("coil.length", ["coil.length", "has no effect with models", "--set models=network"]),
    ],
)
def test_bad_fit_gives_one_sentence(fit, words):
    """What cannot be fitted is refused with the reason and a remedy."""
    with pytest.raises(InputError) as refused:
        identify(PROTOTYPE, synthetic(), (fit,))
    for word in words:
        assert word in str(refused.value)


def test_requests_that_make_no_sense():
    """The same parameter twice, none at all, too few points, a start at 0, no voltage, no rod."""
    few, seven = (synthetic(frequencies=np.linspace(600.0, 900.0, count)) for count in (4, 7))
    still, _ = load_scene("prototype", ["support.rotational_inertia=0 kg*m^2", "drive.voltage=0 V"])
    rod, _ = load_scene("generator", ["load.kind=none"])
    coil = synthetic(1, scene=rod, kind="impedance", frequencies=np.linspace(100.0, 600.0, 6))
    for scene, data, fit, words in (
        (PROTOTYPE, synthetic(), ("c_s", "support.rotational_stiffness"), "twice"),
        (PROTOTYPE, synthetic(), (), "nothing is to be fitted"),
        (PROTOTYPE, few, ("c_s",), r"holds 4 points.*at least 5"),
        (PROTOTYPE, seven, ("c_s", "d_s", "c_sl", "theta"),
         r"holds 7 points.*4 parameters.*at least 8"),
        (still, synthetic(), ("theta",), "cannot be where a fit starts"),
        (still, synthetic(), ("c_s",), r"check drive\.voltage"),
        (PROTOTYPE, coil, ("coil.turns",), r"set support\.kind=contact"),
    ):  # fmt: skip
        with pytest.raises(InputError, match=words):
            identify(scene, data, fit)


def test_a_fitted_scene_elsewhere_names_the_same_curve(tmp_path):
    """The path of a steel's table is written from where the new scene stands."""
    found = file_from(Path("fits"), "data/steel.csv", FILE_KEYS["steel.curve"])
    assert Path(found) == Path("..") / "data" / "steel.csv"
    for as_it_is in ("team20", "linear", str(tmp_path / "steel.csv")):
        assert file_from(Path("fits"), as_it_is, FILE_KEYS["steel.curve"]) == as_it_is


#: Contact, losses and coil are fitted to curves that the machine itself made.
ON_CONTACT = ("support.kind=contact", "coil.current=0mA")
FEW = np.linspace(10.0, 2000.0, 40)


def in_its_interval(found, scene, key):
    low, high = found.get(key).interval
    return low <= value_of(scene, key) <= high


@pytest.mark.parametrize(
    "keys",
    [("contact.decay_length",),
     pytest.param(("contact.decay_length", "contact.relaxation_time"), marks=pytest.mark.heavy)],
)  # fmt: skip
def test_the_contacts_constants_come_back(keys):
    """From starts a factor 2 to 4 away; an interval of 95 % that is a few percent wide."""
    truth = {"contact.decay_length": "0.25um", "contact.relaxation_time": "30us"}
    start = {"contact.decay_length": "0.6um", "contact.relaxation_time": "8us"}
    made, _ = load_scene("prototype", [*ON_CONTACT, *(f"{k}={truth[k]}" for k in keys)])
    scene, _ = load_scene("prototype", ON_CONTACT)
    data = synthetic(1, scene=made, frequencies=FEW)
    found = identify(scene, data, [f"{k}={start[k]}" for k in keys])
    for key in keys:
        assert in_its_interval(found, made, key)
        assert found.get(key).half_width < 0.05
    assert not found.findings


@pytest.mark.heavy
def test_a_loss_factor_comes_back():
    """Of the shim; the curve is known to 0.2 %."""
    made, _ = load_scene("prototype", [*ON_CONTACT, "shim.loss_factor=0.05"])
    scene, _ = load_scene("prototype", ON_CONTACT)
    data = synthetic(1, 2e-3, scene=made, frequencies=FEW)
    found = identify(scene, data, ("shim.loss_factor=0.2",))
    assert in_its_interval(found, made, "shim.loss_factor")
    assert found.get("shim.loss_factor").half_width < 0.5


PAIR = ("contact.decay_length", "spring.preload")


@pytest.mark.heavy
def test_preload_and_decay_length_are_told_to_be_one():
    """What the curve knows is their quotient, and that is said."""
    scene, _ = load_scene("prototype", ON_CONTACT)
    found = identify(scene, synthetic(1, scene=scene, frequencies=FEW), PAIR)
    assert any(all(key in said for key in PAIR) for said in found.findings)


@pytest.mark.heavy
def test_the_coils_circuit_comes_back_from_its_impedance():
    """The lead's resistance, at a rod held down."""
    made, _ = load_scene("generator", [*HELD, "coil.source_resistance=20ohm"])
    scene, _ = load_scene("generator", HELD)
    data = synthetic(1, scene=made, kind="impedance", frequencies=np.geomspace(10.0, 2000.0, 20))
    found = identify(scene, data, ("coil.source_resistance=5ohm",))
    assert in_its_interval(found, made, "coil.source_resistance")
    assert found.get("coil.source_resistance").half_width < 0.2


OWN = np.array([3.0, 40.0, 5.0])


@dataclass(frozen=True)
class Resonator:
    """A/(k − f² + i d f) of amplitude, stiffness and damping."""

    frequencies: np.ndarray

    def __call__(self, values):
        a, k, d = values
        return a / (k - self.frequencies**2 + 1j * d * self.frequencies)

    def sensitivities(self, values):
        _, k, d = values
        f = self.frequencies
        whole = k - f**2 + 1j * d * f
        return np.stack([np.ones(f.shape), -k / whole, -1j * d * f / whole], axis=1)


MODEL = Resonator(np.linspace(1.0, 12.0, 23))


def measured(*, phase=True, off=0.1):
    """Return the resonator's curve, a little off, with weights and uncertainties that differ."""
    f = MODEL.frequencies
    values = MODEL(OWN) * np.exp(off * np.cos(3.0 * f) + 0.7j * off * np.sin(5.0 * f))
    size = np.abs(values)
    return MeasuredCurve(
        "made", "velocity", f, values if phase else size, 0.05 * size + 1e-3, 1.0 + 0.1 * f
    )


@pytest.mark.parametrize("noise", ["relative", "constant", "stated"])
@pytest.mark.parametrize("phase", [True, False])
def test_slopes_of_a_misfit_are_those_of_its_residuals(noise, phase):
    """By central differences over ln p; of a magnitude the real part alone."""
    fit = Fit(MODEL, Misfit(measured(phase=phase), noise), OWN / 9.0, OWN * 9.0)
    slopes = fit.jacobian(OWN)
    assert slopes.shape == ((46 if phase else 23), 3)
    for i in range(3):
        step = np.where(np.arange(3) == i, 1e-5, 0.0)
        up, down = (fit.residuals(OWN * np.exp(s * step)) for s in (1.0, -1.0))
        assert slopes[:, i] == pytest.approx((up - down) / 2e-5, rel=1e-6, abs=1e-9)  # its square


def test_starts_are_the_best_that_differ():
    """The user's own first; what is no number never; none within a factor of two of another."""
    nodes = np.array([[1.0, 1.0], [4.0, 1.0], [7.9, 1.0], [4.0, 3.0], [64.0, 1.0], [512.0, 1.0]])
    assert starts(np.array([9.0, 1.0, 2.0, 3.0, np.nan, 5.0]), nodes) == [0, 1, 3]
    assert starts(np.array([9.0, 9.0, 1.0, 2.0, np.inf, 0.5]), nodes) == [0, 5, 2]
    assert starts(np.array([0.5, 1.0, 2.0, 3.0, 4.0, 5.0]), nodes) == [0, 1]


@pytest.mark.parametrize("noise", ["relative", "constant", "stated"])
def test_profile_and_bounds(noise):
    """A profile ends where the refitted sum of squares has risen, or openly at a bound.

    Ends are located to two hundredths of their distance, so a rise to some 4 % of itself.
    """
    fit = Fit(MODEL, Misfit(measured(), noise), OWN / 9.0, OWN * 9.0)
    least, best = fit.descend(OWN, [0, 1, 2], most=100)
    rise = 0.3 * least
    low, high, opened = fit.profile(best, 2, rise, np.nan)
    assert low < best[2] < high
    assert not opened
    for end in (low, high):
        risen, _ = fit.descend(np.array([*best[:2], end]), [0, 1], most=100)
        assert risen - least == pytest.approx(rise, rel=0.05)
    tight = Fit(MODEL, fit.misfit, best / 9.0, best * [9.0, 9.0, 0.9])
    assert tight.at_bounds(best * [1.0, 1.0, 0.9], [0, 1, 2]) == {2: "high"}
    assert not fit.at_bounds(best, [0, 1, 2])
    narrow = Fit(MODEL, fit.misfit, best * 0.999, best * 1.001)
    assert narrow.profile(best, 2, 1e3 * least, np.nan)[2] == ("low", "high")
