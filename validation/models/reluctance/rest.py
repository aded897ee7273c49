"""Equilibrium of the rod at the coil's current: looked up in the map, then solved for.

A map is a percent or two off between its samples, which often decides whether the rod is still up.
Where its error leaves this open the model is solved at the position that the rod would leave.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from tactgen.geometry.arrays import Floats
from tactgen.geometry.device.parameters import Device
from tactgen.geometry.store.values import storable
from tactgen.tmm.generator.positions import (
    AxialForces,
    History,
    RestingPlace,
    axial_forces,
    resting_place,
    resting_places,
)
from tactgen.tmm.reluctance.coenergy_map import CoenergyMap
from tactgen.validation.engine.results import Estimate
from tactgen.validation.models.reluctance.switching import MagneticPoint

#: Share of the stroke within which a point's correction of the map holds; far more than a stop
#: gives way (0.01), far less than from one place to another.
_NEAR = 0.05
#: Places that a rod can pass: upper stop, one that floats, lower stop; and the one it takes.
_MOST_PLACES = 4


@storable
@dataclass(frozen=True)
class RestingState:
    """The rod at rest at one current."""

    #: See :class:`tmm.generator.positions.RestingPlace`; m and N
    position: Estimate
    finger_force: Estimate
    contact_force: Estimate
    #: All resting positions (m) by the map alone, from the top down, by their kind
    places: Estimate
    kind: str  #: Of the place that the rod takes
    beyond_table: float  #: See :class:`MagneticPoint`
    method: str = (
        "error bar of the pull there, in positions over the axial stiffness; of all resting "
        "positions the map's error between its samples"
    )


@dataclass(frozen=True)
class _Corrected:
    """A map's pull, some times as large, moved by what a single point says at one place (N)."""

    map: CoenergyMap
    more: float = 0.0
    times: float = 1.0

    @property
    def gap_limits(self) -> tuple[float, float]:
        return self.map.gap_limits

    def force(self, current: Floats | float, gap: Floats | float) -> Floats:
        return np.asarray(self.times * self.map.force(current, gap) + self.more)

    def force_gradient(self, current: Floats | float, gap: Floats | float) -> Floats:
        return self.times * self.map.force_gradient(current, gap)


def resting_state(
    device: Device,
    pull: CoenergyMap,
    at: Callable[[float, float], MagneticPoint],
    history: History,
    pressed: float,
) -> RestingState:
    """Where the rod rests by a model's map and one point of it.

    Parameters
    ----------
    at : callable
        Solves one current (A) at one gap (m).
    history : {"rising", "falling"}
        How the current came to the coil's.
    pressed : float
        Force of a finger that presses the tip down (N).

    Raises InputError if it rests nowhere.
    """
    current = abs(device.coil.current)
    by_map = axial_forces(device, pull, pressed)
    near = _NEAR * by_map.stops.stroke
    passed = np.inf
    place = resting_place(by_map, current, history)
    before = _left_last(device, pull, history, pressed)
    if abs(before.lift - place.lift) > near:
        place = before
    for _ in range(_MOST_PLACES):
        asked, gap = place, float(by_map.gap(place.lift))
        point = at(current, gap)
        more = point.force.value - float(pull.force(current, gap))
        corrected = axial_forces(device, _Corrected(pull, more), pressed)
        place = _taken(corrected, current, history, passed)
        if abs(place.lift - asked.lift) <= near:
            break
        # what a point says at one stop says nothing of the other: the rod has left that one
        passed = _onwards(asked.lift, history) - near
    bar = point.force.error
    held = "stop" in place.kind
    return RestingState(
        position=Estimate(place.lift, bar / abs(place.stiffness)),
        finger_force=Estimate(place.finger_force, bar),
        contact_force=Estimate(place.contact_force, bar if held else 0.0),
        places=_places(by_map, pull, current),
        kind=place.kind,
        beyond_table=point.beyond_table,
    )


def _left_last(device: Device, pull: CoenergyMap, history: History, pressed: float) -> RestingPlace:
    """Where the rod may rest yet as far as the map's error goes, before it moves on."""
    error = pull.interpolation_error.force
    times = 1.0 - error if history == "rising" else 1.0 + error
    forces = axial_forces(device, _Corrected(pull, times=times), pressed)
    return resting_place(forces, abs(device.coil.current), history)


def _taken(forces: AxialForces, current: float, history: History, passed: float) -> RestingPlace:
    """First stable place that the rod has not passed, on its way with the current."""
    stable = [place for place in resting_places(forces, current) if place.stable]
    way = stable if history == "rising" else stable[::-1]
    return next((p for p in way if _onwards(p.lift, history) <= passed), way[-1])


def _onwards(lift: float, history: History) -> float:
    """Lift (m) counted so that it falls on the rod's way: down while the current rises."""
    return lift if history == "rising" else -lift


def position_bar(
    forces: AxialForces, pull: CoenergyMap, current: float, place: RestingPlace
) -> float:
    """How far (m) the map's own error moves a resting place."""
    return pull.interpolation_error.force * abs(
        float(pull.force(current, forces.gap(place.lift))) / place.stiffness
    )


def _places(forces: AxialForces, pull: CoenergyMap, current: float) -> Estimate:
    found = resting_places(forces, current)
    return Estimate(
        np.array([place.lift for place in found]),
        np.array([position_bar(forces, pull, current, place) for place in found]),
        classes=tuple(place.kind for place in found),
    )
