"""Which shaft, bore and coil pull with the paper's force at its current and stay coolest.

Shaft, coil and sleeve share 1.15 mm of radius.  A thin shaft saturates, a thick one leaves no
window; a thin sleeve saturates, a thick one likewise.  A long coil has the larger window, but the
flux that leaks from shaft to sleeve all along it saturates the shaft before the gap gets its share.
Ampere-turns at the stated pull-in current are what the pull needs; the current that the paper
holds the rod with then heats the coil in proportion to their square over the window.  Least heat
is the aim: of all devices that fit the paper's words, the one whose coil most plausibly survives.

What is not searched follows rules stated in :class:`Rules`.  The network ranks, in
milliseconds; the field, half a second to a candidate, decides (:data:`Pull`).
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
from tactgen.validation.studies.reconstruction import stated

#: Pull (n,) in N at currents (n,) in A and the stated gap.
Pull = Callable[[Device, Floats], Floats]

#: Turns while searching: only ampere-turns count.
_TURNS = 560.0
#: Ampere-turns among which the needed ones are looked for by the network.
_TRIED = np.geomspace(20.0, 1200.0, 24)
#: Cells of the network's ladder while searching; the last percent is the field's matter.
_CELLS = 6
#: Polynomial order of the field while searching: 1 % of the force.
_ORDER = 3
#: Thinnest coil and sleeve (m) that is still built.
_THINNEST = 0.08e-3


@dataclass(frozen=True)
class Rules:
    """What is assumed and not searched (m): room to make and to move the parts.

    Attributes
    ----------
    flange_clearance, coil_clearance : float
        Radial, in the bore.
    coil_top : float
        Below the sleeve's top at the stated gap: the nearer, the less leaks above the coil.
    flange_below : float
        The flange's top below the coil.
    flange_thickness, spring_room : float
        Guide of the rod; what of the sleeve houses the spring below the rod.
    """

    flange_clearance: float = 50e-6
    coil_clearance: float = 60e-6
    coil_top: float = 60e-6
    flange_below: float = 40e-6
    flange_thickness: float = 3e-3
    spring_room: float = 14e-3


@dataclass(frozen=True)
class Candidate:
    """A device of the search with what it needs.

    Attributes
    ----------
    device : Device
        With a whole number of turns that gives the stated force at the stated current.
    ampere_turns : float
        That the stated force needs at the stated gap (A).
    held_power : float
        Heat of the stated holding current in the cold coil (W).
    """

    device: Device
    ampere_turns: float
    held_power: float


def actuator(radius: float, bore: float, coil_length: float, rules: Rules | None = None) -> Device:
    """Return the device with a shaft radius, a bore radius and a coil length (m); no collar."""
    room = rules or Rules()
    flange = room.coil_top + coil_length + room.flange_below
    length = flange + room.flange_thickness
    return Device(
        rod=Rod(
            radius=radius,
            flange_radius=bore - room.flange_clearance,
            flange_thickness=room.flange_thickness,
            flange_position=flange,
            length=length,
        ),
        coil=Coil(
            inner_radius=radius,
            outer_radius=bore - room.coil_clearance,
            length=coil_length,
            position=room.coil_top,
            turns=_TURNS,
        ),
        sleeve=Sleeve(inner_radius=bore, collar_radius=bore, length=length + room.spring_room),
        gap=stated.GAP,
    )


def network_pull(device: Device, currents: Floats) -> Floats:
    """Return the pull by the reluctance network."""
    found = network_samples(device, currents, np.array([stated.GAP]), cells=_CELLS)
    return found.force[:, 0]


def field_pull(device: Device, currents: Floats) -> Floats:
    """Return the pull by the axisymmetric field."""
    from tactgen.fem.magnetics.axisymmetric import solve_map

    (row,) = solve_map(device, [stated.GAP], currents.tolist(), order=_ORDER)
    return np.array([point.force for point in row])


def ampere_turns_needed(device: Device, pull: Pull) -> float:
    """Return the ampere-turns that pull with the stated force at the stated gap; inf if none do.

    The network looks for them over two decades; another model is asked around what it says.
    """
    tried = _TRIED / device.coil.turns
    needed = _crossing(tried, network_pull(device, tried))
    if pull is not network_pull and math.isfinite(needed):
        around = needed * np.array([0.9, 1.1, 1.5])
        needed = _crossing(around, pull(device, around), beyond=True)
    return float(needed * device.coil.turns)


def _crossing(currents: Floats, forces: Floats, *, beyond: bool = False) -> float:
    """Return the current of the stated force, between samples by the power law they follow."""
    x, y = np.log(currents), np.log(forces / stated.FORCE)
    if not beyond and y[-1] < 0.0:
        return math.inf
    upper = int(np.clip(np.argmax(y >= 0.0) if y[-1] >= 0.0 else y.size - 1, 1, y.size - 1))
    slope = (y[upper] - y[upper - 1]) / (x[upper] - x[upper - 1])
    return float(np.exp(x[upper] - y[upper] / slope))


def weighed(device: Device, pull: Pull) -> Candidate:
    """Return a device with the turns and the heat that the paper's currents give it."""
    needed = ampere_turns_needed(device, pull)
    if not math.isfinite(needed):
        return Candidate(device, needed, math.inf)
    turns = float(round(needed / stated.PULL_IN))
    coil = device.coil.model_copy(update={"turns": turns})
    return Candidate(
        device.model_copy(update={"coil": coil}), needed, winding(coil).power(stated.HELD)
    )


def best_with_coil(coil_length: float, pull: Pull = network_pull, steps: int = 12) -> Candidate:
    """Return the coolest device with a given coil length (m), over shaft and bore radii.

    Parameters
    ----------
    coil_length : float
        Axial length of the winding (m).
    pull : Pull
        The model that is asked.
    steps : int
        Rounds of halving: the radii are searched to 0.1 mm / 2^(steps/3).
    """
    from scipy.optimize import minimize

    def heat(radii: Floats) -> float:
        radius, bore = (float(r) * 1e-3 for r in radii)
        outer = 0.5 * stated.OUTER_DIAMETER
        window = bore - Rules().coil_clearance - radius
        if min(radius, window, outer - bore) < _THINNEST:
            return math.inf
        return weighed(actuator(radius, bore, coil_length), pull).held_power

    start = np.array([0.64, 0.95])
    corners = start + np.array([[0.0, 0.0], [0.04, 0.0], [0.0, 0.03]])
    options = {"initial_simplex": corners, "maxfev": 4 * steps, "xatol": 1e-3, "fatol": 1e-4}
    found = minimize(heat, start, method="Nelder-Mead", options=options)
    radius, bore = (float(r) * 1e-3 for r in found.x)
    return weighed(actuator(radius, bore, coil_length), pull)


def coolest(lengths: Floats, pull: Pull = network_pull, steps: int = 12) -> tuple[Candidate, ...]:
    """Return :func:`best_with_coil` for each coil length (m), the valley floor of the search."""
    return tuple(best_with_coil(float(length), pull, steps) for length in lengths)
