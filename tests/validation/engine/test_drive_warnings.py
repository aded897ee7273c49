"""A drive beyond strength, poling or beam theory is said, with the voltage that stays inside."""

import re

import numpy as np
import pytest

from tactgen.geometry.device.parameters import Device, Limits
from tactgen.geometry.device.winding import winding
from tactgen.tmm.beam.ceramic_stress import DrivenCeramic
from tactgen.tmm.reluctance.network import largest_rms_current
from tactgen.validation.catalogue.quantities import voltage_limits
from tactgen.validation.engine.solve import solve
from tactgen.validation.scene.load import load_scene

FREE = ("load.kind=none", "frequency=440:452:13")


def warnings(name, *overrides, quantity="tip_velocity"):
    scene, _ = load_scene(name, ["models=tmm", *overrides])
    return solve(scene, None, [quantity]).warnings


def test_usual_drives_are_no_matter():
    """Prototype at 1 V and the paper's 50 V under the finger stay inside all limits."""
    assert warnings("prototype") == ()
    assert warnings("paper") == ()


def test_a_field_against_the_poling_is_said():
    """The limit is at the voltage that the warning names: 0.4 kV/mm in 0.26 mm."""
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


def test_quantities_per_volt_have_no_drive():
    """An admittance is the same at any voltage."""
    assert warnings("paper", *FREE, "drive.voltage=1000V", quantity="admittance") == ()


def test_a_large_modelling_error_is_said():
    """Of a wide bimorph and one on a soft core, not of a slender narrow one."""
    asked = "static_tip_displacement"
    assert warnings("paper", quantity=asked) == ()
    for overrides in (
        ["bimorph.width=30mm"], ["shim.youngs_modulus=50MPa", "shim.shear_modulus=20MPa"],
    ):  # fmt: skip
        (text,) = warnings("paper", *overrides, quantity=asked)
        assert "modelling error" in text
        assert asked in text


def test_voltage_limits_are_where_each_limit_is_reached():
    """Strength, field and each channel's share of the current, by definition."""
    found = voltage_limits(
        DrivenCeramic(np.array([1e5, np.nan]), 4000.0, np.array([1e-4, 0.0])), Limits()
    )
    expected = [[280.0, np.inf], [100.0, 100.0], [62.5, np.inf]]
    np.testing.assert_allclose(found, expected)


def test_the_largest_current_heats_the_winding_to_its_limit():
    """P(hot) = h A ΔT over the sleeve's outside and the head's top."""
    device, limits = Device(), Limits()
    hot = device.coil.model_copy(update={"temperature": limits.winding_temperature})
    area = np.pi * (2.3e-3 * 18.7e-3 + 1.15e-3**2)
    current = largest_rms_current(device, limits)
    assert winding(hot).power(current) == pytest.approx(25.0 * area * 135.0)
