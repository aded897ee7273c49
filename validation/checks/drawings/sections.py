"""Sections of bodies of bricks: what is where, what holds it, what acts on it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from tactgen.geometry.arrays import Floats
from tactgen.validation.checks.drawings.drawing import (
    Area,
    Drawing,
    Line,
    LineKind,
    Mark,
    Point,
    rectangle,
)

if TYPE_CHECKING:
    from tactgen.geometry.bimorph.bricks import Slab
    from tactgen.validation.checks.cases.boxes import Box, Held, Load

#: Arrows of a load that is spread over a side.
_ARROWS = 5
#: A section longer than this is stretched, so that its layers can be seen.
_LONG = 5.0


def section(
    make: Callable[..., Box],
    *arguments: Any,
    unit: str = "mm",
    plane: tuple[str, str] = ("z", "x"),
    **named: Any,
) -> Callable[[], Drawing]:
    """Return what draws the section of a box that `make` gives; `plane` names its two axes.

    Boxes are in metres where the unit is mm, and in that unit itself where it is another.
    """
    return lambda: _Section(make(*arguments, **named), unit, plane).drawing()


@dataclass(frozen=True)
class _Section:
    """A box and the plane it is cut in."""

    box: Box
    unit: str
    plane: tuple[str, str]

    @property
    def scale(self) -> float:
        return 1e3 if self.unit == "mm" else 1.0

    def breaks(self, axis: str) -> Floats:
        """Return the break points along an axis, in the drawing's unit."""
        return np.asarray(getattr(self.box, axis).breaks * self.scale)

    @property
    def low(self) -> Point:
        h, v = self.plane
        return float(self.breaks(h)[0]), float(self.breaks(v)[0])

    @property
    def high(self) -> Point:
        h, v = self.plane
        return float(self.breaks(h)[-1]), float(self.breaks(v)[-1])

    def drawing(self) -> Drawing:
        """Return all of it."""
        (x0, y0), (x1, y1) = self.low, self.high
        across, up = (self.breaks(axis).tolist() for axis in self.plane)
        lines = [Line(((at, y0), (at, y1)), "division") for at in across]
        lines += [Line(((x0, at), (x1, at)), "division") for at in up]
        marks: list[Mark] = []
        for hold in self.box.held:
            lines += self._side(hold)
            marks += self._prop(hold)
        for load in self.box.loads:
            marks += self._arrows(load)
        h, v = (f"{axis} ({self.unit})" for axis in self.plane)
        long = (x1 - x0) / (y1 - y0)
        return Drawing(
            tuple(self._part(slab) for slab, _ in self.box.parts),
            tuple(lines), tuple(marks), (h, v), equal=1.0 / _LONG < long < _LONG,
        )  # fmt: skip

    def _part(self, slab: Slab) -> Area:
        """Return a part, which spans the whole of y; parts that differ by a number look alike."""
        spans = {"x": slab.x, "y": (0, -1), "z": slab.z}
        h, v = ((self.breaks(axis), spans[axis]) for axis in self.plane)
        (a, (a0, a1)), (b, (b0, b1)) = h, v
        low, high = (float(a[a0]), float(b[b0])), (float(a[a1]), float(b[b1]))
        return rectangle(low, high, slab.region.rstrip(" 0123456789"))

    def _places(self, hold: Held) -> tuple[float | None, float | None] | None:
        """Return where on the two axes something is held; None if that is out of the plane."""
        at: dict[str, Any] = {axis: getattr(hold.where, axis) for axis in "xyz"}
        if any(at[axis] is not None for axis in {"x", "y", "z"} - set(self.plane)):
            return None
        h, v = (at[axis] for axis in self.plane)
        if isinstance(h, tuple) or isinstance(v, tuple):
            return None
        return (
            None if h is None else float(h) * self.scale,
            None if v is None else float(v) * self.scale,
        )

    def _side(self, hold: Held) -> list[Line]:
        """Return a support or electrode that covers a side of the section."""
        kind: LineKind = "potential" if hold.components == ("phi",) else "held"
        (x0, y0), (x1, y1) = self.low, self.high
        match self._places(hold):
            case (float(h), None):
                return [Line(((h, y0), (h, y1)), kind)]
            case (None, float(v)):
                return [Line(((x0, v), (x1, v)), kind)]
        return []

    def _prop(self, hold: Held) -> list[Mark]:
        """Return a hinge for a held line of the body that is seen from its end."""
        match self._places(hold):
            case (float(h), float(v)):
                return [Mark("hinge", (h, v))]
        return []

    def _arrows(self, load: Load) -> list[Mark]:
        """Return arrows along a load, if it acts in the plane."""
        if load.component not in self.plane:
            return []
        turn = 90.0 * self.plane.index(load.component)
        places = [self._along(getattr(load.where, axis), at) for at, axis in enumerate(self.plane)]
        marks = []
        for point in ((h, v) for h in places[0] for v in places[1]):
            grid = dict(zip(self.plane, point, strict=True))
            x, y, z = (np.array(grid.get(axis, 0.0) / self.scale) for axis in "xyz")
            value = float(load.value(x, y, z) if callable(load.value) else load.value)
            if value != 0.0:
                marks.append(Mark("force", point, turn + (180.0 if value < 0.0 else 0.0)))
        return marks

    def _along(self, where: float | tuple[float, float] | None, at: int) -> list[float]:
        """Return where the arrows of a load stand on one axis."""
        if isinstance(where, float):
            return [where * self.scale]
        if where is None:
            return list(np.linspace(self.low[at], self.high[at], _ARROWS).tolist())
        first, last = where
        return list(np.linspace(first * self.scale, last * self.scale, _ARROWS).tolist())
