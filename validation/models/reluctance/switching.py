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
from tactgen.tmm.reluctance.coenergy_map import CoenergyMap
from tactgen.tmm.reluctance.switching import spring_force, switching
from tactgen.validation.engine.results import Estimate


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
    floats: bool  #: Whether the rod comes to rest between the stops before it pulls in
    beyond_table: float  #: The largest of the points that were solved, see :class:`MagneticPoint`
    limit: float  #: The largest current that was looked at
    method: str = (
        "error bar of the force there, over the force's slope with current; on a floating place "
        "also what the place is uncertain by"
    )


def switching_currents(device: Device, pull: CoenergyMap, at: Solver) -> SwitchingCurrents:
    """Switching currents of a model by its map and by points of it.

    Raises InputError if the stops do not fit the gap or the map.
    """
    found = Balances(device, pull, at)
    return SwitchingCurrents(
        lift_off=found.lift_off,
        pull_in=found.pull_in,
        holding=found.holding,
        drop_out=found.drop_out,
        floats=found.floats,
        beyond_table=found.beyond_table,
        limit=found.limit,
    )


class Balances:
    """What :class:`SwitchingCurrents` has, each current solved for when it is read.

    By currents at which pull and spring balance, from points; each gap is solved once.
    """

    method = SwitchingCurrents.method

    def __init__(self, device: Device, pull: CoenergyMap, at: Solver) -> None:
        self._device, self._pull, self._at = device, pull, at
        self._by_map = switching(device, pull)
        self._found: dict[float, Estimate] = {}
        self.beyond_table, self.limit = 0.0, pull.current_limit

    @property
    def floats(self) -> bool:
        """Whether the rod leaves the upper stop for a place between the stops."""
        return self._by_map.pull_in > self._by_map.lift_off * (1.0 + 1e-9)

    @property
    def lift_off(self) -> Estimate:
        """Current at which the rod leaves its upper stop (A)."""
        return self.at_gap(self._device.gap, self._by_map.lift_off)

    @property
    def pull_in(self) -> Estimate:
        """Current that draws the rod to its lower stop (A)."""
        return self.extreme(self._by_map.pull_in_gap, self._by_map.pull_in)

    @property
    def holding(self) -> Estimate:
        """Least current that holds the rod at its lower stop (A)."""
        return self.at_gap(self._device.spring.stop_gap, self._by_map.holding)

    @property
    def drop_out(self) -> Estimate:
        """Current below which the rod is back at its upper stop (A)."""
        return self.extreme(self._by_map.drop_out_gap, self._by_map.drop_out)

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
