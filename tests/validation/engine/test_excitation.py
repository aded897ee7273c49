"""Circuits, a moving base and a force on the tip, by every model of beams and the solid."""

import numpy as np
import pytest

import tactgen
from tactgen.geometry.errors import InputError
from tactgen.tmm.beam import transfer_matrix
from tactgen.validation.engine.answers import stated_as
from tactgen.validation.engine.warnings import request_warnings
from tactgen.validation.scene.load import checked_scene, load_scene

#: Slender, so that shear and rotary inertia are small.
SLENDER = {
    "bimorph.length": "90 mm", "bimorph.width": "10 mm", "bimorph.piezo_thickness": "0.1 mm",
    "bimorph.shim_thickness": "0.1 mm", "piezo.material": "PZT-5A", "shim.material": "brass",
    "beam.shear_correction": "1000", "frequency": [10.0, 25.0, 60.0, 140.0],
}  # fmt: skip
#: Without losses, so that power that goes in comes out elsewhere.
LOSSLESS = {"piezo.quality_factor": "1e9", "piezo.loss_tangent": "0"}


def scene(*groups, **stated):
    """Scene from dotted keys (double underscores in keywords)."""
    values = {"start_from": "neutral", "models": "tmm"}
    stated = {key.replace("__", "."): value for key, value in stated.items()}
    for key, value in {k: v for group in (*groups, stated) for k, v in group.items()}.items():
        group, _, name = key.rpartition(".")
        (values.setdefault(group, {}) if group else values)[name] = value
    return checked_scene(values)


def answers(of, *names, model="tmm"):
    """Values of quantities by name."""
    found = tactgen.solve(of, (model,), names)
    return [found.get(name, model).value for name in names]


def exact_harvester(of, resistance, mass, offset, inertia, acceleration):
    """Absolute tip acceleration and voltage of an Euler-Bernoulli beam whose base moves.

    w = a cos βx + b sin βx + c cosh βx + d sinh βx with the base's motion as a boundary
    condition, the inertia of a mass beyond the tip, EI w'' + K U = Ω² (J w' + m a (w + a w')) and
    EI w''' = −m Ω² (w + a w') at the tip, Q = −K w'(l) + C l U, U = −jΩ R Q.
    """
    ((s, length),) = transfer_matrix.sections(of.device, of.support, of.beam, lossy=True)
    found = []
    for omega in 2.0 * np.pi * np.array(of.frequency):
        beta = (s.m * omega**2 / s.EI) ** 0.25
        z = beta * length
        w = np.array([np.cos(z), np.sin(z), np.cosh(z), np.sinh(z)])
        dw = beta * np.array([-np.sin(z), np.cos(z), np.sinh(z), np.cosh(z)])
        ddw = beta**2 * np.array([-np.cos(z), -np.sin(z), np.cosh(z), np.sinh(z)])
        dddw = beta**3 * np.array([np.sin(z), -np.cos(z), np.sinh(z), np.cosh(z)])
        rows = np.zeros((5, 5), dtype=complex)
        rows[0, :4], rows[1, :4] = [1, 0, 1, 0], [0, 1, 0, 1]
        centre = w + offset * dw
        turned = omega**2 * (inertia * dw + mass * offset * centre)
        rows[2] = [*(s.EI * ddw - turned), s.K]
        rows[3] = [*(s.EI * dddw + mass * omega**2 * centre), 0.0]
        rows[4] = [
            *(-1j * omega * resistance * s.K * dw),
            1 + 1j * omega * resistance * s.C * length,
        ]
        a, b, c, d, voltage = np.linalg.solve(rows, [-acceleration / omega**2, 0, 0, 0, 0])
        found.append((-(omega**2) * (w @ [a, b, c, d]), voltage))
    return np.array(found).T


@pytest.mark.parametrize(
    ("resistance", "offset", "inertia"),
    [(1e2, 0.0, 0.0), (1e4, 0.0, 0.0), (1e6, 0.0, 0.0), (1e4, 8e-3, 0.0), (1e4, -3e-3, 4e-8)],
)
def test_harvester_is_a_beam_on_a_moving_base(resistance, offset, inertia):
    """Against the differential equation in absolute coordinates; what is left is the slenderness:
    shear and rotary inertia count (h / l)² and their like, 2e-5 times some ten at 140 Hz."""
    of = scene(
        SLENDER, circuit__kind="load", circuit__resistance=f"{resistance} ohm", load__kind="mass",
        load__mass="0.4 g", drive__base_acceleration="2 m/s^2", load__offset=f"{offset} m",
        load__rotational_inertia=f"{inertia} kg*m^2",
    )  # fmt: skip
    tip, voltage = answers(of, "tip_acceleration", "electrode_voltage")
    exact_tip, exact_voltage = exact_harvester(of, resistance, 0.4e-3, offset, inertia, 2.0)
    np.testing.assert_allclose(tip, exact_tip, rtol=5e-4)
    np.testing.assert_allclose(voltage, exact_voltage, rtol=5e-4)


