"""Derivatives of the transfer-matrix model against 80-digit difference quotients.

The witness is the state-space beam of validation.evidence.cases.exact_beam with support, load and
wiring written out here in mpmath; it shares no formula with tmm.
"""

from functools import cache

import mpmath as mp
import numpy as np
import pytest

from tactgen.geometry.bimorph.segments import beam_pieces
from tactgen.geometry.device.materials import EPS0
from tactgen.geometry.device.parameters import Bimorph, Device, Support
from tactgen.geometry.errors import InputError
from tactgen.tmm.beam import parametric
from tactgen.tmm.beam.parametric import Actuator, parameter_keys
from tactgen.tmm.beam.port_quantities import evaluate, first_frequency, resonance_peak
from tactgen.tmm.beam.sensitivities import derivatives, logarithmic_sensitivities, values
from tactgen.tmm.ports.loads import finger_spring_damper
from tactgen.tmm.ports.readout import ModalReadout, Readout
from tactgen.validation.catalogue.detection import DISPLAY_THRESHOLD
from tactgen.validation.catalogue.quantities import QUANTITIES
from tactgen.validation.evidence.cases import exact_beam as reference
from tactgen.validation.scene.scene import load_scene

#: How each quantity with a derivative is read, by its name.
READS = {
    name: row.read
    for name, row in QUANTITIES.items()
    if isinstance(row.read, Readout | ModalReadout)
}
STATIC = [name for name in READS if QUANTITIES[name].static]
VELOCITY = READS["tip_velocity"]
#: Relative step of the difference quotients, whose error is of its size.
STEP = mp.mpf(10) ** -25


def actuator(name, *overrides):
    scene, _ = load_scene(name, overrides)
    return Actuator(scene.device, scene.support, scene.load, scene.beam, scene.drive)


PAPER, PROTOTYPE = actuator("paper"), actuator("prototype")
KEYS = parameter_keys(PAPER)


@cache
def exact_beam(device, key, lossless):
    """Return [parameters, 80-digit section constants] with one parameter, or none, STEP larger."""
    p = {k: mp.mpf(device.value(k)) for k in KEYS}
    if key:
        p[key] *= 1 + STEP
    layers = reference.Layers(
        p["bimorph.width"], p["bimorph.piezo_thickness"], p["bimorph.shim_thickness"],
        p["piezo.density"], p["shim.density"], p["shim.youngs_modulus"], p["shim.shear_modulus"],
        p["piezo.s11"], p["piezo.s55"], p["piezo.d31"], p["piezo.eps33"] * mp.mpf(EPS0),
        p["beam.shear_correction"],
        mp.inf if lossless else p["piezo.quality_factor"],
        0 if lossless else p["piezo.loss_tangent"],
    )  # fmt: skip
    return p, reference.bimorph_constants(layers)


def exact_matrix(device, key, frequency, lossless=False):
    p, beam = exact_beam(device, key, lossless)
    omega = 2 * mp.pi * mp.mpf(frequency)
    d = reference.dynamic_stiffness(beam, p["bimorph.length"], omega)
    d[0, 0] += p["support.lateral_stiffness"]
    damping = 0 if lossless else mp.j * omega * p["support.rotational_damping"]
    d[1, 1] += p["support.rotational_stiffness"] + damping
    d[1, 1] -= omega**2 * p["support.rotational_inertia"]
    if device.load.kind == "finger" and not lossless:
        stiffness, drag = (mp.mpf(float(v)) for v in finger_spring_damper(float(frequency)))
        d[2, 2] += stiffness + mp.j * omega * drag
    return p, omega, d


#: Quantities at one frequency take one matrix; nobody changes it.
matrix_of = cache(exact_matrix)


def threshold(frequency):
    return mp.mpf(float(DISPLAY_THRESHOLD.at(np.array([max(frequency, 10.0)]))[0]))


