"""What the normal actuators do to each other through their field, by a model of one of them."""

from __future__ import annotations

from dataclasses import dataclass

from tactgen.geometry.store.values import storable
from tactgen.validation.engine.results import Estimate
from tactgen.validation.scene.scene import Scene

#: Nearest neighbours in a square array.
_NEIGHBOURS = 4


@storable
@dataclass(frozen=True)
class NeighbourField:
    """Pulls of one unit in an array in which all are driven, or one."""

    current: float  #: In every coil (A)
    #: Polarities equal, or opposite to all nearest neighbours (N)
    same: Estimate
    alternating: Estimate
    difference: Estimate  #: The first less the second (N), which shares much of their errors
    single: Estimate  #: Pull of one unit driven among others without current (N)
    #: Pull of its undriven neighbour beside it (N), below 0 if that is lifted; nan where that is
    #: not known
    passive: Estimate
    method: str  #: How the bars come about

    def per_neighbour(self) -> Estimate:
        """Force change of a unit per ampere in each of its nearest neighbours (N/A).

        In pulls that go with the products of currents, F(±) = Q i² ± 4 · 2 Q' i², the change by one
        neighbour's current is 2 Q' i, an eighth of the difference over the current.  What farther
        units of the other colour add is counted to the nearest four.
        """
        share = 2.0 * _NEIGHBOURS * self.current
        return Estimate(self.difference.value / share, self.difference.error / share)


def by_network(scene: Scene) -> NeighbourField:
    """Network's estimate."""
    from tactgen.tmm.display.array import network_forces
    from tactgen.tmm.reluctance.circuit import CELLS

    current, gap = scene.display.coil_current, scene.gap
    fine, coarse = (
        network_forces(scene.device, scene.display, current, gap, cells)
        for cells in (CELLS, CELLS // 2)
    )

    def judged(value: float, other: float) -> Estimate:
        return Estimate(value, abs(value - other))

    return NeighbourField(
        current,
        judged(fine.same, coarse.same),
        judged(fine.alternating, coarse.alternating),
        judged(fine.same - fine.alternating, coarse.same - coarse.alternating),
        judged(fine.single, coarse.single),
        Estimate(float("nan"), float("nan")),
        "difference from half as many ladder cells; the network's own error is not included",
    )


def by_field(scene: Scene) -> NeighbourField:
    """What the fields of an endless array and of nine units say."""
    from tactgen.fem.magnetics.array_3d import array_forces, nine_forces

    current = scene.display.coil_current
    found = array_forces(scene.device, current, scene.gap, scene.display.pitch)
    pairs = found.same, found.alternating
    # one potential's co-energy is too small, the other's too large, whatever the polarities
    width = max(abs(a - b) / (a + b) for a, b in pairs)
    difference = [a - b for a, b in zip(*pairs, strict=True)]
    mean = 0.5 * sum(difference)

    def judged(pair: tuple[float, float]) -> Estimate:
        value = 0.5 * sum(pair)
        return Estimate(value, width * abs(value))

    alone = nine_forces(
        scene.device, [{"middle": current}], scene.gap, scene.display.pitch
    )[0]  # fmt: skip
    return NeighbourField(
        current,
        judged(found.same),
        judged(found.alternating),
        Estimate(mean, max(0.5 * abs(difference[0] - difference[1]), width * abs(mean))),
        _of_nine(alone.middle, alone.unbalanced),
        _of_nine(alone.beside, alone.unbalanced, _NEIGHBOURS),
        "half the difference of vector and scalar potential, of either polarity the larger; of one "
        "driven unit, among eight without current, at least what all forces lack to balance",
    )


def _of_nine(
    pair: tuple[float, float], unbalanced: tuple[float, float], share: int = 1
) -> Estimate:
    """Pull by both potentials; of what is out of balance each of `share` units has one."""
    half = 0.5 * abs(pair[0] - pair[1])
    return Estimate(0.5 * sum(pair), max(half, 0.5 * abs(sum(unbalanced)) / share))
