"""Excitation of the lateral actuator: voltage behind a circuit, moving base, force on the tip.

All is a superposition of two responses: to 1 V at the electrodes, and to the mechanical
excitation with the electrodes in short circuit.  The circuit says how much of the first is added.

Motions are relative to what the support stands on.  There an acceleration a is the effort −M r a on
the ports, r a translation of the whole; from the dynamic stiffness, M r = −D(Ω) r / Ω².  Masses on
the tip have it too; springs and dampers of support and load stand on the same ground.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from tactgen.geometry.arrays import Complex, Floats, Numbers
from tactgen.geometry.bimorph.boundary_conditions import Ends, TipLoad
from tactgen.geometry.bimorph.segments import CentreLine
from tactgen.geometry.device.parameters import Circuit, Drive
from tactgen.tmm.ports.multiport import LATERAL, Multiport, Response, respond
from tactgen.tmm.ports.supports_and_loads import attach

#: The bimorph's electrical port.
ELECTRICAL = "voltage"
_TIP = "w_tip"


#: The source itself at the electrodes.
_NO_IMPEDANCE = Circuit()
OPEN_CIRCUIT = Circuit(kind="open")


@dataclass(frozen=True)
class Excitation:
    """Peak amplitudes in phase, numbers or arrays; a voltage needs a source."""

    circuit: Circuit = _NO_IMPEDANCE
    voltage: float = 0.0  #: V
    acceleration: float = 0.0  #: Of the base along x (m/s²)
    force: float = 0.0  #: On the tip along x (N)

    @property
    def source(self) -> float:
        """Voltage (V) of the circuit's source, 0 without one."""
        return self.voltage if self.circuit.kind == "source" else 0.0

    @property
    def is_mechanical(self) -> bool:
        """Whether base or tip are excited."""
        return bool(np.any(self.acceleration) or np.any(self.force))

    @property
    def at_rest(self) -> Excitation:
        """The same at 0 Hz, where a base does not vibrate."""
        return replace(self, acceleration=0.0)


def excitation_of(circuit: Circuit, drive: Drive) -> Excitation:
    """Excitation of a scene."""
    return Excitation(circuit, drive.voltage, drive.base_acceleration, drive.tip_force)


#: A unit of one excitation alone.
UNIT_VOLTAGE = Excitation(voltage=1.0)


def elastance(circuit: Circuit, frequencies: Floats) -> Complex:
    """Voltage across a circuit per charge that flows through it (n,) in V/C: jΩ times impedance.

    Infinite if the circuit is open.
    """
    s = 2j * np.pi * np.asarray(frequencies, dtype=float)
    if circuit.kind == "open":
        return np.full(s.shape, np.inf + 0j)
    parts = [s * circuit.resistance, s**2 * circuit.inductance]
    if np.any(circuit.capacitance):
        parts.append(np.full(s.shape, 1.0 / circuit.capacitance + 0j))
    if circuit.connection == "series":
        return np.asarray(sum(parts))
    sizes = (circuit.resistance, circuit.inductance, circuit.capacitance)
    stated = [part for part, size in zip(parts, sizes, strict=False) if np.any(size)]
    if not stated:
        return np.zeros_like(s)
    shorted = np.any([part == 0.0 for part in stated], axis=0)  # resistor or inductor at 0 Hz
    charge = sum(1.0 / np.where(shorted, 1.0, part) for part in stated)
    return np.asarray(np.where(shorted, 0.0, 1.0 / charge))


def inertia(port: Multiport, ends: Ends) -> Complex:
    """Efforts (n, k) at the ports per acceleration of the base, nan at 0 Hz.

    `port` is the actuator as wired, without support, which has no mass that translates, and load.
    """
    moved = np.array([p.pair == LATERAL for p in port.ports], dtype=float)
    omega = np.where(port.frequencies > 0.0, port.omega, np.nan)
    found = (port.stiffness @ moved) * (1.0 / omega**2)[:, None]
    if isinstance(ends.tip, TipLoad):
        for name, lever in zip((_TIP, "psi_tip"), ends.tip.arm, strict=True):
            found[:, port.index(name)] -= ends.tip.mass * lever
    return np.asarray(found)


