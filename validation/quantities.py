"""The catalogue of quantities and models: names, units, what each needs.

Declarative; plan, solver, report and command line all read this table.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

Need = Literal["static", "modes_short", "modes_open", "harmonic"]


@dataclass(frozen=True)
class QuantityInfo:
    """One quantity that can be asked for.

    Attributes
    ----------
    name, unit, meaning : str
        Name in the interface, SI unit, one line of explanation.
    needs : tuple of str
        Kinds of solution it is computed from.
    by_frequency : bool
        Whether it is an array over the frequencies asked for.
    loaded : bool
        Whether the tip's load enters.
    """

    name: str
    unit: str
    meaning: str
    needs: tuple[Need, ...]
    by_frequency: bool = False
    loaded: bool = False


_ALL = (
    QuantityInfo(
        "tip_displacement", "m", "lateral displacement of the tip under the drive voltage",
        ("harmonic",), by_frequency=True, loaded=True,
    ),
    QuantityInfo(
        "tip_velocity", "m/s", "lateral velocity of the tip under the drive voltage",
        ("harmonic",), by_frequency=True, loaded=True,
    ),
    QuantityInfo(
        "tip_rotation", "rad", "section rotation psi of the tip (about -dw/dz)",
        ("harmonic",), by_frequency=True, loaded=True,
    ),
    QuantityInfo(
        "input_current", "A", "current drawn at the drive voltage",
        ("harmonic",), by_frequency=True, loaded=True,
    ),
    QuantityInfo(
        "admittance", "S", "input current per drive voltage",
        ("harmonic",), by_frequency=True, loaded=True,
    ),
    QuantityInfo(
        "blocked_force", "N", "force that holds the tip at rest (rotation free)",
        ("harmonic",), by_frequency=True,
    ),
    QuantityInfo(
        "threshold_voltage", "V", "drive voltage at which the tip reaches the detection threshold",
        ("harmonic",), by_frequency=True, loaded=True,
    ),
    QuantityInfo(
        "static_tip_displacement", "m", "tip displacement at 0 Hz, lossless, no finger",
        ("static",),
    ),
    QuantityInfo(
        "capacitance_free", "F", "static charge per voltage, tip free, lossless", ("static",)
    ),
    QuantityInfo(
        "capacitance_blocked", "F", "static charge per voltage, base and tip held, lossless",
        ("static",),
    ),
    QuantityInfo(
        "short_circuit_frequencies", "Hz", "natural frequencies at U = 0, lossless, no finger",
        ("modes_short",),
    ),
    QuantityInfo(
        "open_circuit_frequencies", "Hz", "natural frequencies at Q = 0, lossless, no finger",
        ("modes_open",),
    ),
    QuantityInfo(
        "coupling_factor", "1", "sqrt(1 - (f_short/f_open)^2) of the first bending mode in x",
        ("modes_short", "modes_open"),
    ),
    QuantityInfo(
        "dynamic_stiffness", "SI",
        "5x5 matrix [F_base, M_base, F_tip, M_tip, Q] per [w_base, psi_base, w_tip, psi_tip, U]",
        ("harmonic",), by_frequency=True,
    ),
)  # fmt: skip

#: Every quantity by name.
QUANTITIES: dict[str, QuantityInfo] = {q.name: q for q in _ALL}

#: Every model of the lateral actuator, cheapest first.
MODELS: dict[str, str] = {
    "lumped": "static closed forms, consistent mass, one-mode circuit",
    "tmm": "exact Timoshenko transfer-matrix model (paper appendix A, corrected)",
    "beam": "Timoshenko beam finite elements",
    "solid": "3D piezoelectric solid finite elements",
}
