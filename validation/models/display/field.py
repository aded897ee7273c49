"""What the normal actuators do to each other through their field, by a model of one of them."""

from __future__ import annotations

import math
from dataclasses import dataclass

from tactgen.geometry.store.values import storable
from tactgen.validation.engine.results import Measured
from tactgen.validation.scene.scene import Scene

#: Nearest neighbours in a square array.
_NEIGHBOURS = 4


@storable
@dataclass(frozen=True)
class NeighbourField:
    """Pulls of one unit in an array in which all are driven.

    Attributes
    ----------
    current : float
        In every coil (A).
    same, alternating : Measured
        Polarities equal, or opposite to all nearest neighbours (N).
    difference : Measured
        The first less the second (N), which shares much of their errors.
    single : Measured
        Pull of one unit driven among others without current (N).
    passive : Measured
        Pull of its undriven neighbour (N); nan where that is not known.
    method : str
        How the bars come about.
    """

    current: float
    same: Measured
    alternating: Measured
    difference: Measured
    single: Measured
    passive: Measured
    method: str

    def per_neighbour(self) -> Measured:
        """Return the force change of a unit per ampere in each of its nearest neighbours (N/A).

        In pulls that go with the products of currents, F(±) = Q i² ± 4 · 2 Q' i², the change by one
        neighbour's current is 2 Q' i, an eighth of the difference over the current.  What farther
        units of the other colour add is counted to the nearest four.
        """
        share = 2.0 * _NEIGHBOURS * self.current
        return Measured(self.difference.value / share, self.difference.bar / share)


def by_network(scene: Scene) -> NeighbourField:
    """Return the network's estimate."""
    from tactgen.tmm.display.field import network_forces
    from tactgen.tmm.reluctance.circuit import CELLS

    current, gap = scene.display.coil_current, scene.gap
    fine, coarse = (
        network_forces(scene.device, scene.display, current, gap, cells)
        for cells in (CELLS, CELLS // 2)
    )

    def judged(value: float, other: float) -> Measured:
        return Measured(value, abs(value - other))

    return NeighbourField(
        current,
        judged(fine.same, coarse.same),
        judged(fine.alternating, coarse.alternating),
        judged(fine.same - fine.alternating, coarse.same - coarse.alternating),
        judged(fine.single, coarse.single),
        judged(fine.passive, coarse.passive),
        "difference from half as many ladder cells; the network's own error is not included",
    )


def by_field(scene: Scene) -> NeighbourField:
    """Return what the field in an endless array says, all of its cells in motion together."""
    from tactgen.fem.reluctance.three_d.array import array_forces

    current = scene.display.coil_current
    found = array_forces(scene.device, current, scene.gap, scene.display.pitch)
    pairs = found.same, found.alternating
    # one potential's co-energy is too small, the other's too large, whatever the polarities
    width = max(abs(a - b) / (a + b) for a, b in pairs)
    difference = [a - b for a, b in zip(*pairs, strict=True)]
    mean = 0.5 * sum(difference)
    single = [_single(a, b) for a, b in zip(*pairs, strict=True)]
    middle = 0.5 * sum(single)

    def judged(pair: tuple[float, float]) -> Measured:
        value = 0.5 * sum(pair)
        return Measured(value, width * abs(value))

    return NeighbourField(
        current,
        judged(found.same),
        judged(found.alternating),
        Measured(mean, max(0.5 * abs(difference[0] - difference[1]), width * abs(mean))),
        Measured(middle, max(0.5 * abs(single[0] - single[1]), width * abs(middle))),
        Measured(float("nan"), float("nan")),
        "half the difference of vector and scalar potential, of either polarity the larger; of one "
        "driven unit by its waves from unit to unit, of which the two polarities are the ends",
    )


def _single(same: float, alternating: float) -> float:
    """Return the pull of one driven unit of an endless array from those of all driven.

    Each unit passes its flux on to its four neighbours: how much, the two polarities tell.
    """
    from tactgen.tmm.display.field import endless_share

    if not 0.0 < alternating <= same:
        return float("nan")
    ratio = (math.sqrt(same / alternating) - 1.0) / 8.0
    return same * endless_share(ratio) ** 2
