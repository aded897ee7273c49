"""The coil's wire: closed forms, and the heat that the reconstructed coil would have."""

import math

import pytest

from tactgen.geometry.device.parameters import Coil
from tactgen.geometry.device.winding import winding


def test_wire_fills_its_share_of_the_window():
    """Turns times the bare wire's area is the fill factor's share of the window."""
    wound = winding(Coil())
    assert wound.window == pytest.approx(0.26e-3 * 1.6e-3)
    assert 560.0 * wound.wire_area == pytest.approx(0.5 * wound.window)
    assert math.pi / 4.0 * wound.wire_diameter**2 == pytest.approx(wound.wire_area)


def test_resistance():
    """R = ρ N · 2π r_mean / a; half the fill doubles it, and copper gains 39.3 % in 100 K."""
    cold, thin, warm = (
        winding(Coil(**change)).resistance
        for change in ({}, {"fill_factor": 0.25}, {"temperature": 393.15})
    )
    length = 560.0 * 2.0 * math.pi * 0.77e-3
    assert cold == pytest.approx(1.7241e-8 * length / (0.5 * 0.416e-6 / 560.0))
    assert thin == pytest.approx(2.0 * cold)
    assert warm == pytest.approx(1.393 * cold)


def test_heating_rate_is_power_over_heat_capacity():
    """Uncooled, all heat stays in the copper: 385 J/(kg K), 8960 kg/m³."""
    wound = winding(Coil())
    copper = 385.0 * 8960.0 * wound.wire_area * wound.wire_length
    assert wound.heating_rate(0.13) == pytest.approx(wound.power(0.13) / copper)
