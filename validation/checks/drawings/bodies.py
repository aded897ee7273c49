"""Bodies of revolution as half sections, and a slot beside a gap."""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import TYPE_CHECKING

import numpy as np

from tactgen.validation.checks.drawings.drawing import Area, Drawing, Line, Mark, Point, rectangle

if TYPE_CHECKING:
    from tactgen.geometry.reluctance.section_grid import Region

#: A device longer than so many radii lies on its side; a part below this share of it is marked.
_LONG, _SEEN = 5.0, 0.01
#: Points along an ellipse.
_POINTS = 41


def rings(regions: Iterable[Region], *, unit: str = "mm") -> Drawing:
    """Return the half section of iron and windings.

    A long device lies on its side, radii upwards and stretched; a part too small to be seen has
    a mark.
    """
    scale = 1e3 if unit == "mm" else 1.0
    parts = tuple(regions)
    radius = max(part.radii[1] for part in parts)
    low, high = min(part.heights[0] for part in parts), max(part.heights[1] for part in parts)
    lying = high - low > _LONG * radius
    size = max(radius, high - low)

    def placed(r: float, z: float) -> Point:
        return (z * scale, r * scale) if lying else (r * scale, z * scale)

    areas, marks = [], []
    for part in parts:
        (r0, r1), (z0, z1) = part.radii, part.heights
        what = "winding" if part.turns else "air" if part.curve is None else "iron"
        name = f"{what}, moves" if part.moves else what
        areas.append(rectangle(placed(r0, z0), placed(r1, z1), name))
        if max(r1 - r0, z1 - z0) < _SEEN * size:
            marks.append(Mark("mass", placed(0.5 * (r0 + r1), 0.5 * (z0 + z1))))
    labels = (f"r ({unit})", f"z ({unit})")
    axis = Line((placed(0.0, low), placed(0.0, high)), "axis")
    return Drawing(
        tuple(areas), (axis,), tuple(marks), labels[::-1] if lying else labels, equal=not lying
    )


def in_uniform_field(*, length: float = 1.0, hollow: float = 0.0) -> Drawing:
    """Return half a ball or spheroid of iron of radius 1, perhaps hollow, in a field along z."""
    half = (-0.5 * math.pi, 0.5 * math.pi)
    outer = ellipse(1.0, length, turns=half)
    inner = tuple(reversed(ellipse(hollow, hollow * length, turns=half))) if hollow else ()
    reach = 1.6 * max(1.0, length)
    flux = [Line(((r, -reach), (r, reach)), "flux") for r in (0.3, 0.9, 1.5)]
    axis = Line(((0.0, -reach), (0.0, reach)), "axis")
    return Drawing((Area((*outer, *inner), "iron"),), (axis, *flux), (), ("r (radii)", "z (radii)"))


def slotted_gap(width: float, depth: float) -> Drawing:
    """Return half of two facing iron faces, a gap of 1 apart, a slot in the upper one."""
    end = 0.5 * width + 2.5
    upper = ((0.5 * width, 1.0), (end, 1.0), (end, 2.0 + depth), (0.0, 2.0 + depth),
             (0.0, 1.0 + depth), (0.5 * width, 1.0 + depth))  # fmt: skip
    lower = rectangle((0.0, -1.0), (end, 0.0), "iron")
    middle = Line(((0.0, -1.0), (0.0, 2.0 + depth)), "axis")
    words = Mark("text", (0.7 * end, 0.15), 90.0, "gap"), Mark("text", (0.05, 2.0), 0.0, "slot")
    return Drawing((lower, Area(upper, "iron")), (middle,), words, ("x (gaps)", "z (gaps)"))


def ellipse(
    radius: float,
    height: float,
    *,
    centre: Point = (0.0, 0.0),
    turns: tuple[float, float] = (0.0, 2.0 * math.pi),
) -> tuple[Point, ...]:
    """Return points along an ellipse, or from one angle of it to another."""
    x, y = centre
    angles = np.linspace(*turns, _POINTS).tolist()
    return tuple((x + radius * math.cos(t), y + height * math.sin(t)) for t in angles)
