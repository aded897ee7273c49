"""Derivatives of quantities with respect to scene keys, by any model, each with an error.

Central differences at two distances, extrapolated (Richardson), of plain solutions.  The error
holds the rest of the truncation, the scatter of the values, which their even parts show, and the
relative error of the value, since neighbouring solutions share most of theirs.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np

from tactgen.geometry.arrays import Floats, Numbers
from tactgen.geometry.errors import InputError
from tactgen.validation.engine.solve import Solution, solve
from tactgen.validation.models.model import Quantity
from tactgen.validation.scene.scene import Scene
from tactgen.validation.scene.variation import value_of

#: Where a quantity is evaluated for a difference, in units of the largest distance.
PLACES = np.array([1.0, -1.0, 0.5, -0.5])
#: Largest relative distance: of numbers with an error, and of those exact to rounding.
_FAR, _CLOSE = 1e-2, 2e-4
#: Relative error of a quantity up to which it counts as exact.
_EXACT = 1e-8
#: Relative distance at which neighbouring scenes must exist.
NEAREST = 2e-3
#: Standard deviation of the even part's rest per scatter of a value, and how much more scatter is
#: counted with, since five values show one sample of it.
_EVEN, _ONE_SAMPLE = 8.4, 5.0

#: Gives the scene in which a key has another value; InputError where there is none.
Changed = Callable[[str, float], Scene]


@dataclass(frozen=True)
class Derivatives:
    """A quantity with its derivatives."""

    quantity: Quantity  #: Its value at the scene, with its error
    #: By scene key dq/dp (SI) of the shape of the value, and its error
    slopes: dict[str, tuple[Numbers, Floats]]
    method: str  #: How derivatives and errors come about, for the reader


def derivatives(
    scene: Scene,
    changed: Changed,
    model: str,
    quantities: Sequence[str],
    keys: Sequence[str],
    announce: Callable[[str], None] = lambda _: None,
) -> list[Derivatives]:
    """Quantities by a model, each with its derivatives by `keys`.

    Behind one that has a largest or least value between its frequencies that value follows.

    Raises InputError if the model cannot take the scene, or one next to it.
    """
    base = solve(scene, (model,), quantities, announce)
    start = _with_extremes(base, model, quantities)
    slopes: dict[Entry, dict[str, tuple[Numbers, Floats]]] = {entry: {} for entry in start}
    exact = not any(np.any(q.error > _EXACT * np.abs(q.value)) for q in start.values())
    far = _CLOSE if exact else _FAR
    for number, key in enumerate(keys):
        announce(f"{model}: derivative {number + 1} of {len(keys)}, {key}")
        value = float(value_of(scene, key))
        distance = within(changed, key, value, far * abs(value))
        scenes = (changed(key, value + place * distance) for place in PLACES)
        near = [
            _with_extremes(
                solve(there, (model,), quantities, reuse=base, modelling=False), model, quantities
            )
            for there in scenes
        ]
        for entry, q in start.items():
            others = [found[entry].value if entry in found else np.empty(0) for found in near]
            if any(other.shape != q.value.shape for other in others):
                raise InputError(
                    f"--key {key} changes how many values {q.name} has by {model} next to the "
                    "scene; leave the key out, or the quantity"
                )
            values = np.array([q.value, *others])
            slopes[entry][key] = extrapolated(values, q.error, distance)
    method = (
        f"central differences at up to {100 * far:g} and {50 * far:g} %, extrapolated; the bar "
        "holds the truncation, the scatter of the values and the relative error of the value"
    )
    return [Derivatives(q, slopes[entry], method) for entry, q in start.items()]


#: Name of a quantity, and whether its extreme is meant.
Entry: TypeAlias = tuple[str, bool]


def _with_extremes(found: Solution, model: str, names: Sequence[str]) -> dict[Entry, Quantity]:
    entries: dict[Entry, Quantity] = {}
    for name in names:
        entries[name, False] = q = found.get(name, model)
        if q.extreme:
            entries[name, True] = q.alone_at_extreme
    return entries


def extrapolated(values: Numbers, error: Floats, distance: float) -> tuple[Numbers, Floats]:
    """Derivative (...) of values (5, ...) at 0 and at :data:`PLACES`, and its error.

    Of two central differences the error h² is extrapolated away; by how far that moves the
    better one is what is left at most.  `error` (...) is that of the value at 0.  What is the same
    to the last bit does not depend on the key.
    """
    here, ahead, behind, near_ahead, near_behind = values
    far = (ahead - behind) / (2.0 * distance)
    near = (near_ahead - near_behind) / distance
    slope = (4.0 * near - far) / 3.0
    # smooth values have an even part in proportion to the distance squared
    even = (ahead + behind - 2.0 * here) - 4.0 * (near_ahead + near_behind - 2.0 * here)
    rounding = np.finfo(float).eps * np.abs(here)  # which the even part may not happen to show
    scatter = np.maximum(_ONE_SAMPLE * np.abs(even) / _EVEN, rounding)
    size = np.where(here == 0.0, 1.0, np.abs(here))
    left = np.abs(slope - near) + 3.0 * scatter / distance + error / size * np.abs(slope)
    same = np.array_equal(values, np.broadcast_to(here, values.shape), equal_nan=True)
    return np.asarray(slope), np.asarray(np.zeros_like(left) if same else left)


def within(changed: Changed, key: str, value: float, distance: float) -> float:
    """Distance, or less of it where the parts would not fit together."""
    nearest = NEAREST * abs(value)
    while distance > nearest and misfit(changed, key, value, distance):
        distance = max(0.5 * distance, nearest)
    return distance


def misfit(changed: Changed, key: str, value: float, distance: float) -> str:
    """Reason why a scene so far to either side of a value makes no device, or ""."""
    try:
        for place in (1.0, -1.0):
            changed(key, value + place * distance)
    except InputError as error:
        return str(error)
    return ""