def rounding_of_inertia(port: Multiport) -> Floats:
    """Relative rounding (n,) of :func:`inertia`, a small difference of large numbers."""
    moved = np.array([p.pair == LATERAL for p in port.ports], dtype=float)
    entries = port.stiffness * moved[:, None] * moved
    whole = np.abs(entries.sum(axis=(1, 2)))
    largest = np.abs(entries).max(axis=(1, 2))
    return np.asarray(np.finfo(float).eps * largest / np.where(whole > 0.0, whole, np.inf))


def excited(
    port: Multiport, ends: Ends, excitation: Excitation, held: Sequence[str] = ()
) -> Response:
    """Motions relative to the base, the electrodes' voltage among them, and efforts at held ports.

    `port` is the actuator as wired, without support and load; ports that are `held` are at rest,
    besides a clamped base.

    Raises numpy.linalg.LinAlgError if nothing holds a port that is free.
    """
    attached = attach(port, ends)
    rest = {name: 0.0 for name in held if name in attached.names}
    per_volt = respond(attached, {ELECTRICAL: 1.0} | rest)
    alone = None
    if excitation.is_mechanical:
        alone = _short_circuited(port, attached, ends, excitation, rest)
    return superposed(per_volt, port.frequencies, excitation, alone)


def superposed(
    per_volt: Response, frequencies: Floats, excitation: Excitation, alone: Response | None = None
) -> Response:
    """Response at frequencies (n,) in Hz with the circuit of an excitation.

    From those to 1 V at the electrodes and, `alone`, to the mechanical excitation with the
    electrodes in short circuit.
    """
    own = per_volt.effort[ELECTRICAL]
    charge = np.zeros_like(own) if alone is None else alone.effort[ELECTRICAL]
    voltage: Complex
    with np.errstate(invalid="ignore"):  # what is not known stays nan
        if excitation.circuit.kind == "open":
            voltage = -charge / own
        else:
            across = elastance(excitation.circuit, frequencies)
            voltage = (excitation.source - across * charge) / (1.0 + across * own)
    motion: dict[str, Complex] = {n: value * voltage for n, value in per_volt.motion.items()}
    effort: dict[str, Complex] = {n: value * voltage for n, value in per_volt.effort.items()}
    if alone is not None:
        motion = {name: value + alone.motion[name] for name, value in motion.items()}
        effort = {name: value + alone.effort[name] for name, value in effort.items()}
    if excitation.circuit.kind == "open":
        with np.errstate(invalid="ignore"):
            effort[ELECTRICAL] = 0.0 * voltage  # no charge, not that of rounding
    return Response(motion | {ELECTRICAL: voltage}, effort)


def _short_circuited(
    port: Multiport, attached: Multiport, ends: Ends, excitation: Excitation, rest: dict[str, float]
) -> Response:
    """Response to the mechanical excitation, electrodes in short circuit."""
    given = np.zeros((port.frequencies.size, len(port.ports)), dtype=complex)
    if np.any(excitation.acceleration):
        given += np.asarray(excitation.acceleration)[..., None] * inertia(port, ends)
    given[:, port.index(_TIP)] += excitation.force
    driven = {ELECTRICAL: 0.0} | rest
    acting = {name: given[:, port.index(name)] for name in attached.others(driven)}
    found = respond(attached, driven, acting)
    # what acts from outside on a held port does not strain the actuator
    effort = {name: value - given[:, port.index(name)] for name, value in found.effort.items()}
    return Response(found.motion, effort)


