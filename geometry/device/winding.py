"""Winding: wire, resistance, current density, heating rate.

Follows from the window, the number of turns and the fill factor; no magnetic field.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from tactgen.geometry.device.parameters import Coil

#: Copper: temperature coefficient of its resistance at 20 °C (1/K) (IEC 60028), and heat
#: capacity per volume (J/(m³ K)): 385 J/(kg K) times 8960 kg/m³ (CRC Handbook).
TEMPERATURE_COEFFICIENT = 3.93e-3
HEAT_CAPACITY = 385.0 * 8960.0

#: Temperature to which `coil.resistivity` belongs (K): 20 °C.
REFERENCE_TEMPERATURE = 293.15


@dataclass(frozen=True)
class Winding:
    """The winding at its working temperature."""

    window: float  #: Area of the coil's half section (m²)
    wire_area: float  #: Bare cross-section of the wire (m²): window · fill factor / turns
    wire_length: float  #: Turns times the mean turn (m)
    resistivity: float  #: At the working temperature (Ω m)

    @property
    def wire_diameter(self) -> float:
        """Diameter of the bare round wire (m)."""
        return math.sqrt(4.0 * self.wire_area / math.pi)

    @property
    def resistance(self) -> float:
        """Direct-current resistance (Ω)."""
        return self.resistivity * self.wire_length / self.wire_area

    def current_density(self, current: float) -> float:
        """Current density in the wire (A/m²)."""
        return abs(current) / self.wire_area

    def power(self, current: float) -> float:
        """Heat of a direct current (W)."""
        return self.resistance * current**2

    def heating_rate(self, current: float) -> float:
        """Adiabatic heating rate of the wire: ρ J²/(c ρ_m) (K/s)."""
        return self.resistivity * self.current_density(current) ** 2 / HEAT_CAPACITY


def winding(coil: Coil) -> Winding:
    """Winding of a coil, a full window of round wire."""
    window = (coil.outer_radius - coil.inner_radius) * coil.length
    warm = 1.0 + TEMPERATURE_COEFFICIENT * (coil.temperature - REFERENCE_TEMPERATURE)
    return Winding(
        window=window,
        wire_area=window * coil.fill_factor / coil.turns,
        wire_length=coil.turns * math.pi * (coil.inner_radius + coil.outer_radius),
        resistivity=coil.resistivity * warm,
    )
