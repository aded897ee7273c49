"""Reconstruction of dimensions that the paper does not give.

Which shaft, bore and coil pull with the paper's force at its current and stay coolest?
Shaft, coil and sleeve share 1.15 mm of radius.  A thin shaft saturates, a thick one leaves no
window; a thin sleeve saturates, a thick one likewise.  A long coil has the larger window, but the
flux that leaks from shaft to sleeve all along it saturates the shaft before the gap gets its share.
Ampere-turns at the stated pull-in current are what the magnetic force needs; the current that the
paper holds the rod with then heats the coil in proportion to their square over the window.  Least
heat is the aim: of all devices that fit the paper's words, the one whose coil most plausibly
survives.  The network ranks, in milliseconds; the field, half a second to a candidate, decides.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from tactgen.geometry.arrays import Floats
from tactgen.geometry.device.parameters import Coil, Device, Rod, Sleeve
from tactgen.geometry.device.winding import winding
from tactgen.tmm.reluctance.network import network_samples

# stated by the paper: sections 2.2 and 5.1, and Fig 3's set-up
#: Outer diameter, working gap and height of both actuators together (m).
OUTER_DIAMETER, GAP, TOTAL_HEIGHT = 2.3e-3, 0.2e-3, 41e-3
#: Force that the spring can put on the finger (N), and so what the magnet must overcome.
FORCE = 0.11
#: Currents (A): about what pulls the rod down, what holds it, what drove it in Fig 16.
PULL_IN, HELD, DRIVEN = 0.13, 0.05, 0.12

# assumed, not searched: room to make and to move the parts (m)
#: Radial, in the bore: around flange and coil.
_FLANGE_CLEARANCE, _COIL_CLEARANCE = 50e-6, 60e-6
#: Below the sleeve's top at the stated gap (the nearer, the less leaks above the coil), and from
#: the coil to the flange.
_COIL_TOP, _FLANGE_BELOW = 60e-6, 40e-6
#: Guide of the rod; what of the sleeve houses the spring below the rod.
_FLANGE_THICKNESS, _SPRING_ROOM = 3e-3, 14e-3
#: Thinnest coil and sleeve that is still built.
_THINNEST = 0.08e-3

#: Turns while searching: only ampere-turns count.
_TURNS = 560.0
#: Ampere-turns among which the network looks for the needed ones.
_TRIED = np.geomspace(20.0, 1200.0, 24)
#: Cells of the network's ladder and order of the field while searching: 1 % of the force.
_CELLS, _ORDER = 6, 3

#: Magnetic force (n,) in N at currents (n,) in A and the stated gap.
Pull = Callable[[Device, Floats], Floats]


@dataclass(frozen=True)
class Candidate:
    """Candidate device of the search."""

    #: With an integer number of turns that gives the stated force at the stated current
    device: Device
    ampere_turns: float  #: That the stated force needs at the stated gap (A)
    held_power: float  #: Heat of the stated holding current in the cold coil (W)


def actuator(radius: float, bore: float, coil_length: float) -> Device:
    """Device with a shaft radius, a bore radius and a coil length (m); no collar."""
    flange = _COIL_TOP + coil_length + _FLANGE_BELOW
    length = flange + _FLANGE_THICKNESS
    return Device(
        rod=Rod(
            radius=radius,
            flange_radius=bore - _FLANGE_CLEARANCE,
            flange_thickness=_FLANGE_THICKNESS,
            flange_position=flange,
            length=length,
        ),
        coil=Coil(
            inner_radius=radius,
            outer_radius=bore - _COIL_CLEARANCE,
            length=coil_length,
            position=_COIL_TOP,
            turns=_TURNS,
        ),
        sleeve=Sleeve(inner_radius=bore, collar_radius=bore, length=length + _SPRING_ROOM),
        gap=GAP,
    )


def network_map(device: Device, currents: Floats) -> Floats:
    """Magnetic force by the reluctance network."""
    return network_samples(device, currents, np.array([GAP]), cells=_CELLS).force[:, 0]


def field_pull(device: Device, currents: Floats) -> Floats:
    """Magnetic force by the axisymmetric field."""
    from tactgen.fem.magnetics.axisymmetric import solve_map

    (row,) = solve_map(device, [GAP], currents.tolist(), order=_ORDER)
    return np.array([point.force for point in row])


def ampere_turns_needed(device: Device, pull: Pull) -> float:
    """Ampere-turns that give the stated force at the stated gap; inf if none do.

    The network looks for them over two decades; another model is solved around its answer.
    """
    tried = _TRIED / device.coil.turns
    needed = _crossing(tried, network_map(device, tried))
    if pull is not network_map and math.isfinite(needed):
        around = needed * np.array([0.9, 1.1, 1.5])
        needed = _crossing(around, pull(device, around), beyond=True)
    return float(needed * device.coil.turns)


def _crossing(currents: Floats, forces: Floats, *, beyond: bool = False) -> float:
    """Current of the stated force, between samples by the power law they follow."""
    x, y = np.log(currents), np.log(forces / FORCE)
    if not beyond and y[-1] < 0.0:
        return math.inf
    upper = int(np.clip(np.argmax(y >= 0.0) if y[-1] >= 0.0 else y.size - 1, 1, y.size - 1))
    slope = (y[upper] - y[upper - 1]) / (x[upper] - x[upper - 1])
    return float(np.exp(x[upper] - y[upper] / slope))


def weighed(device: Device, pull: Pull) -> Candidate:
    """Device with the turns and the heat that the paper's currents give it."""
    needed = ampere_turns_needed(device, pull)
    if not math.isfinite(needed):
        return Candidate(device, needed, math.inf)
    coil = device.coil.model_copy(update={"turns": float(round(needed / PULL_IN))})
    return Candidate(device.model_copy(update={"coil": coil}), needed, winding(coil).power(HELD))


def coolest(lengths: Floats, pull: Pull = network_map, steps: int = 12) -> tuple[Candidate, ...]:
    """Coolest device with each coil length (m), the valley floor of the search.

    `steps` rounds of halving locate shaft and bore radii to 0.1 mm / 2^(steps/3).
    """
    return tuple(_best_with_coil(float(length), pull, steps) for length in lengths)


def _best_with_coil(coil_length: float, pull: Pull, steps: int) -> Candidate:
    from scipy.optimize import minimize

    def heat(radii: Floats) -> float:
        radius, bore = (float(r) * 1e-3 for r in radii)
        window = bore - _COIL_CLEARANCE - radius
        if min(radius, window, 0.5 * OUTER_DIAMETER - bore) < _THINNEST:
            return math.inf
        return weighed(actuator(radius, bore, coil_length), pull).held_power

    start = np.array([0.64, 0.95])
    corners = start + np.array([[0.0, 0.0], [0.04, 0.0], [0.0, 0.03]])
    options = {"initial_simplex": corners, "maxfev": 4 * steps, "xatol": 1e-3, "fatol": 1e-4}
    best = minimize(heat, start, method="Nelder-Mead", options=options)
    radius, bore = (float(r) * 1e-3 for r in best.x)
    return weighed(actuator(radius, bore, coil_length), pull)
