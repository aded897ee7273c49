"""Many scenes of the model solid answered together: what :mod:`validation.engine.families` asks."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence

import numpy as np

from tactgen.geometry.arrays import Floats
from tactgen.validation.catalogue.quantities import QUANTITIES
from tactgen.validation.engine.results import Quantity
from tactgen.validation.models.bimorph.family.solid_family import (
    Ranges,
    is_family_key,
    solid_family,
)
from tactgen.validation.models.bimorph.family.values import family_values, gives_family
from tactgen.validation.scene.scene import Scene

__all__ = ["answer_family", "gives_family", "is_family_key"]


def answer_family(
    scene: Scene,
    values: dict[str, Floats],
    quantities: Sequence[str],
    ranges: Ranges,
    announce: Callable[[str], None] = lambda _: None,
) -> list[tuple[Quantity, ...]]:
    """Return the quantities of each scene that differs from `scene` in `values` (n,) each.

    All of `ranges`, in which the values lie, is reduced.

    Raises
    ------
    InputError
        If a piece of the bimorph vanishes in some of them, or the bricks do not know it.
    """
    start = time.perf_counter()
    family = solid_family(scene, ranges, quantities, announce)
    found = family_values(scene, family, values, quantities)
    count = next(iter(values.values())).size
    seconds = (time.perf_counter() - start) / count
    answers = []
    for number in range(count):
        quantities_here = []
        for name, all_values in found.items():
            classes = None
            if all_values.classes is not None:
                classes = tuple(str(kind) for kind in all_values.classes[number])
            quantities_here.append(
                Quantity(
                    name=name,
                    model="solid",
                    value=np.asarray(all_values.value[number]),
                    unit=QUANTITIES[name].unit,
                    uncertainty=np.asarray(all_values.bar[number]),
                    uncertainty_method=family.method,
                    seconds=seconds,
                    frequency=scene.frequency if QUANTITIES[name].by_frequency else None,
                    classes=classes,
                )
            )
        answers.append(tuple(quantities_here))
    return answers
