"""How warm the normal actuator's coil gets, on paper: free convection and plain words."""

from __future__ import annotations

import math

from tactgen.geometry.device.parameters import Device
from tactgen.geometry.device.winding import winding

#: Heat transfer to still air (W/(m² K)), the most that free convection gives (Incropera and
#: DeWitt, Fundamentals of Heat and Mass Transfer, table 1.1: 2 to 25).
_TO_AIR = 25.0


def steady_temperature_rise(device: Device, current: float) -> float:
    """Return how much warmer (K) than still air the actuator would stay, at the least.

    Free convection at its best from the sleeve's outside and the head's top; what the
    circuit board and the finger lead away is left out, and so is the wire's own rise.
    """
    sleeve, head = device.sleeve, device.rod.head_radius
    surface = 2.0 * math.pi * sleeve.outer_radius * sleeve.length + math.pi * head**2
    return float(winding(device.coil).power(current) / (_TO_AIR * surface))


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
