"""What holds the rod and what drives its coil, over the ranges that the keys allow."""

from __future__ import annotations

from tactgen.validation.checks.stress.driven.sweep import Pair, Sweep, decades

_AT = ("load.kind=none", "frequency=10 Hz,500 Hz,2000 Hz")
_BELOW = (*_AT, "coil.current=50 mA", "coil.history=falling")
#: A finger presses the tip down; its own law is asked for inside its range.
_PRESSED = ("frequency=10 Hz,500 Hz,1000 Hz",)
_TILTED = (*_AT, "spring.eccentricity=0.3 mm")

#: The contact of the lower stop, on a rod held down; the bore's play and springs, the head upright
#: and tilted; springs down to those that cannot hold the rod up.
HELD: tuple[Sweep, ...] = (
    Sweep(
        "the lower stop's own stiffness", "eight decades of decay length: a ratio of 1e-3 to 1e3 "
        "of 0.1 um, then of 10 um",
        (
            *decades("contact.lower_decay_ratio", "", -3, 3, *_BELOW, "contact.decay_length=0.1um"),
            *decades("contact.lower_decay_ratio", "", 2, 3, *_BELOW, "contact.decay_length=10um"),
        ),
    ),
    Sweep(
        "the lower stop's own damping", "ratios of 1e-3 to 1e3, and no damping at all",
        (
            *decades("contact.lower_relaxation_ratio", "", -3, 3, *_BELOW, step=2),
            ("none", (*_BELOW, "contact.relaxation_time=0 s", "guide.axial_damping=0 N*s/m")),
        ),
    ),
    Sweep(
        "clearance of the bore", "none, 1 nm to 10 m, upright and tilted",
        (
            ("none", (*_AT, "guide.clearance=0 m")),
            *decades("guide.clearance", "m", -9, 1, *_AT, step=5),
            *decades("guide.clearance", "m", -9, 1, *_TILTED, step=2),
        ),
    ),
    Sweep(
        "springs of the bore", "1e-12 to 1e9 N m/rad, with play and a tilted head",
        tuple(decades("guide.rotational_stiffness", "N*m/rad", -12, 9, *_TILTED,
                      "guide.clearance=0.1 um", step=3)),
    ),
    Sweep(
        "a finger that the spring cannot hold", "1 uN to 1 kN on the tip against 110 mN",
        tuple(decades("load.normal_force", "N", -6, 3, *_PRESSED)), quick=(0, 5, -1),
    ),
    Sweep(
        "return spring", "0, then 1e-6 to 1e6 N/m",
        (
            ("none", (*_AT, "spring.stiffness=0 N/m")),
            *decades("spring.stiffness", "N/m", -6, 6, *_AT, step=2),
        ),
    ),
)  # fmt: skip

_CIRCUIT = (*_BELOW, "coil.supply=voltage")
#: The coil's circuit, driven by a voltage: time constants over more than eight decades.
DRIVEN: tuple[Sweep, ...] = (
    Sweep(
        "stiff circuit: resistance", "1e-9 to 1e9 ohm in the leads",
        tuple(decades("coil.source_resistance", "ohm", -9, 9, *_CIRCUIT, step=3)),
    ),
    Sweep(
        "stiff circuit: turns", "1 to 1e4 turns at the same ampere-turns, which is eight decades "
        "of inductance",
        tuple(
            (f"{10**n} turns", (*_AT, "coil.supply=voltage", f"coil.turns={10**n}",
                                f"coil.current={28 / 10**n:g} A", "coil.history=falling"))
            for n in range(5)
        ),
    ),
)  # fmt: skip
CIRCUIT_PAIR = Pair(
    "tmm", "beam",
    ("axial_tip_per_coil_voltage", "coil_impedance", "lateral_tip_per_voltage"), "generator",
)  # fmt: skip
