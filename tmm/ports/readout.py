"""Reading of a quantity off terminated ports or natural frequencies.

Declarative, so that a solved model, the parametric one with its derivatives and a fit all
read the same formula.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, Literal, TypeVar

import numpy as np

from tactgen.geometry.arrays import Complex, Floats
from tactgen.tmm.ports.excitation_and_circuit import ELECTRICAL, UNIT_VOLTAGE, Excitation
from tactgen.tmm.ports.multiport import BIMORPH, MEASURED, VOLTAGE, Multiport, Response, respond

#: The bimorph's mechanical ports.
MECHANICAL = tuple(port.name for port in BIMORPH if port.pair != VOLTAGE)

Electrodes = Literal["short", "open"]
T = TypeVar("T")


@dataclass(frozen=True)
class Readout:
    """A variable of one port under the scene's excitation or another, everything attached."""

    #: Name of the port; the motion of `w_tip` is that of the place of measurement, if there is one
    port: str
    #: Displacement-like variable, or force-like (charge at the electrical port)
    of: Literal["motion", "effort"]
    #: How many times jΩ multiplies it: 1 for a velocity or a current, 2 for an acceleration
    rate: int = 0
    static: bool = False  #: Whether it is that of the lossless model at 0 Hz, a real number
    under: Excitation | None = None  #: Excitation; None is the scene's
    absolute: bool = False  #: Whether an acceleration has that of the base added
    held: tuple[str, ...] = ()  #: Ports held at rest besides a clamped base
    #: Of frequencies (n,) in Hz.  If given, the quantity is the variable's magnitude over that
    #: level (n,); per volt the voltage at which it is reached
    level: Callable[[Floats], Floats] | None = None

    @property
    def unit_voltage(self) -> bool:
        """Whether it is per volt at the electrodes."""
        return self.under == UNIT_VOLTAGE

    @property
    def has_free_ports(self) -> bool:
        """Whether some mechanical port can move, if the support lets it."""
        return len(self.held) < len(MECHANICAL)

    @property
    def is_of_tip(self) -> bool:
        """Whether the motion of the tip and the charge tell it, nothing else being held."""
        return not self.held and self.port in ("w_tip", "psi_tip", ELECTRICAL)

    @property
    def is_loaded(self) -> bool:
        """Whether the tip's load enters with its losses."""
        return not self.static and "w_tip" not in self.held

    @property
    def is_transduced(self) -> bool:
        """Whether it is nothing without piezoelectricity."""
        return (self.port, self.of) != (ELECTRICAL, "effort")

    def read(self, port: Multiport, voltage: Any) -> Complex:
        """Quantity (n,) under a voltage at the electrodes alone; real with a level.

        Its voltage is nan where nothing moves.

        Parameters
        ----------
        port : Multiport
            The actuator with support and load attached, wired as the device is.
        voltage : number or (n,) array
            Amplitude of the drive (V), not looked at with `unit_voltage`.
        """
        held = {name: 0.0 for name in self.held if name in port.names}
        response = respond(port, {ELECTRICAL: 1.0} | held)
        return self.scaled(self.variable(response), voltage, port.frequencies)

    def variable(self, response: Response) -> Complex:
        """Port's variable (n,)."""
        return (
            measured(response.motion, self.port)
            if self.of == "motion"
            else response.effort[self.port]
        )

    def scaled(self, variable: Complex, voltage: Any, frequencies: Floats) -> Complex:
        """Quantity (n,) from the port's variable (n,) per volt."""
        found = variable if self.unit_voltage else variable * voltage
        for _ in range(self.rate):
            found = 2j * np.pi * frequencies * found
        if self.level is None:
            return np.asarray(found)
        size = np.abs(found)
        if not self.unit_voltage:
            return np.asarray(size / self.level(frequencies))
        # no voltage moves what does not respond
        return np.asarray(self.level(frequencies) / np.where(size > 0.0, size, np.nan))


def measured(motion: Mapping[str, T], port: str = "w_tip") -> T:
    """Motion of a port; of the tip's displacement that at the place where it is measured."""
    return motion[MEASURED.name if port == "w_tip" and MEASURED.name in motion else port]


@dataclass(frozen=True)
class PortMatrix:
    """The whole matrix D(Ω), (n, 5, 5), without support and load."""


@dataclass(frozen=True)
class ModalReadout:
    """Natural frequencies of the lossless model, or a number made from the first ones."""

    circuits: tuple[Electrodes, ...]  #: Whose modes it is made from: at U = 0, or at Q = 0
    #: An analytic function of the first bending frequencies in x (Hz) of these circuits, one
    #: argument each, numbers or arrays; without it the quantity is the list of frequencies of the
    #: one circuit
    combine: Callable[..., Any] | None = None
    #: What relative rounding of the frequencies (second argument) does to a value of `combine`
    #: (first argument), in its unit
    rounding: Callable[[float, float], float] = lambda value, of: abs(value) * of

    @property
    def is_transduced(self) -> bool:
        """Whether it is nothing without piezoelectricity, which makes the circuits differ."""
        return len(self.circuits) > 1
