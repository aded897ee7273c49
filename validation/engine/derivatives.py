"""Derivatives of quantities with respect to scene keys, by any model, each with an error.

Central differences at two distances, extrapolated (Richardson), of plain solutions; the error
holds what is left of the truncation and, at its worst, the errors of the values.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from tactgen.geometry.arrays import Floats, Numbers
from tactgen.geometry.errors import InputError
from tactgen.validation.engine.results import Quantity
from tactgen.validation.engine.solve import solve
from tactgen.validation.scene.nearby import value_of
from tactgen.validation.scene.scene import Scene

#: Where a quantity is evaluated for a difference, in units of the largest distance.
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
        Its value at the scene, with its error.
    slopes, bars : dict of str to array
        By scene key dq/dp (SI) of the shape of the value, and its error.
    method : str
        How derivatives and errors come about, for the reader.
    """

    quantity: Quantity
    slopes: dict[str, Numbers]
    bars: dict[str, Floats]
    method: str


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
    base = solve(scene, (model,), quantities, announce)
    start = [base.get(name, model) for name in quantities]
    share = _distance(start)
    slopes: list[dict[str, Numbers]] = [{} for _ in start]
    bars: list[dict[str, Floats]] = [{} for _ in start]
    for number, key in enumerate(keys):
        announce(f"{model}: derivative {number + 1} of {len(keys)}, {key}")
        value = float(value_of(scene, key))
        distance = within(changed, key, value, share * abs(value))
        near = [
            solve(changed(key, value + place * distance), (model,), quantities, reuse=base)
            for place in PLACES
        ]
        for n, q in enumerate(start):
            others = [solution.get(q.name, model) for solution in near]
            if any(other.value.shape != q.value.shape for other in others):
                raise InputError(
                    f"--key {key} changes how many values {q.name} has by {model} next to the "
                    "scene; leave the key out, or the quantity"
                )
            errors = np.max([other.error for other in others], axis=0)
            values = np.array([other.value for other in others])
            slopes[n][key], bars[n][key] = extrapolated(values, errors, distance)
    method = (
        f"central differences at up to {100 * share:.2g} and {50 * share:.2g} %, extrapolated; the "
        "bar holds the truncation and, at its worst, the error bars of the values"
    )
    return [Derivatives(q, s, b, method) for q, s, b in zip(start, slopes, bars, strict=True)]


def extrapolated(values: Numbers, errors: Floats, distance: float) -> tuple[Numbers, Floats]:
    """Return the derivative (...) of values (4, ...) at :data:`PLACES`, and its error.

    Of two central differences the error h² is extrapolated away; by how far that moves the
    better one is what is left at most.  Values off by `errors` (...) leave 3/h of these open.
    What is the same to the last bit does not depend on the key.
    """
    far = (values[0] - values[1]) / (2.0 * distance)
    near = (values[2] - values[3]) / distance
    slope = (4.0 * near - far) / 3.0
    error = np.abs(slope - near) + 3.0 * errors / distance
    same = np.array_equal(values, np.broadcast_to(values[0], values.shape), equal_nan=True)
    return np.asarray(slope), np.asarray(np.zeros_like(error) if same else error)


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


def _distance(quantities: Sequence[Quantity]) -> float:
    """Return the relative distance at which truncation, as h⁴, is about what errors leave open."""
    shares = [0.0]
    for q in quantities:
        size = np.abs(q.value)
        known = np.isfinite(size) & (size > 0.0) & np.isfinite(q.error)
        shares += list((q.error[known] / size[known]).ravel())
    return float(np.clip(max(shares) ** 0.2, NEAREST, _FAR))