def test_constant_acceleration_is_weight():
    """At a low frequency the tip sags by m g l⁴/8EI and M g (l³/3EI + a l²/2EI), and by the
    springs of its support."""
    offset = 6e-3
    of = scene(
        dict(SLENDER, frequency=[0.05]), support__kind="spring", load__kind="mass",
        support__rotational_stiffness="0.5 N*m/rad", support__lateral_stiffness="400 N/m",
        load__mass="0.3 g", load__offset=f"{offset} m", drive__base_acceleration="-1 g",
        drive__voltage="0 V",
    )  # fmt: skip
    ((s, length),) = transfer_matrix.sections(of.device, of.support, of.beam, lossy=False)
    g, own, tip = 9.80665, s.m * length, 0.3e-3
    sag = g * (own * length**3 / (8.0 * s.EI) + tip * length**3 / (3.0 * s.EI))
    sag += g * tip * offset * length**2 / (2.0 * s.EI)
    sag += g * (own + tip) / 400.0 + g * ((0.5 * own + tip) * length + tip * offset) * length / 0.5
    (found,) = answers(of, "tip_displacement")
    # the ceramic's losses turn it by 1/Q
    assert abs(found[0]) == pytest.approx(sag, rel=1e-3)


@pytest.mark.parametrize("model", ["lumped", "tmm", "beam", "solid"])
def test_charge_per_force_is_motion_per_voltage(model):
    """Reciprocity; the charge is that of the short-circuited, the voltage that of the open one."""
    stated = {"bimorph.length": "12 mm", "bimorph.wiring": "series", "models": model,
              "frequency": [0.0, 300.0, 2000.0]}  # fmt: skip
    names = ("charge_per_force", "voltage_per_force", "tip_displacement")
    charge, voltage, moved = answers(scene(stated, drive__voltage="1 V"), *names, model=model)
    np.testing.assert_allclose(charge, moved, rtol=1e-9)
    of = scene(stated, circuit__kind="open", drive__tip_force="2 N")
    opened, unit = answers(of, "electrode_voltage", "charge_per_force", model=model)
    np.testing.assert_allclose(opened, 2.0 * voltage, rtol=1e-9)
    assert (answers(of, "input_current", model=model)[0] == 0.0).all()
    np.testing.assert_allclose(unit, charge, rtol=1e-12)


def test_models_agree_on_a_harvester():
    """The beam elements' interior load is not the transfer matrix's; both stand for one beam."""
    stated = {"bimorph.length": "30 mm", "support.kind": "spring", "circuit.kind": "load",
              "circuit.resistance": "20 kohm", "circuit.inductance": "3 H",
              "drive.base_acceleration": "1 g", "load.kind": "mass", "load.mass": "0.1 g",
              "load.offset": "3 mm", "load.rotational_inertia": "1e-9 kg*m^2"}  # fmt: skip
    names = ("electrode_voltage", "circuit_power", "optimum_power", "tip_acceleration")
    of = scene(stated, models="tmm,beam", frequency=[40.0, 222.0, 900.0])
    for one, other in zip(*(answers(of, *names, model=m) for m in ("tmm", "beam")), strict=True):
        np.testing.assert_allclose(one, other, rtol=1e-7)


def test_power_into_source_impedance_and_load():
    """What the source gives is what resistor and damper take."""
    of = scene(
        LOSSLESS, {"bimorph.length": "20 mm"}, frequency=[50.0, 400.0, 700.0], drive__voltage="9 V",
        circuit__resistance="5 kohm", circuit__capacitance="47 nF", load__kind="spring_damper",
        load__damping="0.02 N*s/m",
    )  # fmt: skip
    current, resistor, damper = answers(of, "input_current", "circuit_power", "load_power")
    np.testing.assert_allclose(0.5 * 9.0 * current.real, resistor + damper, rtol=1e-6)
    assert (resistor > 0.0).all()
    assert (damper > 0.0).all()


def test_what_the_circuit_is_there_for_is_among_the_usual_quantities():
    """And without a source nothing about its voltage."""
    of_source = ("threshold_voltage", "detection_ratio", "voltage_limit")
    usual = [n for n in load_scene("prototype", [])[0].quantities if n not in of_source]
    for circuit, added in (
        (["circuit.kind=load", "circuit.resistance=1 kohm"],
         ("electrode_voltage", "circuit_power")),
        (["circuit.kind=open"], ("electrode_voltage",)),
    ):  # fmt: skip
        assert load_scene("prototype", circuit)[0].quantities == (*usual, *added)
        named, _ = load_scene("prototype", [*circuit, "quantities=tip_velocity"])
        assert named.quantities == ("tip_velocity",)