def resistor_power(circuit: Circuit, frequencies: Floats, charge: Complex) -> Floats:
    """Mean power (n,) in W into a circuit's resistor, from charge amplitudes (n,) in C."""
    if circuit.kind == "open":
        return np.zeros(frequencies.shape)
    # Re Z of Z = elastance / jΩ
    across = elastance(circuit, frequencies)
    return np.asarray(np.pi * frequencies * across.imag * np.abs(charge) ** 2)


class PortState(NamedTuple):
    """Motion of the bimorph's ports at one frequency, from which follows that of all inside."""

    frequency: float  #: Hz
    #: (5,) w_base, ψ_base, w_tip, ψ_tip (m, rad) in space, and the voltage across each layer (V)
    ports: Numbers
    charge: complex  #: That flows from the circuit into the electrodes (C)
    ground: complex = 0.0  #: Displacement along x (m) of what the support stands on

    def line(self, z: Floats, w: Numbers, psi: Numbers) -> CentreLine:
        """Centre line that moves so, relative to the ground."""
        voltage = complex(self.ports[4])
        return CentreLine(z, w - self.ground, psi, self.charge, voltage, self.frequency)


def port_states(port: Multiport, ends: Ends, excitation: Excitation) -> list[PortState]:
    """States under an excitation, arguments as of :func:`excited`; voltages of the whole."""
    found = excited(port, ends, excitation)
    still, omega2 = np.zeros(port.frequencies.size), (2.0 * np.pi * port.frequencies) ** 2
    ground: Floats = np.zeros_like(omega2)
    if excitation.acceleration:
        ground = -excitation.acceleration / omega2
    names = ("w_base", "psi_base", _TIP, "psi_tip", ELECTRICAL)
    moved = np.stack([found.motion.get(name, still) for name in names], axis=-1)
    moved[:, [0, 2]] += ground[:, None]
    columns = port.frequencies.tolist(), moved, found.effort[ELECTRICAL], ground
    return [PortState(f, of, complex(q), complex(g)) for f, of, q, g in zip(*columns, strict=True)]


@dataclass(frozen=True)
class ElectricalResponse:
    """What a circuit takes, and what could be taken, (n,) over the frequencies."""

    frequencies: Floats  #: Hz
    circuit: Circuit
    charge: Complex  #: That flows from the circuit into the electrodes (C)
    #: Voltage (V) of the open electrodes under the mechanical excitation
    open_voltage: Complex
    capacitance: Complex  #: Charge per voltage at the electrodes (F)

    @property
    def power(self) -> Floats:
        """Mean power into the circuit's resistor (W)."""
        return resistor_power(self.circuit, self.frequencies, self.charge)

    @property
    def optimum_resistance(self) -> Floats:
        """Resistance across the electrodes that takes the most power (ohm), nan at 0 Hz."""
        omega = 2.0 * np.pi * np.where(self.frequencies > 0.0, self.frequencies, np.nan)
        return np.asarray(1.0 / (omega * np.abs(self.capacitance)))

    @property
    def optimum_power(self) -> Floats:
        """Mean power that it takes (W), nan at 0 Hz."""
        resistance = self.optimum_resistance
        # the electrodes' impedance has this magnitude, too
        own = resistance * np.exp(-1j * (0.5 * np.pi + np.angle(self.capacitance)))
        current = np.abs(self.open_voltage) / np.abs(own + resistance)
        return np.asarray(0.5 * resistance * current**2)


def electrical(port: Multiport, ends: Ends, excitation: Excitation) -> ElectricalResponse:
    """What the circuit of an excitation takes; arguments as of :func:`excited`."""
    alone = replace(excitation, circuit=OPEN_CIRCUIT)
    return ElectricalResponse(
        port.frequencies,
        excitation.circuit,
        excited(port, ends, excitation).effort[ELECTRICAL],
        excited(port, ends, alone).motion[ELECTRICAL],
        excited(port, ends, UNIT_VOLTAGE).effort[ELECTRICAL],
    )
