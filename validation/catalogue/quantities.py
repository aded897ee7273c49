"""The catalogue of quantities and models: names, units, what each needs.

Declarative; plan, solver, report and command line all read this table.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

Need = Literal["static", "modes_short", "modes_open", "harmonic", "magnetic_point", "magnetic_map"]

#: Kinds of solution that concern the normal actuator; all others concern the lateral one.
_MAGNETIC: tuple[Need, ...] = ("magnetic_point", "magnetic_map")


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

    @property
    def magnetic(self) -> bool:
        """Whether it is one of the normal actuator's quantities."""
        return self.needs[0] in _MAGNETIC


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
    QuantityInfo(
        "magnetic_force", "N", "pull between rod and sleeve at the coil's current and the gap",
        ("magnetic_point",),
    ),
    QuantityInfo(
        "flux_linkage", "Wb", "flux linkage of the winding, all turns", ("magnetic_point",)
    ),
    QuantityInfo("coenergy", "J", "magnetic co-energy", ("magnetic_point",)),
    QuantityInfo(
        "inductance", "H", "apparent inductance, flux linkage / current", ("magnetic_point",)
    ),
    QuantityInfo(
        "incremental_inductance", "H", "d flux linkage / d current, gap held", ("magnetic_point",)
    ),
    QuantityInfo(
        "pull_in_current", "A", "current that draws the rod to its lower stop", ("magnetic_map",)
    ),
    QuantityInfo(
        "holding_current", "A", "least current that holds the rod at its lower stop",
        ("magnetic_map",),
    ),
    QuantityInfo(
        "drop_out_current", "A", "current below which the rod is back at its upper stop",
        ("magnetic_map",),
    ),
)  # fmt: skip

#: Every quantity by name.
QUANTITIES: dict[str, QuantityInfo] = {q.name: q for q in _ALL}

#: Quantities of the lateral actuator.
LATERAL_QUANTITIES: tuple[str, ...] = tuple(q.name for q in _ALL if not q.magnetic)

#: Every model of the lateral actuator, cheapest first.
LATERAL_MODELS: dict[str, str] = {
    "lumped": "static closed forms, consistent mass, one-mode circuit",
    "tmm": "exact Timoshenko transfer-matrix model (paper appendix A, corrected)",
    "beam": "Timoshenko beam finite elements",
    "solid": "3D piezoelectric solid finite elements",
}

#: Every model of the normal actuator, cheapest first.
MAGNETIC_MODELS: dict[str, str] = {
    "network": "lumped reluctance network with fringing, leakage and saturation",
    "axisymmetric": "nonlinear magnetic field in the half section, finite elements",
    "magnetic3d": "nonlinear magnetic field in 3D by vector and scalar potential",
}

MODELS: dict[str, str] = LATERAL_MODELS | MAGNETIC_MODELS


def gives(model: str, quantity: str) -> bool:
    """Return whether a model can compute a quantity."""
    return (model in MAGNETIC_MODELS) == QUANTITIES[quantity].magnetic
