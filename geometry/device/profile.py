"""Dimensions that vary along the ceramic: text such as ``"0 mm: 2.1 mm, 20 mm: 1 mm"``.

A profile runs straight from each point to the next; two points at one position are a
step; the word ``uniform`` is no profile.  Read at the edge with units, held in metres.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import pairwise
from typing import Annotated, Any

import numpy as np
from pydantic import BeforeValidator, ValidationInfo

from tactgen.geometry.arrays import Floats
from tactgen.geometry.units import Unit

_EXAMPLE = "0 mm: 2.1 mm, 20 mm: 1 mm"
_LIMITS = (1e-9, 100.0)
_POSITION = Unit("m", "position", "10 mm", at_least=0.0, limits=_LIMITS, shown="mm")
_VALUE = Unit("m", "dimension", "2.1 mm", above=0.0, limits=_LIMITS, shown="mm")
#: What a scene writes for no profile.
_NONE = "uniform"
#: A profile that ends this close (relative) to the ceramic's edge ends there: input is rounded.
_ROUNDED = 1e-6
#: Largest number of points: more than anyone writes, few enough to compute with.
_MOST = 200


class Profile(tuple[tuple[float, float], ...]):
    """Points (position, dimension) in metres, from the lower edge up; empty if uniform."""

    __slots__ = ()

    def __str__(self) -> str:
        return ", ".join(f"{_POSITION.show(z)}: {_VALUE.show(v)}" for z, v in self) or _NONE

    @property
    def end(self) -> float:
        """Position of the last point (m)."""
        return self[-1][0]

    def between(self, low: float, high: float) -> tuple[float, float]:
        """Dimension just above `low` and just below `high`.

        No point may lie between the two.  Beyond the last point its dimension goes on.
        """
        z, v = np.array(self).T
        above = int(np.searchsorted(z, low, side="right"))  # first point above low
        if above == z.size:
            return float(v[-1]), float(v[-1])
        first = (z[above - 1], v[above - 1]) if above else (low, v[0])
        share: Floats = (np.array([low, high]) - first[0]) / (z[above] - first[0])
        ends = first[1] + share * (v[above] - first[1])
        return float(ends[0]), float(ends[1])


def read_profile(value: Any, info: ValidationInfo) -> Profile:
    """Profile from its text, or from pairs of numbers in metres.

    An end that misses the ceramic's length by rounding is put there.

    Raises ValueError with a sentence that names the remedy.
    """
    points = Profile(
        (_number(_POSITION, z, info), _number(_VALUE, v, info)) for z, v in _pairs(value)
    )
    if not points:
        return points
    points = _ended(points, info.data.get("length"))
    remedy = f'; write for example "{_EXAMPLE}"'
    if len(points) == 1:
        raise ValueError(f"has one point only; give at least two{remedy}")
    if len(points) > _MOST:
        raise ValueError(f"has {len(points)} points; give at most {_MOST}")
    z = [position for position, _ in points]
    if z[0] != 0.0:
        raise ValueError(
            f"begins at {_POSITION.show(z[0])}; begin at the ceramic's lower edge, 0 mm{remedy}"
        )
    if any(high < low for low, high in pairwise(z)):
        raise ValueError(f"has positions that do not ascend; order its points by height{remedy}")
    if z[-2] == z[-1] or z[0] == z[1] or any(a == c for a, c in zip(z, z[2:], strict=False)):
        raise ValueError(
            "has a step at its end, or more than two points at one position; a step is two points "
            f"at one position between others{remedy}"
        )
    return points


def _ended(points: Profile, length: float | None) -> Profile:
    """Points with the last one at the ceramic's edge if it is meant to be there."""
    z, dimension = points[-1]
    if length is None or not math.isclose(z, length, rel_tol=_ROUNDED):
        return points
    return Profile((*points[:-1], (length, dimension)))


def _pairs(value: Any) -> list[tuple[Any, Any]]:
    if isinstance(value, str):
        given = value.strip().lower() not in ("", _NONE)
        parts = [part.split(":") for part in value.split(",")] if given else []
    elif isinstance(value, Sequence) and all(isinstance(p, list | tuple) for p in value):
        parts = [list(p) for p in value]
    else:
        parts = [[]]
    if any(len(part) != 2 for part in parts):
        raise ValueError(
            "is not a list of points, each a position and a dimension; "
            f'write for example "{_EXAMPLE}", or "{_NONE}" for none'
        )
    return [(first, second) for first, second in parts]


def _number(unit: Unit, value: Any, info: ValidationInfo) -> float:
    try:
        return unit(value, info)
    except ValueError as error:
        text = value.strip() if isinstance(value, str) else value
        raise ValueError(f'has the {unit.kind} "{text}", which {error}') from None


LengthProfile = Annotated[Any, BeforeValidator(read_profile)]

#: No profile: the dimension is uniform.
UNIFORM = Profile()
