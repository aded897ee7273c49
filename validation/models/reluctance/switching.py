"""The actuator at a point, and the currents at which the rod moves: looked up, then solved for.

The map says where the rod gets stuck and at about which current.  There the secant method finds
the current at which the model's own force balances the spring; its error in force over the slope
of the force with the current is that of the current.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from tactgen.geometry.device.parameters import Device
from tactgen.geometry.store.values import storable
from tactgen.tmm.generator.equilibrium import (
    AxialForces,
    History,
    RestingPlace,
    axial_forces,
    resting_place,
    resting_places,
)
from tactgen.tmm.reluctance.coenergy_map import CoenergyMap
from tactgen.tmm.reluctance.switching import spring_force, switching
from tactgen.validation.models.model import Estimate


@storable
@dataclass(frozen=True)
class MagneticPoint:
    """The actuator at one current (A) and gap (m)."""

    current: float
    gap: float
    #: SI units; the pull is positive when it closes the gap
    force: Estimate
    flux_linkage: Estimate
    coenergy: Estimate
    incremental_inductance: Estimate
    method: str  #: How the error bars come about
    #: Share of the iron's volume that lies beyond the end of a magnetisation curve that ends before
    #: the steel is saturated
    beyond_table: float
    #: The pull by the stress in the air (N), where the model's own is by virtual work; nan
    #: elsewhere
    force_by_stress: float = math.nan

    @property
    def inductance(self) -> Estimate:
        """Apparent inductance λ/i (H), its limit ∂λ/∂i at zero current."""
        if self.current == 0.0:
            return self.incremental_inductance
        linkage = self.flux_linkage
        return Estimate(linkage.value / self.current, linkage.error / abs(self.current))


#: Solves one current (A) at one gap (m).
Solver = Callable[[float, float], MagneticPoint]

#: Most points that one balance may take; two or three are usual.
_MOST_POINTS = 6
#: A balance has settled when the force is off by no more than this share of its error bar, or
#: this share of the spring's force, whichever is more.
_OF_BAR, _OF_FORCE = 0.1, 1e-9
#: Distance of the points on both sides of a floating place, as a share of the stroke: the map
#: finds that place to a few percent.
_ASIDE = 0.05

_NONE = Estimate(math.nan, math.nan)


@storable
@dataclass(frozen=True)
class SwitchingCurrents:
    """Currents at which the rod moves (A), see :class:`tmm.reluctance.switching.Switching`."""

    #: nan where no current of the map does it
    lift_off: Estimate
    pull_in: Estimate
    holding: Estimate
    drop_out: Estimate
    beyond_table: float  #: The largest of the points that were solved, see :class:`MagneticPoint`
    limit: float  #: The largest current that was looked at
    method: str = (
        "error bar of the force there, over the force's slope with current; on a floating place "
        "also what the place is uncertain by"
    )

    @property
    def floats(self) -> bool:
        """Whether the rod comes to rest between the stops before it pulls in."""
        return bool(self.pull_in.value > self.lift_off.value * (1.0 + 1e-9))


def switching_currents(device: Device, pull: CoenergyMap, at: Solver) -> SwitchingCurrents:
    """Switching currents of a model by its map and by points of it.

    Raises InputError if the stops do not fit the gap or the map.
    """
    by_map, balances = switching(device, pull), _Balances(device, pull, at)
    return SwitchingCurrents(
        lift_off=balances.at_gap(device.gap, by_map.lift_off),
        pull_in=balances.extreme(by_map.pull_in_gap, by_map.pull_in),
        holding=balances.at_gap(device.spring.stop_gap, by_map.holding),
        drop_out=balances.extreme(by_map.drop_out_gap, by_map.drop_out),
        beyond_table=balances.beyond_table,
        limit=pull.current_limit,
    )


class _Balances:
    """Currents at which pull and spring balance, from points; each gap is solved once."""

    def __init__(self, device: Device, pull: CoenergyMap, at: Solver) -> None:
        self._device, self._pull, self._at = device, pull, at
        self._found: dict[float, Estimate] = {}
        self.beyond_table = 0.0

    def at_gap(self, gap: float, start: float) -> Estimate:
        """Balance at `gap` near the map's current `start` (A), inf for none."""
        if not math.isfinite(start):
            return _NONE
        if gap not in self._found:
            self._found[gap] = self._secant(gap, start)
        return self._found[gap]

    def extreme(self, gap: float, start: float) -> Estimate:
        """Balance where it is largest or smallest, which the map says is at `gap`.

        At a stop it is the balance there.  Between them it is the vertex of the parabola
        through three balances around, whose distance from the nearest is added to the bar.
        """
        low, high = self._device.spring.stop_gap, self._device.gap
        if gap in (low, high) or not math.isfinite(start):
            return self.at_gap(gap, start)
        step = _ASIDE * (high - low)
        middle = min(max(gap, low + step), high - step)
        gaps = middle + step * np.array([-1.0, 0.0, 1.0])
        around = [self.at_gap(float(g), start) for g in gaps]
        left, centre, right = (found.value for found in around)
        if not math.isfinite(left + centre + right):  # the pull falls with the current nearby
            return around[1]
        bend = left - 2.0 * centre + right
        shift = float(np.clip(0.5 * (left - right) / bend, -1.0, 1.0)) if bend else 0.0
        value = centre + 0.5 * shift * (right - left) + 0.5 * shift**2 * bend
        nearest = around[1 + round(shift)]
        return Estimate(value, nearest.error + abs(value - nearest.value))

    def _secant(self, gap: float, start: float) -> Estimate:
        against = float(spring_force(self._device, gap))
        if against == 0.0:  # no pull without current
            return Estimate(0.0, 0.0)
        current, slope = start, -float(self._pull.motional_coefficient(start, gap))
        before: tuple[float, float] | None = None
        for _ in range(_MOST_POINTS):
            point = self._at(current, gap)
            self.beyond_table = max(self.beyond_table, point.beyond_table)
            miss = point.force.value - against
            if before is not None and current != before[0]:
                slope = (miss - before[1]) / (current - before[0])
            if not slope > 0.0:
                return _NONE
            step = -miss / slope
            settled = abs(miss) <= max(_OF_BAR * point.force.error, _OF_FORCE * against)
            # a first point that settles needs a slope that is known
            if settled and before:
                return Estimate(current + step, point.force.error / slope + abs(step))
            before = current, miss
            # a slope that is far off must not turn the current round
            current = max(current + step, 0.5 * current)
        return _NONE


