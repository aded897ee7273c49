"""Many scenes of the model solid answered together: what :mod:`validation.engine.families` asks."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from tactgen.geometry.arrays import Floats
from tactgen.validation.catalogue.quantities import QUANTITIES
from tactgen.validation.engine.costs import recorded
from tactgen.validation.engine.prospects import Prospect
from tactgen.validation.engine.results import Quantity
from tactgen.validation.models.bimorph.family.many import for_many
from tactgen.validation.models.bimorph.family.solid_family import (
    Ranges,
    SolidFamily,
    cost_name,
    is_family_kept,
    is_family_key,
    solid_family,
)
from tactgen.validation.models.bimorph.family.values import (
    FamilyValues,
    family_values,
    gives_family,
)
from tactgen.validation.scene.scene import Scene

__all__ = ["family_prospect", "gives_family", "is_family_key", "least_members", "reduce_family"]

#: What members are read off, in words.
BASIS = "one reduced basis"
#: Members beyond which to look for fewer shapes pays: it takes about as long as a few hundred.
_MANY = 1000


def reduce_family(
    scene: Scene,
    ranges: Ranges,
    quantities: Sequence[str],
    members: int,
    announce: Callable[[str], None] = lambda _: None,
) -> SolidAnswers:
    """Return what answers for about so many scenes that differ from `scene` within `ranges`.

    Raises
    ------
    InputError
        If a piece of the bimorph vanishes in some of them, or the bricks do not know it.
    """
    start = time.perf_counter()
    family = solid_family(scene, ranges, quantities, announce)
    if members > _MANY:
        family = for_many(scene, family, quantities, announce)
    seconds = (time.perf_counter() - start) / members
    return SolidAnswers(scene, family, tuple(quantities), seconds)


def least_members(keys: int) -> int:
    """Return the number of points up to which single answers take no longer.

    A basis takes what its middle, its corners and some members between them have to say, each
    in more classes of motion than a single answer needs.
    """
    return int(2 * (1 + 2**keys + keys))


def family_prospect(scene: Scene, ranges: Ranges, quantities: Sequence[str]) -> Prospect:
    """Return whether a family of these ranges is kept, and what one as large took to build.

    Raises
    ------
    InputError
        As :func:`reduce_family`.
    """
    return Prospect(
        is_family_kept(scene, ranges, quantities), recorded().get(cost_name(len(ranges)))
    )


@dataclass(frozen=True)
class SolidAnswers:
    """Quantities of scenes of one family; `seconds` is each one's share of what it cost to make."""

    scene: Scene
    family: SolidFamily
    quantities: tuple[str, ...]
    seconds: float

    def answers(self, values: dict[str, Floats]) -> list[tuple[Quantity, ...]]:
        """Return the quantities of each scene that differs in `values` (n,) each."""
        start = time.perf_counter()
        found = family_values(self.scene, self.family, values, self.quantities)
        count = next(iter(values.values())).size
        seconds = self.seconds + (time.perf_counter() - start) / count
        return [
            tuple(self._quantity(name, found[name], n, seconds) for name in found)
            for n in range(count)
        ]

    def _quantity(self, name: str, found: FamilyValues, number: int, seconds: float) -> Quantity:
        classes = None
        if found.classes is not None:
            classes = tuple(str(kind) for kind in found.classes[number])
        row = QUANTITIES[name]
        return Quantity(
            name=name,
            model="solid",
            value=np.array(found.value[number]),
            unit=row.unit,
            error=np.array(found.error[number]),
            method=self.family.method,
            seconds=seconds,
            frequency=self.scene.frequency if row.by_frequency else None,
            classes=classes,
        )
