"""What is refused and what is warned of: each limit just inside and just outside.

A drive beyond strength, poling or beam theory is said, with the voltage that stays inside.
"""

import re

import numpy as np
import pytest

from tactgen.geometry.device.parameters import Device, Limits
from tactgen.geometry.device.winding import winding
from tactgen.geometry.errors import InputError
from tactgen.tmm.beam.ceramic_stress import DrivenCeramic
from tactgen.tmm.reluctance.network import largest_rms_current
from tactgen.validation.catalogue.quantities import voltage_limits
from tactgen.validation.engine.solve import solve
from tactgen.validation.engine.warnings import held_warnings, number_warnings
from tactgen.validation.models.model import Quantity
from tactgen.validation.scene.load import load_scene


def quantity(name, model, value, error=0.0):
    frequency = (10.0, 20.0) if np.ndim(value) else None
    return Quantity(
        name=name, model=model, unit="m", value=np.asarray(value), error=np.asarray(error),
        frequency=frequency,
    )  # fmt: skip


@pytest.mark.parametrize(("share", "warned"), [(0.0999, False), (0.1001, True), (-0.1001, True)])
def test_a_tenth_of_the_length_is_beyond_linear_theory(share, warned):
    """The largest of all values decides, in either direction."""
    scene, _ = load_scene("paper")
    moved = share * scene.bimorph.length
    for name, value in (("static_tip_displacement", moved), ("tip_displacement", [0.0, moved])):
        assert bool(number_warnings(scene, [quantity(name, "tmm", value)])) is warned


@pytest.mark.parametrize(
    ("model", "value", "bar", "words"),
    [
        ("solid", -2.0, 2.002e-3, "capacitance_free (up to 0.1001 %)"),
        ("solid", -2.0, 1.998e-3, ""),
        ("tmm", -2.0, 2.002e-3, ""),
        ("axisymmetric", 0.0, 1e-8, "capacitance_free (zero within its error)"),
        ("axisymmetric", 0.0, 0.0, ""),
        ("axisymmetric", np.nan, np.nan, ""),
    ],
)
def test_a_bar_wider_than_the_accuracy_is_warned_of(model, value, bar, words):
    """Of the models that refine for the accuracy wanted; the others say what they can."""
    scene, _ = load_scene("j1")
    assert scene.accuracy == 1e-3
    found = number_warnings(scene, [quantity("capacitance_free", model, value, bar)])
    assert len(found) == bool(words)
    assert all(words in text for text in found)


@pytest.mark.parametrize(
    ("spring", "name", "frequency", "held"),
    [
        ("rotational_stiffness", "static_tip_displacement", "100", False),
        ("lateral_stiffness", "capacitance_free", "100", False),
        ("lateral_stiffness", "tip_displacement", "0,100", False),
        ("lateral_stiffness", "tip_displacement", "100", True),
        ("rotational_stiffness", "dynamic_stiffness", "0,100", True),
        ("lateral_stiffness", "short_circuit_frequencies", "100", True),
    ],
)
def test_a_floating_body_has_no_static_answer(spring, name, frequency, held):
    """Without one of its springs the actuator has no rest position: what needs one is refused."""
    unit = "N*m/rad" if spring.startswith("rot") else "N/m"
    overrides = [f"support.{spring}=0 {unit}", "load.kind=none", f"frequency={frequency}"]
    scene, _ = load_scene("paper", overrides)
    if held:
        assert np.isfinite(solve(scene, ("tmm",), (name,)).quantities[0].value).all()
    else:
        with pytest.raises(InputError, match=f"support.{spring} = 0 .* {name} has no value at 0"):
            solve(scene, ("tmm",), (name,))
        sprung = ["load.kind=spring_damper", "load.stiffness=1000 N/m"]
        solve(load_scene("paper", [*overrides, *sprung])[0], ("tmm",), (name,))


@pytest.mark.parametrize("preload", ["0N", "110mN"])
def test_a_spring_that_does_not_hold_the_rod_up_is_named(preload):
    """Its place follows from the stops' tails alone, which is worth a sentence."""
    scene, _ = load_scene("generator", [f"spring.preload={preload}"])
    found = held_warnings(scene, ("network",), ())
    assert ["spring.preload = 0 mN" in w for w in found] == ([True] if preload == "0N" else [])


