"""The stray field between normal actuators by permeances: the network's estimate.

Heads face each other across the gap that the pitch leaves, two parallel cylinders,
P = µ0 π l / arcosh(p / 2R) (the capacitance of two wires; W. R. Smythe, Static and Dynamic
Electricity, 3rd ed., section 4.14), l the head's thickness; the sleeves, much longer, are taken
as one.  Where neighbours' polarities alternate, a plane of symmetry half way is neutral and each
of the four neighbours takes 2 P of a head's flux past its working gap; where all are equal no
flux goes over.  Beside the circuit of one actuator that is one permeance more.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from tactgen.geometry.arrays import Floats
from tactgen.geometry.device.parameters import Device, Display
from tactgen.geometry.device.steel_law import MU0
from tactgen.geometry.errors import InputError
from tactgen.tmm.reluctance.circuit import CELLS, FULL, circuit
from tactgen.tmm.reluctance.flux_ladder import Ladder, LadderSolution, solve

#: Nearest neighbours in a square array.
NEIGHBOURS = 4
#: Share of the working gap's permeance with which its loss to a small further one is measured.
_SMALL = 1e-3


@dataclass(frozen=True)
class NetworkForces:
    """Pulls (N) at one current and gap, by the network.

    Attributes
    ----------
    same, alternating : float
        Of one in an endless array, polarities equal or alternating.
    single : float
        Of one of the display's middle units, driven alone among others without current.
    """

    same: float
    alternating: float
    single: float


def between_heads(device: Device, pitch: float) -> float:
    """Return the permeance (H) between the heads of two neighbours.

    Raises
    ------
    InputError
        If the heads touch.
    """
    radius = device.rod.head_radius
    if pitch <= 2.0 * radius:
        raise InputError(
            f"display.pitch = {1e3 * pitch:g} mm lets heads of {2e3 * radius:g} mm touch; set "
            "display.pitch to more than that"
        )
    return float(MU0 * math.pi * device.rod.head_thickness / math.acosh(0.5 * pitch / radius))


def network_forces(
    device: Device, display: Display, current: float, gap: float, cells: int = CELLS
) -> NetworkForces:
    """Return the pulls of the display's units at a current (A) and gap (m).

    Raises
    ------
    InputError
        If the parts cannot form the circuit, or the heads touch.
    """
    over = between_heads(device, display.pitch)
    alone = circuit(device, np.array([gap]), FULL, cells)
    pull = _force(_solved(alone, current))
    alternating = _force(_solved(beside(alone, 2.0 * NEIGHBOURS * over), current))
    return NetworkForces(pull, alternating, _one_driven(alone, current, pull, display, over))


def beside(ladder: Ladder, permeance: float) -> Ladder:
    """Return a circuit with a permeance (H) parallel to its working gap, which pulls nothing."""
    top, slope = ladder.reluctance[:, -1], ladder.d_reluctance[:, -1]
    joined = 1.0 / (1.0 / top + permeance)
    reluctance, d_reluctance = ladder.reluctance.copy(), ladder.d_reluctance.copy()
    reluctance[:, -1] = joined
    d_reluctance[:, -1] = slope * (joined / top) ** 2
    return replace(ladder, reluctance=reluctance, d_reluctance=d_reluctance)


def _solved(ladder: Ladder, current: float) -> LadderSolution:
    return solve(ladder, np.array([current]))


def _force(found: LadderSolution) -> float:
    return float(found.force[0, 0])


def _one_driven(alone: Ladder, current: float, pull: float, display: Display, over: float) -> float:
    """Return the pull (N) of one driven unit among others without current, heads as nodes.

    A unit's permeance from head to sleeve, its iron and winding's path included, is what halves
    the head's magnetic voltage when as much is put beside it.
    """
    gap = 1.0 / float(alone.reluctance[0, -1])
    less = _force(_solved(beside(alone, _SMALL * gap), current))
    if pull <= 0.0:
        return 0.0
    own = _SMALL * gap / (math.sqrt(pull / less) - 1.0)
    levels = head_levels(display, over / own)
    at = (display.rows - 1) // 2 * display.columns + (display.columns - 1) // 2
    return pull * float(levels[at]) ** 2


def head_levels(display: Display, ratio: float) -> Floats:
    """Return all heads' magnetic voltages (units,) over that of the driven middle one if alone.

    `ratio` is the permeance between two heads over a unit's own.
    """
    count = display.rows * display.columns
    nodes = np.eye(count)
    for i in range(count):
        row, column = divmod(i, display.columns)
        following = [i + 1] if column + 1 < display.columns else []
        following += [i + display.columns] if row + 1 < display.rows else []
        for j in following:
            nodes[[i, j], [i, j]] += ratio
            nodes[[i, j], [j, i]] -= ratio
    source = np.zeros(count)
    source[(display.rows - 1) // 2 * display.columns + (display.columns - 1) // 2] = 1.0
    return np.asarray(np.linalg.solve(nodes, source))