def exact(device, quantity, key, frequency):
    """Return a quantity with 60 digits or more."""
    static = quantity in STATIC
    p, omega, d = matrix_of(device, key, 0 if static else frequency, lossless=static)
    per_volt = ("admittance", "capacitance_free", "threshold_voltage")
    voltage = 1 if quantity in per_volt else p["drive.voltage"]
    free = [0, 1, 3] if quantity == "blocked_force" else [0, 1, 2, 3]
    if quantity == "capacitance_blocked":
        return d[4, 4]
    inner = mp.matrix([[d[i, j] for j in free] for i in free])
    force = mp.matrix([-d[i, 4] * voltage for i in free])
    x = dict(zip(free, mp.lu_solve(inner, force), strict=True)) | {4: voltage}
    row = {"blocked_force": 2}.get(quantity, 4)
    reaction = sum(d[row, i] * value for i, value in x.items())
    return {
        "tip_displacement": x.get(2),
        "static_tip_displacement": x.get(2),
        "tip_velocity": mp.j * omega * x.get(2, 0),
        "tip_rotation": x[3],
        "input_current": mp.j * omega * reaction,
        "admittance": mp.j * omega * reaction,
        "capacitance_free": reaction,
        "blocked_force": reaction,
        "threshold_voltage": threshold(frequency) / abs(x.get(2, mp.inf)),
    }[quantity]


@mp.workdps(reference.DIGITS)
def exact_frequency(device, key, start, *, open_circuit, apart=1e-12):
    """Return the root near `start`, which is off by `apart` (relative) or so."""

    def determinant(f):
        _, _, d = exact_matrix(device, key, f, lossless=True)
        size = 5 if open_circuit else 4
        return mp.det(d[:size, :size]).real  # lossless

    return mp.findroot(determinant, (start, start * (1 + apart)), tol=1e-120)


CASES = [
    *((PROTOTYPE, "tip_velocity", f) for f in (10.0, 781.609, 2000.0)),
    *((PROTOTYPE, "input_current", f) for f in (781.609,)),
    *((PAPER, "tip_displacement", f) for f in (10.0, 1000.0)),
    (PAPER, "blocked_force", 250.0),
    (PAPER, "tip_rotation", 100.0),
    (PAPER, "admittance", 100.0),
    (PAPER, "threshold_voltage", 250.0),
    *((PAPER, name, 0.0) for name in STATIC),
]


@pytest.mark.parametrize(
    ("device", "quantity", "frequency"), CASES, ids=[f"{q}-{f:g}" for _, q, f in CASES]
)
@mp.workdps(reference.DIGITS)
def test_every_derivative_is_exact(device, quantity, frequency):
    """All 20 parameters, lossy beside a sharp peak and beside a minimum too, to 1e-8.

    Relative to the derivative, or to 1e-4 of quantity over parameter where it is smaller:
    there it is a difference of terms that cancel, and 1e-12 is rounding.
    """
    at = None if quantity in STATIC else np.array([frequency])
    found = derivatives(device, READS[quantity], KEYS, at)
    value = exact(device, quantity, "", frequency)
    assert values(device, READS[quantity], at)[0] == pytest.approx(complex(value), rel=1e-10)
    for key in KEYS:
        slope = (exact(device, quantity, key, frequency) - value) / (STEP * device.value(key))
        least = 1e-4 * abs(value / device.value(key))
        error = abs(complex(found[key][0]) - slope) / max(abs(slope), least)
        assert error < 1e-8, (key, float(error))


#: One of each group, and of those that only one circuit sees.
FEW = ("bimorph.length", "piezo.s11", "piezo.eps33", "support.rotational_stiffness")
MORE = (
    "bimorph.piezo_thickness", "piezo.density", "piezo.d31", "shim.shear_modulus",
    "support.rotational_inertia",
)  # fmt: skip


@pytest.mark.parametrize("open_circuit", [False, True])
@pytest.mark.parametrize("keys", [FEW, pytest.param(MORE, marks=pytest.mark.heavy)])
@mp.workdps(reference.DIGITS)
def test_derivatives_of_the_first_frequency_are_exact(open_circuit, keys):
    """Implicit differentiation of det S = 0 against moved roots, to 1e-8."""
    read = READS["open_circuit_frequencies" if open_circuit else "short_circuit_frequencies"]
    start = float(values(PROTOTYPE, read)[0])
    found = derivatives(PROTOTYPE, read, keys)
    root = exact_frequency(PROTOTYPE, "", start, open_circuit=open_circuit)
    for key in keys:
        moved = exact_frequency(PROTOTYPE, key, root, open_circuit=open_circuit, apart=STEP)
        slope = (moved - root) / (STEP * PROTOTYPE.value(key))
        least = 1e-4 * start / abs(PROTOTYPE.value(key))
        assert abs(float(found[key][0]) - slope) / max(abs(slope), least) < 1e-8, key