def test_optimum_resistance_takes_the_most():
    """Power over the resistance has its largest value there, of that size; the resistance of a
    sweep is that of its largest power, not its own largest."""
    stated = {"bimorph.length": "40 mm", "circuit.kind": "load", "drive.base_acceleration": "1 g"}
    names = ("optimum_resistance", "optimum_power")

    def power(resistance):
        of = scene(stated, frequency=[70.0], circuit__resistance=f"{resistance!r} ohm")
        return answers(of, "circuit_power")[0][0]

    best, most = answers(scene(stated, frequency=[70.0]), *names)
    at = power(float(best[0]))
    assert at == pytest.approx(most[0], rel=1e-9)
    assert at > power(1.05 * float(best[0]))
    assert at > power(0.95 * float(best[0]))
    swept = tactgen.solve(scene(stated, frequency=list(np.linspace(50.0, 400.0, 40))), None, names)
    resistance, largest = (swept.get(name, "tmm").extreme for name in names)
    assert resistance.frequency == largest.frequency
    (there,) = answers(scene(stated, frequency=[largest.frequency]), names[0])
    assert resistance.value == pytest.approx(there[0], rel=1e-12)


def test_resistor_and_capacitor_in_parallel_are_a_cable_on_a_sensor():
    """At high resistance the open voltage times C / (C + C_cable), from the scene's own C."""
    stated = {"bimorph.length": "20 mm", "drive.tip_force": "10 mN", "circuit.kind": "load",
              "circuit.connection": "parallel", "circuit.capacitance": "3 nF",
              "circuit.resistance": "1e12 ohm"}  # fmt: skip
    of = scene(stated, LOSSLESS, frequency=[20.0])
    charge, voltage, seen = answers(
        of, "charge_per_force", "voltage_per_force", "electrode_voltage"
    )
    own = abs(charge[0] / voltage[0])
    assert abs(seen[0]) == pytest.approx(0.01 * abs(voltage[0]) * own / (own + 3e-9), rel=1e-6)


def test_base_does_not_vibrate_at_rest():
    """0 Hz is refused where the base is accelerated; static values have the force alone."""
    of = scene(frequency=[0.0, 10.0], drive__base_acceleration="1 g", drive__tip_force="1 mN")
    with pytest.raises(InputError, match=r"0 Hz has no tip_displacement .* 0.1 Hz"):
        tactgen.solve(of, ("tmm",), ("tip_displacement",))
    by_both, alone, voltage = (
        answers(one, "static_tip_displacement")[0]
        for one in (of, scene(drive__tip_force="1 mN", drive__voltage="0 V"), scene())
    )
    assert by_both == pytest.approx(alone + voltage, rel=1e-12)


def test_amplitudes_are_read_as_stated_and_written_as_asked():
    """Without a word it is the peak; those of sinusoids alone, with the word in their unit."""
    for text, peak in (
        ("10 V", 10.0), ("10 Vpp", 5.0), ("10 V rms", 200.0**0.5), ("3 V peak", 3.0),
    ):  # fmt: skip
        assert scene(drive__voltage=text).drive.voltage == pytest.approx(peak, rel=1e-15)
    found = tactgen.solve(scene(), ("tmm",), ("tip_displacement", "threshold_voltage"))
    tip, threshold = found.quantities
    rms = stated_as(tip, "rms")
    np.testing.assert_allclose(rms.value * 2.0**0.5, tip.value, rtol=1e-15)
    assert rms.unit == "m rms"
    assert rms.extreme.value * 2.0**0.5 == pytest.approx(tip.extreme.value)
    assert stated_as(threshold, "rms") is threshold


def test_a_metal_without_losses_is_said_where_power_is_asked_for():
    """Not of its voltage, and not once its losses are stated."""
    stated = ["circuit.kind=load", "circuit.resistance=10 kohm", "drive.base_acceleration=1 g"]
    words = "is taken without"
    for more, quantity, said in (
        ("shim.loss_factor=0", "circuit_power", True),
        ("shim.loss_factor=0", "electrode_voltage", False),
        ("shim.loss_factor=0.01", "circuit_power", False),
    ):
        of, _ = load_scene("prototype", [*stated, more])
        found = request_warnings(of, ("tmm",), (quantity,))
        assert any(words in one for one in found) == said