#: Share of the stroke within which a point's correction of the map holds; far more than a stop
#: gives way (0.01), far less than from one place to another.
_NEAR = 0.05
#: Places that a rod can pass: upper stop, one that floats, lower stop; and the one it takes.
_MOST_PLACES = 4


@storable
@dataclass(frozen=True)
class RestingState:
    """The rod at rest at one current."""

    #: See :class:`tmm.generator.equilibrium.RestingPlace`; m and N
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


def resting_state(
    device: Device, pull: CoenergyMap, at: Solver, history: History, pressed: float
) -> RestingState:
    """Where the rod rests by a model's map and one point of it.

    `at` solves the point, for a current (A) and a gap (m); `history` is how the current came to
    the coil's, `pressed` the force of a finger that presses the tip down (N).

    Raises InputError if it rests nowhere.
    """
    from tactgen.validation.models.small_signal import ScaledMap  # which needs the network

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
        corrected = axial_forces(device, ScaledMap(pull, more=more), pressed)
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
    from tactgen.validation.models.small_signal import ScaledMap

    error = pull.interpolation_error.force
    times = 1.0 - error if history == "rising" else 1.0 + error
    forces = axial_forces(device, ScaledMap(pull, times), pressed)
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
    """Error (m) of an equilibrium from the map's error."""
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