@pytest.mark.parametrize(
    ("name", "overrides", "quantity", "words"),
    [
        ("j1", ["drive.voltage=0V", "drive.tip_force=1N"], "tip_displacement", "drive.tip_force ="),
        ("j1", ["circuit.kind=load", "circuit.resistance=1kohm",
                "drive.base_acceleration=9000m/s^2"],
         "circuit_power", "drive.base_acceleration ="),
        ("generator", [], "tip_displacement", "drive.voltage ="),
    ],
)  # fmt: skip
def test_the_drive_that_would_be_borne_is_named(name, overrides, quantity, words):
    """By the ceramic, or by the head on its stop; under that drive there is no such warning."""
    asked = ["models=tmm", "frequency=150"]
    scene, _ = load_scene(name, [*asked, *overrides])
    (warning,) = (w for w in solve(scene, ("tmm",), (quantity,)).warnings if words in w)
    lower = next(part for part in warning.split("; ") if words in part)
    key, _, value, unit = lower.split(" and ")[0].split()[:4]
    scene, _ = load_scene(name, [*asked, *overrides, f"{key}={value} {unit}"])
    again = solve(scene, ("tmm",), (quantity,)).warnings
    assert not [w for w in again if words.split()[0] in w and "reaches" in w]


def test_constants_that_contradict_each_other_a_little_are_told():
    """Printed to two digits; what is taken in their place, or nothing where they agree."""
    stated = "piezo.constants=d31 -180 pC/N; s11 16.1e-12 m^2/N; eps33 1750"
    for more, told in (("; k31 0.35", True), ("", False)):
        scene, _ = load_scene("j1", ["models=tmm", stated + more])
        found = [w for w in solve(scene, ("tmm",), ("capacitance_free",)).warnings if "taken" in w]
        assert bool(found) is told
        assert not told or "in place of d31 -180 pC/N" in found[0]


FREE = ("load.kind=none", "frequency=440:452:13")


def warnings(name, *overrides, quantity="tip_velocity"):
    scene, _ = load_scene(name, ["models=tmm", *overrides])
    return solve(scene, None, [quantity]).warnings


def test_a_field_against_the_poling_is_said():
    """The limit is at the voltage that the warning names: 0.4 kV/mm in 0.26 mm.

    Prototype at 1 V and the paper's 50 V under the finger stay inside all limits.
    """
    assert warnings("prototype") == warnings("paper") == ()
    (text,) = warnings("paper", "drive.voltage=120V", "frequency=10,20")
    assert "0.462 kV/mm" in text
    assert "104 V" in text
    assert warnings("paper", "drive.voltage=103.9V", "frequency=10,20") == ()
    assert warnings("paper", "drive.voltage=200V", "bimorph.wiring=series", "frequency=10,20") == ()


def test_stress_beyond_strength_names_the_voltage_that_stays_below():
    """At that voltage, and no longer above it, the warning is gone."""
    text = next(w for w in warnings("paper", *FREE) if "stress" in w)
    voltage = float(re.search(r"drive.voltage = ([\d.]+) V keeps", text)[1])
    for share, said in ((0.99, False), (1.01, True)):
        texts = warnings("paper", *FREE, f"drive.voltage={share * voltage}V")
        assert any("stress" in w for w in texts) == said
    # an admittance is the same at any voltage
    assert warnings("paper", *FREE, "drive.voltage=1000V", quantity="admittance") == ()


def test_a_large_modelling_error_is_said():
    """Of a wide bimorph and one on a soft core, not of a slender narrow one."""
    asked = "static_tip_displacement"
    assert warnings("paper", quantity=asked) == ()
    for overrides in (["bimorph.width=30mm"],
                      ["shim.youngs_modulus=50MPa", "shim.shear_modulus=20MPa"]):  # fmt: skip
        (text,) = warnings("paper", *overrides, quantity=asked)
        assert "modelling error" in text


def test_voltage_limits_are_where_each_limit_is_reached():
    """Strength, field and each channel's share of the current, by definition."""
    driven = DrivenCeramic(np.array([1e5, np.nan]), 4000.0, np.array([1e-4, 0.0]))
    expected = [[280.0, np.inf], [100.0, 100.0], [62.5, np.inf]]
    np.testing.assert_allclose(voltage_limits(driven, Limits()), expected)


def test_the_largest_current_heats_the_winding_to_its_limit():
    """P(hot) = h A ΔT over the sleeve's outside and the head's top."""
    device, limits = Device(), Limits()
    hot = device.coil.model_copy(update={"temperature": limits.winding_temperature})
    area = np.pi * (2.3e-3 * 18.7e-3 + 1.15e-3**2)
    current = largest_rms_current(device, limits)
    assert winding(hot).power(current) == pytest.approx(25.0 * area * 135.0)