def test_coupling_factor_follows_from_both_frequencies():
    """d k of k² = 1 − (f_s/f_o)² for a change so small that the quotient is good to 1e-6."""
    key, step = "piezo.eps33", 1e-4
    usual = PAPER.value(key)
    more, less = (
        values(PAPER.with_values({key: usual * (1 + s)}), READS["coupling_factor"])[0]
        for s in (step, -step)
    )
    found = derivatives(PAPER, READS["coupling_factor"], [key])[key][0]
    # the quotient's own error is step² = 1e-8, and rounding of f over step: 1e-13/k²/1e-4
    assert found == pytest.approx((more - less) / (2 * step * usual), rel=1e-6)


ROWS = {
    "tab": actuator("paper", "bimorph.tab_length=2mm", "load.kind=none"),
    "rod": actuator("bimorph_on_rod", "load.kind=none"),
    "taper": actuator("prototype", "bimorph.width_profile=0 mm: 2.1 mm, 14 mm: 1 mm"),
    "series": actuator("prototype", "bimorph.wiring=series", "bimorph.bare_below=2mm"),
    "mass": actuator("prototype", "load.kind=mass", "load.mass=5mg", "support.kind=clamped"),
    "spring": actuator(
        "paper", "load.kind=spring_damper", "load.stiffness=700N/m", "load.damping=0.5N*s/m"
    ),
}


@pytest.mark.parametrize(
    "name", [pytest.param(n, marks=[pytest.mark.heavy] * (n == "taper")) for n in ROWS]
)
def test_rows_of_pieces_and_other_ends(name):
    """Tab, rod, taper, bare ceramic, series wiring, mass, spring: like difference quotients.

    Richardson's from steps of 1e-3 and 2e-3 (error 1e-12 of the fifth derivative) of the same
    model, well below the peaks: 1e-7 of quantity over parameter.  Shown is that no piece is
    left out.
    """
    device, at = ROWS[name], np.array([40.0, 120.0])
    keys = parameter_keys(device)
    found = derivatives(device, VELOCITY, keys, at)
    usual = values(device, VELOCITY, at)
    for key in keys:
        p = device.value(key)
        quotients = []
        for step in (1e-3, 2e-3):
            more, less = (
                evaluate(device.with_values({key: p * (1 + s)}), VELOCITY, {}, at)
                for s in (step, -step)
            )
            quotients.append((more - less) / (2 * step * p))
        slope = (4 * quotients[0] - quotients[1]) / 3
        assert np.abs((found[key] - slope) * p / usual).max() < 1e-7, key


def test_keys_are_those_that_matter():
    """The model names its own parameters: no magnetics, no rod unless it holds the bimorph."""
    assert len(KEYS) == 20
    assert "piezo.s11" in KEYS
    assert not [key for key in KEYS if key.startswith(("rod", "glue", "load", "coil"))]
    rod = parameter_keys(ROWS["rod"])
    assert {"rod.radius", "glue.thickness", "bimorph.tab_length"} <= set(rod)
    assert not [key for key in rod if key.startswith("support")]
    # this rod ends at its flange: its length can only grow, with a new piece
    assert "rod.length" not in rod
    assert {"load.stiffness", "load.damping"} <= set(parameter_keys(ROWS["spring"]))


def test_published_sensitivities_of_the_first_frequency():
    """At 14 mm density and c_s rule; of the assumed parameters no other moves it by 0.01.

    Two digits are stated: half a unit of the second.
    """
    found = logarithmic_sensitivities(PROTOTYPE, READS["short_circuit_frequencies"])
    assert found["piezo.density"][0] == pytest.approx(-0.46, abs=0.005)
    assert found["support.rotational_stiffness"][0] == pytest.approx(0.43, abs=0.005)
    for key in ("piezo.eps33", "piezo.quality_factor", "piezo.loss_tangent", "shim.shear_modulus",
                "beam.shear_correction"):  # fmt: skip
        assert abs(found[key][0]) < 0.01
    # but some that the paper gives do: dimensions, s11 and the shim's density
    assert found["piezo.s11"][0] == pytest.approx(-0.061, abs=5e-4)
    assert found["shim.density"][0] == pytest.approx(-0.042, abs=5e-4)


