"""The paper's large signals under the load that they were measured with: 50 g on imitation skin.

No number of the pad was fitted to these measurements: each has its own source or assumption
(``load.pad_*``), and what their ranges do is said in the rows.  The paper states spans and the
steepness of fitted lines; of these lines it prints no sign.
"""

from __future__ import annotations

from functools import cache, partial

import numpy as np

from tactgen.geometry.arrays import Floats
from tactgen.validation.engine.solve import solve
from tactgen.validation.evidence.case import Check
from tactgen.validation.models.backbone import STATES, State
from tactgen.validation.scene.scene import load_scene

#: What the scene is in both states: the pad, and a sixteenth of the 50 g on each tip.
_PAD = ("load.kind=pad", "load.normal_force=30.65mN", "support.kind=contact")
_FREQUENCIES = "frequency=10:1000:300"
_PRINT = "three printed digits and the plot's width"


@cache
def _sizes(state: State) -> tuple[Floats, Floats]:
    """Frequencies (Hz) and the tip's displacement (m) at 50 V, the contact linear."""
    scene, _ = load_scene("paper", (_FREQUENCIES, *_PAD, *STATES[state]))
    found = solve(scene, ("tmm",), ("tip_displacement",)).get("tip_displacement", "tmm")
    return np.asarray(scene.frequency), np.abs(found.value)


def extreme(state: State, which: str) -> float:
    """Largest or smallest displacement from 10 to 1000 Hz (m)."""
    sizes = _sizes(state)[1]
    return float(sizes.max() if which == "largest" else sizes.min())


def steepness(state: State) -> float:
    """Magnitude of the slope of the line fitted to the displacement (m/Hz)."""
    return abs(float(np.polyfit(*_sizes(state), 1)[0]))


_UP: State = "not activated"
_HELD: State = "held"
_ASSUMED = "the rubber is assumed, the paper says crash dummy; from Shore A 40 to a gel "
_WHERE = (
    "; the paper measured below the finger's support plate, not at the tip, and the contact is "
    "linear here, although 50 V make the head rock"
)
_ROWS = (
    (1, _UP, "largest deflection", 24.8e-6, "m", partial(extreme, _UP, "largest"),
     _ASSUMED + "15 to 117 um", -0.1650),
    (2, _UP, "smallest deflection", 3.1e-6, "m", partial(extreme, _UP, "smallest"),
     "it is a minimum near 745 Hz; over the ranges of the pad 0.7 to 9 um", 0.0600),
    (3, _UP, "steepness of the line fitted to it, which falls", 1.164e-8, "m/Hz",
     partial(steepness, _UP), _ASSUMED + "0.4e-8 to 4.8e-8 m/Hz", -0.6737),
    (4, _HELD, "largest deflection", 72.4e-6, "m", partial(extreme, _HELD, "largest"),
     "it is a resonance near 1 kHz; over the range of the loss factor 37 to 185 um", -0.1339),
    (5, _HELD, "smallest deflection", 13.6e-6, "m", partial(extreme, _HELD, "smallest"),
     _ASSUMED + "14 to 39 um", 0.8894),
    (6, _HELD, "steepness of the line fitted to it, which rises", 3.441e-8, "m/Hz",
     partial(steepness, _HELD), "it follows the height of that resonance", -0.2577),
)  # fmt: skip

PAD_CHECKS: tuple[Check, ...] = tuple(
    Check(
        f"PAD-{number}", "validation",
        f"On imitation skin under 50 g at 50 V, {state}, 10 to 1000 Hz: the {what}.",
        reference, unit, f"paper section 6, Fig 15 {'left' if state == _UP else 'right'}",
        0.02 if unit == "m" else 2e-4, _PRINT, measure,
        scene="paper", explained=why + _WHERE, known=known,
    )
    for number, state, what, reference, unit, measure, why, known in _ROWS
)  # fmt: skip
