"""Where the rod rests at the coil's current: looked up in the map, then solved for at its gap."""

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
from tactgen.tmm.reluctance.coenergy.map import CoenergyMap
from tactgen.validation.engine.results import Measured, MeasuredList
from tactgen.validation.models.reluctance.point import MagneticPoint


@storable
@dataclass(frozen=True)
class RestingState:
    """The rod at rest at one current.

    Attributes
    ----------
    position, finger_force, contact_force : Measured
        See :class:`tmm.generator.positions.RestingPlace`; m and N.
    places : MeasuredList
        All resting positions (m) by the map alone, from the top down, by their kind.
    kind : str
        Of the place that the rod takes.
    beyond_table : float
        See :class:`MagneticPoint`.
    """

    position: Measured
    finger_force: Measured
    contact_force: Measured
    places: MeasuredList
    kind: str
    beyond_table: float
    method: str = (
        "error bar of the pull there, in positions over the axial stiffness; of all resting "
        "positions the map's error between its samples"
    )


@dataclass(frozen=True)
class _Corrected:
    """A map's pull, moved by what a single point says more at one place (N)."""

    map: CoenergyMap
    more: float

    @property
    def gap_limits(self) -> tuple[float, float]:
        return self.map.gap_limits

    def force(self, current: Floats | float, gap: Floats | float) -> Floats:
        return np.asarray(self.map.force(current, gap) + self.more)

    def force_gradient(self, current: Floats | float, gap: Floats | float) -> Floats:
        return self.map.force_gradient(current, gap)


def resting_state(
    device: Device,
    pull: CoenergyMap,
    at: Callable[[float, float], MagneticPoint],
    history: History,
    pressed: float,
) -> RestingState:
    """Return where the rod rests by a model's map and one point of it.

    Parameters
    ----------
    at : callable
        Solves one current (A) at one gap (m).
    history : {"rising", "falling"}
        How the current came to the coil's.
    pressed : float
        Force of a finger that presses the tip down (N).

    Raises
    ------
    InputError
        If it rests nowhere.
    """
    current = abs(device.coil.current)
    by_map = axial_forces(device, pull, pressed)
    first = resting_place(by_map, current, history)
    gap = float(by_map.gap(first.lift))
    point = at(current, gap)
    more = point.force.value - float(pull.force(current, gap))
    corrected = axial_forces(device, _Corrected(pull, more), pressed)
    place = resting_place(corrected, current, history)
    bar = point.force.bar
    held = "stop" in place.kind
    return RestingState(
        position=Measured(place.lift, bar / abs(place.stiffness)),
        finger_force=Measured(place.finger_force, bar),
        contact_force=Measured(place.contact_force, bar if held else 0.0),
        places=_places(by_map, pull, current),
        kind=place.kind,
        beyond_table=point.beyond_table,
    )


def position_bar(
    forces: AxialForces, pull: CoenergyMap, current: float, place: RestingPlace
) -> float:
    """Return how far (m) the map's own error moves a resting place."""
    return pull.interpolation_error.force * abs(
        float(pull.force(current, forces.gap(place.lift))) / place.stiffness
    )


def _places(forces: AxialForces, pull: CoenergyMap, current: float) -> MeasuredList:
    found = resting_places(forces, current)
    return MeasuredList(
        np.array([place.lift for place in found]),
        np.array([position_bar(forces, pull, current, place) for place in found]),
        tuple(place.kind for place in found),
    )