def test_published_sensitivities_of_peak_and_minimum():
    """Peak velocity at 14 mm by d_s and c_s; the loaded 20 mm actuator at 1 kHz by c_s and ρ_p."""
    start = values(PROTOTYPE, READS["short_circuit_frequencies"])
    at, _ = resonance_peak(PROTOTYPE, VELOCITY, {}, start)
    peak = logarithmic_sensitivities(PROTOTYPE, VELOCITY, None, at)
    assert peak["support.rotational_damping"][0] == pytest.approx(-0.96, abs=0.005)
    assert peak["support.rotational_stiffness"][0] == pytest.approx(1.1, abs=0.05)
    loaded = logarithmic_sensitivities(PAPER, READS["tip_displacement"], None, np.array([1000.0]))
    assert loaded["support.rotational_stiffness"][0] == pytest.approx(-4.1, abs=0.05)
    assert loaded["piezo.density"][0] == pytest.approx(4.6, abs=0.05)


def test_scaling():
    """Two exact laws: static deflection goes as l², motion as the voltage."""
    static = logarithmic_sensitivities(PAPER, READS["static_tip_displacement"])
    # shear does not bend a beam under pure moment, and the springs carry no force
    assert static["bimorph.length"][0] == pytest.approx(2.0, rel=1e-11)
    assert abs(static["beam.shear_correction"][0]) < 1e-11
    assert static["drive.voltage"][0] == pytest.approx(1.0, rel=1e-11)
    # a factor on all stiffnesses of a clamped, lossless beam: f as its square root
    clamped = actuator("prototype", "support.kind=clamped")
    found = logarithmic_sensitivities(clamped, READS["short_circuit_frequencies"], modes=3)
    densities = found["piezo.density"] + found["shim.density"]
    np.testing.assert_allclose(densities, -0.5, rtol=1e-10)


def test_sampled_first_frequency_is_the_counted_one():
    """Newton's method on many samples finds the mode that counting modes finds, at both ends."""
    points = {"piezo.density": np.array([6000.0, 7900.0, 9000.0]), "bimorph.length": 0.014}
    points["support.rotational_stiffness"] = np.array([0.05, 0.24, 1.0])
    for name, circuit in (("short_circuit_frequencies", False), ("open_circuit_frequencies", True)):
        start = np.full(3, values(PROTOTYPE, READS[name])[0])
        found = first_frequency(PROTOTYPE, points, start, open_circuit=circuit)
        for i in range(3):
            one = PROTOTYPE.with_values(
                {k: float(np.ravel(v)[i % np.size(v)]) for k, v in points.items()}
            )
            # counting converges to 1e-14, Newton to 1e-12
            assert found[i] == pytest.approx(values(one, READS[name])[0], rel=1e-11)


def test_resonance_peak_is_a_maximum():
    """The peak lies where the stored frequency and height say, and beside it is less."""
    start = values(PROTOTYPE, READS["short_circuit_frequencies"])
    at, height = resonance_peak(PROTOTYPE, VELOCITY, {}, start)
    assert at[0] == pytest.approx(781.609, abs=5e-4)  # digits stated
    assert height[0] == pytest.approx(22.795e-3, abs=5e-7)
    beside = np.abs(values(PROTOTYPE, VELOCITY, at[0] * np.array([1 - 1e-5, 1 + 1e-5])))
    assert (beside < height[0]).all()


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda: derivatives(PAPER, VELOCITY, ["coil.turns"], np.ones(1)), "coil.turns"),
        (lambda: derivatives(PAPER, VELOCITY, ["bimorph.tab_length"], np.ones(1)), "than 0"),
        (lambda: derivatives(PAPER, VELOCITY, ["piezo.s11"]), "frequencies in Hz"),
    ],
)
def test_what_has_no_derivative_is_refused(call, words):
    """One sentence that names what can be asked."""
    with pytest.raises(InputError, match=words):
        call()


def test_every_quantity_is_differentiable_by_default_keys():
    """All scalars and responses of the catalogue answer for all parameters."""
    for read in READS.values():
        found = derivatives(PAPER, read, None, np.array([100.0]))
        assert set(found) == set(KEYS)
        assert all(np.isfinite(v).all() for v in found.values())


def test_a_piece_is_made_of_its_dimensions():
    """Length, radius and the layers at both ends, each in its place."""
    tapered = Device(bimorph=Bimorph(width_profile="0 mm: 2.1 mm, 20 mm: 1 mm"))
    pieces = beam_pieces(tapered, Support(kind="rod"))
    assert any(piece.ends for piece in pieces)
    for piece in pieces:
        sizes = parametric._dimensions(piece)
        assert parametric._with_dimensions(piece, sizes) == piece
        assert len(sizes) == 8
