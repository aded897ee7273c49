"""Exact derivatives of the model solid: what :mod:`validation.engine.derivatives` asks for.

On stretched bricks K and M are sums of fixed matrices times products of lengths and constants,
so that their derivatives are as exact as they are.  The bimorph is reduced to what it says itself
(:func:`fem.bimorph.reduction.parametric.family.tangent_family`), once for all keys; the small
system has the large one's derivatives, which are differences of its values, smooth to rounding.
The bar is the difference of two levels of bricks with its factor.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace

import numpy as np

from tactgen.fem.bimorph.reduction.parametric.family import ReducedFamily, tangent_family
from tactgen.fem.piezo.symmetry import Motion
from tactgen.geometry.arrays import Floats, Numbers
from tactgen.geometry.bimorph.bimorph_bricks import BrickMeshing
from tactgen.geometry.bimorph.stretching import LEVELS
from tactgen.validation.catalogue.quantities import QUANTITIES
from tactgen.validation.engine.derivatives import (
    PLACES,
    Changed,
    Derivatives,
    extrapolated,
    noise,
)
from tactgen.validation.engine.error_bars import BRICK_FACTOR
from tactgen.validation.engine.results import Quantity
from tactgen.validation.models.bimorph.family.solid_family import (
    MOTIONS,
    SolidFamily,
    is_family_key,
    needed,
    reading,
)
from tactgen.validation.models.bimorph.family.surplus import family_surplus
from tactgen.validation.models.bimorph.family.values import (
    FamilyValues,
    family_values,
    gives_family,
    joined,
)
from tactgen.validation.models.bimorph.solid import SolidModel, level_for
from tactgen.validation.scene.nearby import value_of
from tactgen.validation.scene.scene import Scene

#: Relative distance of the values of the small systems: truncation and rounding, about 1e-9 of a
#: frequency, then both leave a millionth open.
_DISTANCE = 3e-3
#: Relative rounding of a value of a small system.
_ROUNDING = 1e-9


def gives_derivatives(scene: Scene, quantity: str) -> bool:
    """Return whether a quantity has exact derivatives: of the bimorph alone, in one part."""
    return scene.support.kind != "rod" and gives_family(quantity)


def exact_derivatives(
    scene: Scene,
    changed: Changed,
    quantities: Sequence[str],
    keys: Sequence[str],
    announce: Callable[[str], None] = lambda _: None,
) -> list[Derivatives]:
    """Return quantities of the scene, each with its derivatives by `keys`.

    Raises
    ------
    InputError
        If the bricks do not know the scene, or one next to it makes no device.
    """
    SolidModel.check(scene)
    start = time.perf_counter()
    fine, coarse = _tangents(scene, quantities, announce)
    both = replace(fine, coarse=coarse.fine)
    announce("solid: derivatives")
    own_length = {"bimorph.length": _of(scene, "bimorph.length")}
    found = family_values(scene, both, own_length, quantities)
    alone = [family_values(scene, family, own_length, quantities) for family in (fine, coarse)]
    slopes: dict[str, dict[str, Numbers]] = {name: {} for name in quantities}
    bars: dict[str, dict[str, Floats]] = {name: {} for name in quantities}
    for key in keys:
        distance = _DISTANCE * abs(float(value_of(scene, key)))
        changed(key, float(value_of(scene, key)) + distance)  # refuses what makes no device
        levels = [
            _near(scene, changed, family, key, distance, quantities) for family in (fine, coarse)
        ]
        for name in quantities:
            (slope, own), (other, of_other) = (
                _slope(level[name], at[name], distance)
                for level, at in zip(levels, alone, strict=True)
            )
            slopes[name][key] = slope
            bars[name][key] = BRICK_FACTOR * (np.abs(slope - other) + of_other) + own
    seconds = time.perf_counter() - start
    method = (
        "exact derivatives of the discretised solid, whose matrices are sums of fixed ones; the "
        f"bar from two levels of bricks ({both.fine.unknowns} and {both.coarse.unknowns} unknowns)"
    )
    return [
        Derivatives(_quantity(scene, name, found[name], seconds), slopes[name], bars[name], method)
        for name in quantities
    ]


def _tangents(
    scene: Scene, quantities: Sequence[str], announce: Callable[[str], None]
) -> tuple[SolidFamily, SolidFamily]:
    """Return the neighbourhoods of the finer and of the coarser level, each beside itself."""
    level = level_for(scene)
    modal, frequencies = reading(scene, quantities)

    def built(meshing: BrickMeshing, modes: Mapping[Motion, int]) -> ReducedFamily:
        return tangent_family(scene.device, meshing, modes, frequencies=frequencies)

    every: dict[Motion, int] = dict.fromkeys(MOTIONS if modal else MOTIONS[:1], scene.modes)
    announce("solid: coarser bricks")
    coarse = built(LEVELS[level - 1], every)
    announce("solid: finer bricks")
    counts = needed(coarse, scene, scene.modes) if modal else every
    fine = built(LEVELS[level], counts)
    coarse = replace(coarse, motions={motion: coarse.motions[motion] for motion in counts})
    surplus = family_surplus(scene.device, {}, LEVELS[level], counts)
    return SolidFamily(fine, fine, surplus), SolidFamily(coarse, coarse, surplus)


def _near(
    scene: Scene,
    changed: Changed,
    family: SolidFamily,
    key: str,
    distance: float,
    quantities: Sequence[str],
) -> dict[str, FamilyValues]:
    """Return the quantities (4, ...) at :data:`PLACES` times a distance, by one level."""
    value = float(value_of(scene, key))
    at = value + PLACES * distance
    if is_family_key(scene, key):
        return family_values(scene, family, {key: at}, quantities)
    own = {"bimorph.length": _of(scene, "bimorph.length")}
    each = [family_values(changed(key, float(v)), family, own, quantities) for v in at]
    return {name: joined([one[name] for one in each]) for name in quantities}


def _slope(near: FamilyValues, at: FamilyValues, distance: float) -> tuple[Numbers, Floats]:
    """Return a derivative with what basis, truncation and rounding leave open.

    What the basis misses is a square, (ε₀ + ε₁ d)² at most at a distance d, of which the
    derivative is 2 ε₀ ε₁.
    """
    slope, truncated = extrapolated(near.value, distance)
    if (near.value == near.value[0]).all():  # the key is not read
        return slope, np.zeros(slope.shape)
    missed = 2.0 * np.sqrt(at.basis[0] * near.basis[:2].max(axis=0)) / distance
    return slope, truncated + missed + noise(_ROUNDING * np.abs(near.value[0]), distance)


def _of(scene: Scene, key: str) -> Floats:
    return np.array([float(value_of(scene, key))])


def _quantity(scene: Scene, name: str, found: FamilyValues, seconds: float) -> Quantity:
    row = QUANTITIES[name]
    return Quantity(
        name=name, model="solid", value=np.asarray(found.value[0]), unit=row.unit,
        error=np.asarray(found.error[0]), method="two levels of bricks",
        seconds=seconds, frequency=scene.frequency if row.by_frequency else None,
        classes=None if found.classes is None else tuple(str(kind) for kind in found.classes[0]),
    )  # fmt: skip
