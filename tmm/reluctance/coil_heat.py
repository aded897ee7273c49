"""How warm the normal actuator's coil gets, on paper: free convection and plain words."""

from __future__ import annotations

import math

from tactgen.geometry.device.parameters import Device, Limits
from tactgen.geometry.device.winding import winding

#: Heat transfer to still air (W/(m² K)), the most that free convection gives (Incropera and
#: DeWitt, Fundamentals of Heat and Mass Transfer, table 1.1: 2 to 25).
_TO_AIR = 25.0


def steady_temperature_rise(device: Device, current: float) -> float:
    """Return how much warmer (K) than still air the actuator would stay, at the least.

    Free convection at its best from the sleeve's outside and the head's top; what the
    circuit board and the finger lead away is left out, and so is the wire's own rise.
    """
    return float(winding(device.coil).power(current) / (_TO_AIR * _surface(device)))


def largest_rms_current(device: Device, limits: Limits) -> float:
    """Return the effective current (A) that takes the winding to its temperature limit for good.

    From the sleeve's outside and the head's top to still air alone, the hot wire's resistance
    included.  A current switched much faster than the actuator warms (tens of seconds) with the
    share D of its time on may be 1/√D times as large.
    """
    rise = limits.winding_temperature - limits.ambient_temperature
    coil = device.coil.model_copy(update={"temperature": limits.winding_temperature})
    carried = limits.heat_transfer * _surface(device) * max(rise, 0.0)
    return math.sqrt(carried / winding(coil).resistance)


def _surface(device: Device) -> float:
    """Return the area of the sleeve's outside and the head's top (m²)."""
    sleeve, head = device.sleeve, device.rod.head_radius
    return float(2.0 * math.pi * sleeve.outer_radius * sleeve.length + math.pi * head**2)


def thermal_statement(device: Device, current: float) -> str:
    """Return in plain words what the current means for the wire."""
    if current == 0.0:
        return "no current, no heat"
    wound = winding(device.coil)
    rise = steady_temperature_rise(device, current)
    seconds = 100.0 / wound.heating_rate(current)
    verdict = (
        "not plausible as a direct current unless the circuit board leads the heat away"
        if rise > 100.0
        else "plausible as a direct current"
    )
    return (
        f"{abs(current) * 1e3:.3g} mA in {wound.wire_diameter * 1e6:.3g} µm wire is "
        f"{wound.current_density(current) * 1e-6:.3g} A/mm² and {wound.power(current):.3g} W; "
        f"uncooled, the wire would warm by 100 K in {seconds:.2g} s, and still air alone would "
        f"leave the actuator {rise:,.0f} K warmer: {verdict}"
    )
