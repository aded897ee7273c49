"""Derivatives of quantities with respect to scene keys, by any model, each with an error bar.

A model whose row names a module for it gives them itself; of all others they are central
differences at two distances, extrapolated (Richardson), with a bar for what is left of the
truncation and for what the values' own error bars leave open.
"""

from __future__ import annotations

import importlib
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, Protocol, cast

import numpy as np

from tactgen.geometry.arrays import Floats, Numbers
from tactgen.geometry.errors import InputError
from tactgen.validation.catalogue.models import MODELS
from tactgen.validation.engine.results import Quantity
from tactgen.validation.engine.solve import Solution, solve
from tactgen.validation.scene.nearby import value_of
from tactgen.validation.scene.scene import Scene

#: Where a quantity is asked for a difference, in units of the largest distance.
PLACES = np.array([1.0, -1.0, 0.5, -0.5])
#: Largest and smallest relative distance.
_FAR, NEAREST = 5e-2, 2e-3

#: Gives the scene in which a key has another value; InputError where there is none.
Changed = Callable[[str, float], Scene]


@dataclass(frozen=True)
class Derivatives:
    """A quantity with its derivatives.

    Attributes
    ----------
    quantity : Quantity
        Its value at the scene, with its error bar.
    slopes, bars : dict of str to array
        By scene key dq/dp (SI) of the shape of the value, and its error bar.
    method : str
        How derivatives and bars come about, for the reader.
    """

    quantity: Quantity
    slopes: dict[str, Numbers]
    bars: dict[str, Floats]
    method: str


class DerivativesModule(Protocol):
    """What a module for better derivatives of a model has: exact ones, or between two levels."""

    def gives_derivatives(self, scene: Scene, quantity: str) -> bool:
        """Return whether it gives those of a quantity of a scene."""

    def exact_derivatives(
        self,
        scene: Scene,
        changed: Changed,
        quantities: Sequence[str],
        keys: Sequence[str],
        announce: Callable[[str], None],
    ) -> list[Derivatives]:
        """Return quantities with their derivatives by `keys`."""


def derivatives(
    scene: Scene,
    changed: Changed,
    model: str,
    quantities: Sequence[str],
    keys: Sequence[str],
    announce: Callable[[str], None] = lambda _: None,
) -> list[Derivatives]:
    """Return quantities by a model, each with its derivatives by `keys`.

    Raises
    ------
    InputError
        If the model cannot take the scene, or one next to it.
    """
    module = MODELS[model].derivatives
    exact: list[Derivatives] = []
    if module:
        giver = cast(DerivativesModule, importlib.import_module(module))
        given = [name for name in quantities if giver.gives_derivatives(scene, name)]
        if given:
            exact = giver.exact_derivatives(scene, changed, given, keys, announce)
    done = {found.quantity.name: found for found in exact}
    rest = [name for name in quantities if name not in done]
    if rest:
        differences = by_differences(scene, changed, model, rest, keys, announce)
        done |= {found.quantity.name: found for found in differences}
    return [done[name] for name in quantities]


def extrapolated(values: Numbers, distance: float) -> tuple[Numbers, Floats]:
    """Return the derivative (...) of values (4, ...) at :data:`PLACES`, and its truncation.

    Two central differences, of which the error h² is extrapolated away; how far that moves
    the better one bounds what is left.
    """
    far = (values[0] - values[1]) / (2.0 * distance)
    near = (values[2] - values[3]) / distance
    found = (4.0 * near - far) / 3.0
    return np.asarray(found), np.asarray(np.abs(found - near))


def noise(bars: Any, distance: float) -> Any:
    """Return what values that are off by `bars` leave open in :func:`extrapolated`."""
    return 3.0 * bars / distance


def by_differences(
    scene: Scene,
    changed: Changed,
    model: str,
    quantities: Sequence[str],
    keys: Sequence[str],
    announce: Callable[[str], None],
) -> list[Derivatives]:
    """Return quantities with derivatives by differences of their values, as :func:`derivatives`."""
    base = solve(scene, (model,), quantities, announce)
    start = [base.get(name, model) for name in quantities]
    share = _distance(start)
    slopes: list[dict[str, Numbers]] = [{} for _ in start]
    bars: list[dict[str, Floats]] = [{} for _ in start]
    for number, key in enumerate(keys):
        announce(f"{model}: derivative {number + 1} of {len(keys)}, {key}")
        value = float(value_of(scene, key))
        distance = within(changed, key, value, share * abs(value))
        found = [
            _solved(changed(key, value + place * distance), model, quantities, base)
            for place in PLACES
        ]
        for n, q in enumerate(start):
            near = [solution.get(q.name, model) for solution in found]
            if any(other.value.shape != q.value.shape for other in near):
                raise InputError(
                    f"--key {key} changes how many values {q.name} has by {model} next to the "
                    "scene; leave the key out, or the quantity"
                )
            slope, truncated = extrapolated(np.array([o.value for o in near]), distance)
            open_ = noise(np.max([o.error for o in near], axis=0), distance)
            # what is the same to the last bit does not depend on the key
            same = all(np.array_equal(o.value, q.value, equal_nan=True) for o in near)
            slopes[n][key] = slope
            bars[n][key] = np.zeros(q.value.shape) if same else truncated + open_
    method = (
        f"central differences at up to {100 * share:.2g} and {50 * share:.2g} %, extrapolated; the "
        "bar holds the truncation and, at its worst, the error bars of the values"
    )
    return [Derivatives(q, s, b, method) for q, s, b in zip(start, slopes, bars, strict=True)]


def within(changed: Changed, key: str, value: float, distance: float) -> float:
    """Return the distance, or less of it where the parts would not fit together."""
    nearest = NEAREST * abs(value)
    while distance > nearest:
        try:
            for place in (1.0, -1.0):
                changed(key, value + place * distance)
        except InputError:
            distance = max(0.5 * distance, nearest)
        else:
            return distance
    return nearest


def _solved(scene: Scene, model: str, quantities: Sequence[str], base: Solution) -> Solution:
    return solve(scene, (model,), quantities, reuse=base)


def _distance(quantities: Sequence[Quantity]) -> float:
    """Return the relative distance at which truncation, as h⁴, is about what bars leave open."""
    shares = [0.0]
    for q in quantities:
        size = np.abs(q.value)
        known = np.isfinite(size) & (size > 0.0) & np.isfinite(q.error)
        shares += list((q.error[known] / size[known]).ravel())
    return float(np.clip(max(shares) ** 0.2, NEAREST, _FAR))
