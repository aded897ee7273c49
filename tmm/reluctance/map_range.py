"""Range of currents and gaps of the normal actuator's co-energy map.

Asked of the reluctance network, which costs next to nothing: other models switch at
currents like its.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import lru_cache

import numpy as np

from tactgen.geometry.arrays import Floats
from tactgen.geometry.device.checks import widest_gap
from tactgen.geometry.device.magnetisation import MU0
from tactgen.geometry.device.parameters import Device
from tactgen.geometry.errors import InputError
from tactgen.tmm.reluctance.coenergy_fit import fit
from tactgen.tmm.reluctance.coenergy_map import CoenergyMap
from tactgen.tmm.reluctance.magnetic_circuit import pole_area, widest_circuit
from tactgen.tmm.reluctance.network import network_samples
from tactgen.tmm.reluctance.switching import between_stops, spring_force

#: The map begins at this share of the lower stop's gap: rough surfaces give way a little.
_BELOW_STOP = 0.8
#: The map reaches so many times the largest current at which the network's pull and the spring
#: balance; the fields switch at currents up to a third above it.
_BEYOND_BALANCE = 2.0
#: The same over the one-gap formula's current, where there is no network: on the device as
#: built the formula needs 0.4 to 0.75 of what the network does.
_WITHOUT_NETWORK = 4.0
#: The map reaches so many times the device's own current.
_BEYOND_CURRENT = 1.5
#: The map goes on beyond the upper stop so many times the gap.
_BEYOND_GAP = 1.25
#: Steps of a shared range are so far apart, in ratio; and what is this close to one is on it.
_STEP, _ROUNDING = math.sqrt(2.0), 1e-9
#: What the steps are counted from (A, m).
_MA, _UM = 1e-3, 1e-6
#: Power by which currents lie denser towards 0.
_DENSER = 1.5
#: Flux density (T) to which the pole is taken where no spring says how hard to pull.
_UNSPRUNG = 0.1
#: Largest ratio of neighbouring currents above those of the switching range.
_RATIO = 1.6
#: Shares of a reference current among which the network's balance is looked for.
_SHARES = np.geomspace(0.1, 100.0, 44)
#: Gaps, and cells of the network's ladder, of that search.
_POSITIONS, _CELLS = 9, 4


def map_grid(
    device: Device, currents: int = 13, gaps: int = 12, *, shared: bool = False
) -> tuple[Floats, Floats]:
    """Currents (A) and gaps (m) at which a model is sampled for the device's map.

    Currents from 0 to twice what moves the rod, denser where the map bends, at small ones;
    beyond, up to half as much again as the device's own, in even ratios.  Gaps from a little
    below the lower stop to a quarter beyond the upper, as far as nothing that moves meets the
    collar.

    Parameters
    ----------
    device : Device
        All of it but the bimorph is read.
    currents, gaps : int
        How many; currents beyond the switching range come on top.
    shared : bool
        Whether the range is rounded outwards to whole steps, so that devices that differ a
        little in gap, current and spring have the same: one map is then all of theirs.

    Raises InputError if there is no stroke.
    """
    needed, most = _switching_range(device), _BEYOND_CURRENT * abs(device.coil.current)
    least, largest = min(_BELOW_STOP * device.spring.stop_gap, 0.5 * device.gap), None
    if shared:
        needed, most = _rounded(needed, _MA, math.ceil), _rounded(most, _MA, math.ceil)
        least = _rounded(least, _UM, math.floor)
        largest = _rounded(_BEYOND_GAP * device.gap, _UM, math.ceil)
    inner = needed * np.linspace(0.0, 1.0, currents) ** _DENSER
    ratio = most / needed
    more = math.ceil(math.log(ratio) / math.log(_RATIO)) if ratio > 1.0 else 0
    outer = needed * ratio ** (np.arange(1, more + 1) / max(more, 1))
    return np.concatenate([inner, outer]), np.geomspace(least, _within(device, largest), gaps)


def _within(device: Device, largest: float | None) -> float:
    """Largest gap (m) if it is well before where a model ends.

    Else a quarter beyond the upper stop, or half the way to that end.
    """
    gap = device.gap
    ends = (end for end in (widest_circuit(device), widest_gap(device)) if end >= gap)
    half_way = 0.5 * (gap + min(ends, default=math.inf))
    if largest is not None and largest <= half_way:
        return largest
    return float(min(_BEYOND_GAP * gap, half_way))


def _rounded(value: float, unit: float, whole: Callable[[float], int]) -> float:
    """Current or gap rounded to a whole step from a unit; 0 is one."""
    if value == 0.0:
        return value
    steps = math.log(value / unit) / math.log(_STEP)
    near = round(steps)
    return float(unit * _STEP ** (near if abs(steps - near) < _ROUNDING else whole(steps)))


def _switching_range(device: Device) -> float:
    """Largest current (A) that switching may be about."""
    gaps = between_stops(device, _POSITIONS)
    against = spring_force(device, gaps)
    area = pole_area(device)
    if not against.any():  # no spring
        against = np.full_like(gaps, _UNSPRUNG**2 * area / (2.0 * MU0))
    # the one-gap formula, exact where only the gap counts
    reference = float(np.max(gaps * np.sqrt(2.0 * against / (MU0 * area))) / device.coil.turns)
    tried = reference * _SHARES
    within = np.minimum(gaps, widest_circuit(device))
    if within[-1] < 0.5 * gaps[-1]:
        return _WITHOUT_NETWORK * reference
    try:
        pull = network_samples(device, tried, within, cells=_CELLS).force
    except InputError:  # a circuit that the network does not know; the models will say more
        return _WITHOUT_NETWORK * reference
    enough = pull >= against
    # where no current is enough, the one that does most
    best = np.where(enough.any(axis=0), np.argmax(enough, axis=0), np.argmax(pull, axis=0))
    # beyond the network's reach, in proportion to the gap
    return _BEYOND_BALANCE * float(np.max(tried[best] * gaps / within))


def network_map(device: Device) -> CoenergyMap:
    """Network's co-energy map of a device, made once for one magnetic circuit.

    Raises InputError if the parts cannot form the circuit.
    """
    coil = device.coil.model_copy(update={"history": "rising"})  # no matter to the circuit
    parts = {name: getattr(device, name) for name in ("rod", "sleeve", "spring", "steel", "gap")}
    return _network_pull(Device(coil=coil, **parts))


@lru_cache(maxsize=32)
def _network_pull(circuit: Device) -> CoenergyMap:
    return fit(network_samples(circuit, *map_grid(circuit)))
