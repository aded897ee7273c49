"""A drawing as data: areas of a material, lines, and marks whose size does not follow the scale.

Who draws it is :mod:`validation.book.sketch`; here is only what stands where.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

Point = tuple[float, float]

LineKind = Literal["division", "held", "potential", "axis", "spring", "damper", "flux"]
MarkKind = Literal["force", "hinge", "mass", "turning spring", "text"]


@dataclass(frozen=True)
class Area:
    """A closed outline filled with a material; areas of one material share colour and legend."""

    outline: tuple[Point, ...]
    material: str


@dataclass(frozen=True)
class Line:
    """A line through points.

    A held one is hatched, one at a given potential thick, a spring or damper joins its two ends.
    """

    points: tuple[Point, ...]
    kind: LineKind


@dataclass(frozen=True)
class Mark:
    """A sign at a point, of the same size in every drawing.

    Attributes
    ----------
    direction : float
        Where an arrow points (degrees from the horizontal).
    text : str
        What stands beside it.
    """

    kind: MarkKind
    at: Point
    direction: float = 0.0
    text: str = ""


@dataclass(frozen=True)
class Drawing:
    """All that is drawn.

    Attributes
    ----------
    labels : (str, str)
        Names of the axes with their units; an axis without a unit has no numbers.
    equal : bool
        Whether both axes have one scale; else heights are stretched to be seen.
    """

    areas: tuple[Area, ...] = ()
    lines: tuple[Line, ...] = ()
    marks: tuple[Mark, ...] = ()
    labels: tuple[str, str] = ("", "")
    equal: bool = True


def rectangle(low: Point, high: Point, material: str) -> Area:
    """Return a rectangle between two corners."""
    (x0, y0), (x1, y1) = low, high
    return Area(((x0, y0), (x1, y0), (x1, y1), (x0, y1)), material)
