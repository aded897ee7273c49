"""The quantities of the lateral actuator, one row each."""

from __future__ import annotations

from typing import Any

import numpy as np

from tactgen.geometry.units import Unit
from tactgen.tmm.ports.readout import ELECTRICAL, MECHANICAL, ModalReadout, PortMatrix, Readout
from tactgen.validation.catalogue.detection import DISPLAY_THRESHOLD
from tactgen.validation.catalogue.row import (
    AnswerReadout,
    DrivenReadout,
    LoadReadout,
    QuantityRow,
)
from tactgen.validation.catalogue.safe_drive import voltage_limits

#: Largest plausible magnitude of any measured curve (SI).
_LARGEST = 1e3


def coupling_factor(short: Any, opened: Any) -> Any:
    """Return the electromechanical coupling factor of a mode from its two frequencies."""
    return np.sqrt(np.maximum(1.0 - (short / opened) ** 2, 0.0))


def coupling_rounding(value: float, of: float) -> float:
    """Return what relative rounding of both frequencies together does to a coupling factor.

    k² is the difference of nearly equal numbers, and k its root, also where nothing is left of it.
    """
    square, off = value**2, 2.0 * (1.0 - value**2) * of
    return float(max(np.sqrt(square + off) - value, value - np.sqrt(max(square - off, 0.0))))


TIP_DISPLACEMENT = QuantityRow(
    "tip_displacement", "m", "lateral displacement of the tip under the drive voltage",
    Readout("w_tip", "motion"), varied=True,
    curve=Unit("m", "displacement", "12.3 um", limits=(1e-15, _LARGEST)),
)  # fmt: skip
TIP_VELOCITY = QuantityRow(
    "tip_velocity", "m/s", "lateral velocity of the tip under the drive voltage",
    Readout("w_tip", "motion", rate=1),
    curve=Unit("m/s", "velocity", "12.3 mm/s", limits=(1e-12, _LARGEST)),
)  # fmt: skip
TIP_ROTATION = QuantityRow(
    "tip_rotation", "rad", "section rotation psi of the tip (about -dw/dz)",
    Readout("psi_tip", "motion"),
)  # fmt: skip
INPUT_CURRENT = QuantityRow(
    "input_current", "A", "current drawn at the drive voltage",
    Readout(ELECTRICAL, "effort", rate=1),
    curve=Unit("A", "current", "12.3 uA", limits=(1e-15, _LARGEST)),
)  # fmt: skip
ADMITTANCE = QuantityRow(
    "admittance", "S", "input current per drive voltage",
    Readout(ELECTRICAL, "effort", rate=1, unit_voltage=True),
    curve=Unit("S", "admittance", "12.3 uS", limits=(1e-15, _LARGEST)),
)  # fmt: skip
BLOCKED_FORCE = QuantityRow(
    "blocked_force", "N", "force that holds the tip at rest (rotation free)",
    Readout("w_tip", "effort", held=("w_tip",)),
)  # fmt: skip
THRESHOLD_VOLTAGE = QuantityRow(
    "threshold_voltage", "V", "drive voltage at which the tip reaches the detection threshold",
    Readout("w_tip", "motion", unit_voltage=True, level=DISPLAY_THRESHOLD.at),
)  # fmt: skip
DETECTION_RATIO = QuantityRow(
    "detection_ratio", "1", "tip displacement at the drive voltage over the detection threshold",
    Readout("w_tip", "motion", level=DISPLAY_THRESHOLD.at),
)  # fmt: skip
STATIC_TIP_DISPLACEMENT = QuantityRow(
    "static_tip_displacement", "m", "tip displacement at 0 Hz, lossless, no finger",
    Readout("w_tip", "motion", static=True), headline=True, varied=True,
)  # fmt: skip
SHORT_CIRCUIT_FREQUENCIES = QuantityRow(
    "short_circuit_frequencies", "Hz", "natural frequencies at U = 0, lossless, no finger",
    ModalReadout(("short",)), label="first frequency, short circuit", headline=True, varied=True,
)  # fmt: skip
OPEN_CIRCUIT_FREQUENCIES = QuantityRow(
    "open_circuit_frequencies", "Hz", "natural frequencies at Q = 0, lossless, no finger",
    ModalReadout(("open",)), label="first frequency, open circuit", varied=True,
)  # fmt: skip
COUPLING_FACTOR = QuantityRow(
    "coupling_factor", "1", "sqrt(1 - (f_short/f_open)^2) of the first bending mode in x",
    ModalReadout(("short", "open"), coupling_factor, coupling_rounding), varied=True,
)  # fmt: skip
CAPACITANCE_FREE = QuantityRow(
    "capacitance_free", "F", "static charge per voltage, tip free, lossless",
    Readout(ELECTRICAL, "effort", static=True, unit_voltage=True),
    label="free capacitance", headline=True, varied=True,
)  # fmt: skip
CAPACITANCE_BLOCKED = QuantityRow(
    "capacitance_blocked", "F", "static charge per voltage, base and tip held, lossless",
    Readout(ELECTRICAL, "effort", static=True, unit_voltage=True, held=MECHANICAL),
    label="blocked capacitance",
)  # fmt: skip
DYNAMIC_STIFFNESS = QuantityRow(
    "dynamic_stiffness", "SI",
    "5x5 matrix [F_base, M_base, F_tip, M_tip, Q] per [w_base, psi_base, w_tip, psi_tip, U]",
    PortMatrix(),
)  # fmt: skip

CERAMIC_STRESS = QuantityRow(
    "ceramic_stress", "Pa", "largest stress amplitude along the ceramic at the drive voltage",
    DrivenReadout(lambda driven, _, voltage: driven.stress * abs(voltage)),
)  # fmt: skip
VOLTAGE_LIMIT = QuantityRow(
    "voltage_limit", "V", "largest drive voltage by strength, depoling field and amplifier current",
    DrivenReadout(lambda driven, limits, _: np.min(voltage_limits(driven, limits), axis=0)),
)  # fmt: skip

LOAD_IMPEDANCE = QuantityRow(
    "load_impedance", "N*s/m", "force per velocity of what the tip touches, laterally",
    AnswerReadout("load", lambda load: load.impedance),
)  # fmt: skip
LOAD_FORCE = QuantityRow(
    "load_force", "N", "force of the tip on what it touches, at the drive voltage",
    LoadReadout(lambda stiffness, tip, _: stiffness * tip),
)  # fmt: skip
LOAD_POWER = QuantityRow(
    "load_power", "W", "mean power that what the tip touches takes, at the drive voltage",
    LoadReadout(lambda stiffness, tip, omega: 0.5 * omega * stiffness.imag * np.abs(tip) ** 2),
)  # fmt: skip

ROWS = (
    TIP_DISPLACEMENT, TIP_VELOCITY, TIP_ROTATION, INPUT_CURRENT, ADMITTANCE, BLOCKED_FORCE,
    THRESHOLD_VOLTAGE, DETECTION_RATIO, STATIC_TIP_DISPLACEMENT, SHORT_CIRCUIT_FREQUENCIES,
    OPEN_CIRCUIT_FREQUENCIES, COUPLING_FACTOR, CAPACITANCE_FREE, CAPACITANCE_BLOCKED,
    DYNAMIC_STIFFNESS, CERAMIC_STRESS, VOLTAGE_LIMIT, LOAD_IMPEDANCE, LOAD_FORCE, LOAD_POWER,
)  # fmt: skip
