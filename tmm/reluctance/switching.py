"""Switching and finger force of the normal actuator on its spring.

Plain functions of a co-energy map, whichever model it came from.  Static and without
friction: the rod moves as soon as a force difference lets it.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from tactgen.geometry.arrays import Floats
from tactgen.geometry.device.parameters import Device
from tactgen.geometry.errors import InputError
from tactgen.tmm.reluctance.coenergy_map import CoenergyMap

#: Positions between the stops at which forces are compared, before refinement.
_POSITIONS = 101
#: Positions between the stops that the rod is shown at, and around an extreme.
_CLOSE_POSITIONS = 401
#: Currents among which the first that balances is looked for, beside the map's own.
_CURRENTS = 41

#: Halvings of a bracket: down to rounding.
_HALVINGS = 50


@dataclass(frozen=True)
class Switching:
    """Currents at which the rod moves, when the current changes slowly (A); inf if none does it."""

    lift_off: float  #: The rod leaves the upper stop: the pull there equals the preload
    #: The last stable place before the lower stop vanishes: the rod arrives there. Equal to
    #: `lift_off` if the pull outgrows the spring from the start.
    pull_in: float
    holding: float  #: Pull and spring balance at the lower stop: below it the rod leaves the stop
    drop_out: float  #: The last stable place before the upper stop vanishes: the rod is back there
    #: Gap (m) of that last place
    pull_in_gap: float
    drop_out_gap: float


def spring_force(device: Device, gap: Floats | float) -> Floats:
    """Spring's force (N), which opens the gap."""
    return np.asarray(
        device.spring.preload + device.spring.stiffness * (device.gap - np.asarray(gap))
    )


def finger_force(
    device: Device, pull: CoenergyMap, current: Floats | float, gap: Floats | float
) -> Floats:
    """Force on a finger that holds the rod at `gap`: spring less pull (N).

    Positive when the rod pushes against the finger.
    """
    return spring_force(device, gap) - pull.force(current, gap)


def balance_current(device: Device, pull: CoenergyMap, gap: Floats) -> Floats:
    """Least current (A) whose pull balances the spring at each `gap`; inf if none does.

    The least: in saturated steel the pull may fall again with more current.
    """
    gap = np.asarray(gap, dtype=float)
    flat = gap.ravel()
    against = spring_force(device, flat)
    tried = np.union1d(np.linspace(0.0, pull.current_limit, _CURRENTS), pull.samples.current)
    enough = pull.force(tried[:, None], flat) >= against
    first = np.argmax(enough, axis=0)
    low, high = tried[np.maximum(first - 1, 0)], tried[first]
    for _ in range(_HALVINGS):
        middle = 0.5 * (low + high)
        there = pull.force(middle, flat) >= against
        low, high = np.where(there, low, middle), np.where(there, middle, high)
    return np.where(enough.any(axis=0), high, np.inf).reshape(gap.shape)


def switching(device: Device, pull: CoenergyMap) -> Switching:
    """Currents at which the rod moves between its stops.

    The balance current i_b(g) tells all: rising, the rod gets past every gap whose i_b it
    exceeds, so it arrives at the largest; falling, it is back at the smallest.

    Raises InputError if the stops do not fit the gap or the map.
    """
    gaps = between_stops(device, _POSITIONS)
    needed = balance_current(device, pull, gaps)
    pull_in_gap, pull_in = _extreme(device, pull, gaps, needed, np.argmax)
    drop_out_gap, drop_out = _extreme(device, pull, gaps, needed, np.argmin)
    return Switching(
        lift_off=float(needed[-1]),
        pull_in=pull_in,
        holding=float(needed[0]),
        drop_out=drop_out,
        pull_in_gap=pull_in_gap,
        drop_out_gap=drop_out_gap,
    )


def resting_gaps(device: Device, pull: CoenergyMap, currents: Floats, *, rising: bool) -> Floats:
    """Where the rod is (m) while the current rises slowly from 0, or falls from far above.

    Rising, it stays above every gap whose balance current is larger; falling, below every
    gap whose balance current is smaller.  Currents (c,) are in A, 0 or more.
    """
    gaps = between_stops(device, _CLOSE_POSITIONS)
    needed = balance_current(device, pull, gaps)
    if rising:
        gaps, needed = gaps[::-1], needed[::-1]
    held = needed > currents[:, None] if rising else needed <= currents[:, None]
    return np.asarray(np.where(held.any(axis=1), gaps[np.argmax(held, axis=1)], gaps[-1]))


def between_stops(device: Device, count: int) -> Floats:
    """`count` gaps from the lower stop to the upper (m).

    Raises InputError if there is nothing between them.
    """
    stop = device.spring.stop_gap
    if not stop < device.gap:
        raise InputError(
            f"spring.stop_gap = {stop * 1e3:g} mm leaves no stroke below gap = "
            f"{device.gap * 1e3:g} mm; use a smaller one"
        )
    return np.linspace(stop, device.gap, count)


def _extreme(
    device: Device, pull: CoenergyMap, gaps: Floats, needed: Floats, pick: Callable[[Floats], Any]
) -> tuple[float, float]:
    """Gap and balance current where it is extreme, looked at closer there."""
    at = int(pick(needed))
    if not np.isfinite(needed[at]):
        return float(gaps[at]), float(needed[at])
    near = np.linspace(gaps[max(at - 1, 0)], gaps[min(at + 1, gaps.size - 1)], _CLOSE_POSITIONS)
    closer = balance_current(device, pull, near)
    best = int(pick(closer))
    return float(near[best]), float(closer[best])
