"""The checks of motion over time as declarative rows; see :mod:`validation.checks.row`."""

from __future__ import annotations

import math

from tactgen.validation.checks import motion_measurements as m
from tactgen.validation.checks.row import Check

_ELLIPTIC = "complete elliptic integral: 4 √(m/(k + k₃A²)) K(m), of ANSYS VM156"
_VM207 = "U/R (1 − exp(−R t/L)) of ANSYS VM207: 12 V on 5.991 Ω and 12.74 mH after 10 ms"
_FIG16 = "paper, section 6, text on Fig 16"
_READ = "the text gives whole milliseconds, so half of one either way"

MOTION_CHECKS: tuple[Check, ...] = (
    Check(
        "MOT-1", "code verification",
        "A mass on a hardening spring swings in its exact period.",
        0.144043869, "s", _ELLIPTIC, 5e-7, "1600 steps of 25 us: (ω h)²/12", m.vm156_period,
    ),
    Check(
        "MOT-2", "code verification",
        "A stepped voltage fills a coil with current.",
        12.0 / 5.991 * -math.expm1(-0.01 * 5.991 / 0.01274), "A", _VM207, 1e-6,
        "500 steps: (R h/L)²/12 of the exponent 4.7, of whose exponential 0.9 % is left, 3e-7",
        m.vm207_current,
    ),
    Check(
        "MOT-3", "code verification",
        "A mass leaves rough surfaces without loss at the speed at which it met them.",
        0.3, "m/s", "conservation of energy", 1e-6, "the surfaces' energy at the start, e^-33",
        m.rough_bounce,
    ),
    Check(
        "MOT-4", "solution verification",
        "The generator's energy is what its sources gave less what was lost.",
        (0.0, 1e-10), "1", "first law", 0.0, "rounding; relative to all that was exchanged",
        m.generator_imbalance, scene="generator",
    ),
    Check(
        "MOT-5", "validation",
        "The 120 mA of Fig 16 pull the reconstructed rod down against its preload.",
        (0.0, 0.12), "A", _FIG16, 0.0, "enough is enough", m.pull_in_current, scene="generator",
        explained="by the field it takes 129.7 mA, as the device was reconstructed from another "
        "statement (PAP-11); the runs of the following rows rest on the network, by which 118.5 mA "
        "are enough because its pull is 12 % too large here (NET-F1)",
        known=0.081,
    ),
    Check(
        "MOT-6", "validation",
        "Switched off, the rod is on its upper stop about 1 ms later (3 to 4 ms in the text).",
        (0.5e-3, 1.5e-3), "s", _FIG16, 0.0, _READ, m.rise_time, heavy=True, scene="generator",
    ),
    Check(
        "MOT-7", "validation",
        "Switched on, the rod is on its lower stop about 2 ms later (7 to 9 ms in the text).",
        (1.5e-3, 2.5e-3), "s", _FIG16, 0.0, _READ, m.fall_time, heavy=True, scene="generator",
    ),
    Check(
        "MOT-8", "validation",
        "Under the finger the tip moves less while the rod flies than on either stop, least while "
        "it rises.",
        (0.0, 1.0), "1", _FIG16, 0.0, "an order, no sizes are given", m.flight_to_contact,
        heavy=True, scene="generator",
    ),
    Check(
        "MOT-9", "validation",
        "Under the finger the tip answers its drive more on the lower stop than on the upper one.",
        (1.0, 10.0), "1", _FIG16, 0.0,
        "an order, no sizes are given; taken is what two runs, their drives a quarter of a period "
        "apart, have in common at 200 Hz beside straight lines: after the blow on the upper stop "
        "the finger lets the tip drift for milliseconds, which is no oscillation",
        m.held_to_pressed,
        heavy=True, scene="generator",
    ),
    Check(
        "MOT-10", "validation",
        "So it does in small motions about both places of rest.",
        (1.0, 10.0), "1", _FIG16, 0.0,
        "an order, no sizes are given; a contact is stiff in proportion to what presses it",
        m.small_held_to_pressed, scene="generator",
    ),
    Check(
        "MOT-11", "code verification",
        "The coil's current after 10 ms is printed as 1.9849 A.",
        1.9849, "A", "ANSYS VM207, target as printed", 2.5e-5, "half a unit of the fifth digit",
        m.vm207_current,
        explained="the closed form of row MOT-2 is 1.98483 A: the last printed digit is one too "
        "high",
        known=-3.4e-5,
    ),
)  # fmt: skip
