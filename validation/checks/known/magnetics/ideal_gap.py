"""An ideal gap that snaps shut, on the switching of the normal actuator."""

from __future__ import annotations

from functools import cache

import numpy as np

from tactgen.geometry.arrays import Floats
from tactgen.geometry.device.parameters import Device, Spring
from tactgen.geometry.device.steel_law import MU0
from tactgen.tmm.reluctance.coenergy_fit import fit
from tactgen.tmm.reluctance.coenergy_map import Samples
from tactgen.tmm.reluctance.switching import Switching, switching
from tactgen.validation.checks.case import Answer, Case, case
from tactgen.validation.checks.drawings.machines import ideal_gap

_TURNS, _AREA, _GAP, _STIFFNESS = 500.0, 4e-6, 0.2e-3, 100.0


@cache
def _snap() -> Switching:
    """Return when a rod on a spring without preload snaps: W' = µ0 N² A i²/(2 g)."""
    strength = MU0 * _TURNS**2 * _AREA
    current, gap = np.linspace(0.0, 0.03, 9), np.geomspace(0.015e-3, 0.25e-3, 48)
    inductance: Floats = np.tile(strength / gap, (current.size, 1))
    linkage = inductance * current[:, None]
    samples = Samples(
        current, gap, linkage, 0.5 * linkage**2 / strength, 0.5 * current[:, None] * linkage,
        inductance,
    )  # fmt: skip
    spring = Spring(preload=0.0, stiffness=_STIFFNESS, stop_gap=20e-6)
    return switching(Device(spring=spring, gap=_GAP), fit(samples))


CASES: tuple[Case, ...] = (
    case(
        "SNAP",
        "Rod that snaps across an ideal gap",
        "500 turns, a gap of 0.2 mm and 4 mm², iron without resistance, a spring of 100 N/m "
        "without preload: the current at which it snaps, and how far it had moved.",
        model="a co-energy map of samples of µ0 N² A i²/(2 g), and the model's switching",
        source="I² = 8 k g³/(27 µ0 N² A) at a third of the gap (the twin of electrostatic pull-in)",
        tolerance=1e-3,
        reason="the map's cubics over 48 gaps",
        answers=[
            Answer("It snaps at 13.734 mA.", 0.0137341938, "A", lambda: _snap().pull_in),
            Answer("It had moved by a third of the gap.", _GAP / 3.0, "m",
                   lambda: _GAP - _snap().pull_in_gap, 5e-3,
                   "the current is at a maximum there: an error ε of the place costs it only ε², "
                   "so the place is known to the root of the current's error at best, √(1e-5) = "
                   "3e-3"),
        ],
        setup=ideal_gap,
    ),
)  # fmt: skip
