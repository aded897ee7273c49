"""Derivatives of the axisymmetric field at its point: for :mod:`validation.engine.derivatives`.

On one grid that goes along with the dimension, values are smooth in it, and their differences can
be close: the grid's own error hardly changes.  What is left of it is judged as that of a value is:
by the derivative at the lower polynomial order, and of the pull by that of the stress in the air.
As two of them may agree by chance, the bar is never less, in relation, than that of the value.

Where edges of two parts are level at the scene, and part beside it, no one grid reaches to both
sides: the derivative is the mean of those from either side, each on its own grid.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING

import numpy as np

from tactgen.geometry.arrays import Floats, Numbers
from tactgen.validation.catalogue.quantities import INCREMENTAL_INDUCTANCE, QUANTITIES
from tactgen.validation.catalogue.row import AnswerReadout
from tactgen.validation.engine.derivatives import (
    PLACES,
    Changed,
    Derivatives,
    by_differences,
    extrapolated,
    noise,
    within,
)
from tactgen.validation.engine.results import Estimate
from tactgen.validation.engine.solve import solve
from tactgen.validation.models.reluctance.field import REFINEMENTS
from tactgen.validation.models.reluctance.point import MagneticPoint
from tactgen.validation.scene.nearby import value_of
from tactgen.validation.scene.scene import Scene

if TYPE_CHECKING:
    from tactgen.fem.magnetics.axisymmetric import FieldPoint
    from tactgen.fem.magnetics.axisymmetric_path import FieldPath

#: Relative distance of the values: truncation, as its fourth power, and rounding over it then
#: both leave less than the grid does.
_DISTANCE = 1e-2
#: Relative rounding of a value: where Newton's method stops.  The lower order may stop a hundred
#: times earlier; it alone makes the bar, and moves that by less than a hundredth.
_ROUNDING = 1e-8
#: A value that counts as none.
_TINY = float(np.finfo(float).tiny)
#: Values at a scene and at half and all of the distance to one side give the derivative there.
_ONE_SIDE = np.array([-3.0, 4.0, -1.0])


def gives_derivatives(scene: Scene, quantity: str) -> bool:
    """Return whether it is a smooth value at one current and gap.

    The incremental inductance follows the corners of the iron's curve.
    """
    row = QUANTITIES[quantity]
    return row.needs == ("magnetic_point",) and row is not INCREMENTAL_INDUCTANCE


def exact_derivatives(
    scene: Scene,
    changed: Changed,
    quantities: Sequence[str],
    keys: Sequence[str],
    announce: Callable[[str], None] = lambda _: None,
) -> list[Derivatives]:
    """Return quantities of the scene by the axisymmetric field, each with derivatives by `keys`.

    Raises
    ------
    InputError
        If the model does not know the scene, or one next to it makes no device.
    """
    from tactgen.fem.magnetics.axisymmetric_path import FieldPath

    refinement = next(fineness for bar, fineness in REFINEMENTS if scene.accuracy >= bar)
    varied = [_Key(scene, changed, key, refinement) for key in keys]  # before all that takes time
    base = solve(scene, ("axisymmetric",), quantities, announce)
    slopes: dict[str, dict[str, Numbers]] = {name: {} for name in quantities}
    bars: dict[str, dict[str, Floats]] = {name: {} for name in quantities}
    home = FieldPath(scene.device, scene.gap, refinement=refinement)
    home.at(scene.device, scene.coil.current, scene.gap, np.zeros(1))
    for number, (key, each) in enumerate(zip(keys, varied, strict=True)):
        announce(f"axisymmetric: derivative {number + 1} of {len(keys)}, {key}")
        found = each.slopes(home, quantities)
        if found is None:  # edges that no grid can follow
            other = by_differences(scene, changed, "axisymmetric", quantities, [key], announce)
            found = {d.quantity.name: (d.slopes[key], d.bars[key]) for d in other}
        for name, (slope, bar) in found.items():
            value = base.get(name, "axisymmetric")
            share = float(value.error) / max(abs(float(value.value)), _TINY)
            slopes[name][key] = slope
            bars[name][key] = np.maximum(bar, np.abs(slope) * share)
    method = (
        f"differences at {100 * _DISTANCE:g} and {50 * _DISTANCE:g} % on a grid that moves with "
        "the key; the bar is how far the derivative at the lower polynomial order is off, of the "
        "pull also that of the stress in the air, with truncation and rounding, and no less in "
        "relation than that of the value"
    )
    return [
        Derivatives(base.get(name, "axisymmetric"), slopes[name], bars[name], method)
        for name in quantities
    ]


class _Key:
    """One key of a scene that is varied a little."""

    def __init__(self, scene: Scene, changed: Changed, key: str, refinement: float) -> None:
        self._scene, self._changed, self._key = scene, changed, key
        self._refinement = refinement
        self._value = float(value_of(scene, key))
        self._distance = within(changed, key, self._value, _DISTANCE * abs(self._value))
        self._scenes = [self._at(float(place)) for place in PLACES]

    def slopes(
        self, home: FieldPath, quantities: Sequence[str]
    ) -> dict[str, tuple[Numbers, Floats]] | None:
        """Return by quantity the derivative and its bar; None where no grid follows the key."""
        if all(home.reaches(each.device, each.gap) for each in self._scenes):
            scenes = zip(self._scenes, PLACES, strict=True)
            points = [_solved(home.fork(), s, x) for s, x in scenes]
            return {name: self._central(_values(points, name)) for name in quantities}
        sides = []
        for side in (1.0, -1.0):
            path = self._path(self._at(side))
            if not path.reaches(self._scene.device, self._scene.gap):
                return None
            places = (0.0, 0.5 * side, side)
            sides.append([_solved(path, self._at(x), x) for x in reversed(places)][::-1])
        return {
            name: self._of_sides([_values(points, name) for points in sides]) for name in quantities
        }

    def _path(self, scene: Scene) -> FieldPath:
        from tactgen.fem.magnetics.axisymmetric_path import FieldPath

        return FieldPath(scene.device, scene.gap, refinement=self._refinement)

    def _at(self, place: float) -> Scene:
        if place == 0.0:
            return self._scene
        return self._changed(self._key, self._value + place * self._distance)

    def _central(self, values: Floats) -> tuple[Numbers, Floats]:
        (slope, truncated), (lower, _), (other, _) = (
            extrapolated(row, self._distance) for row in values
        )
        return self._judged(values, slope, truncated, lower, other)

    def _of_sides(self, sides: Sequence[Floats]) -> tuple[Numbers, Floats]:
        right, left = (
            sign * (values @ _ONE_SIDE) / self._distance
            for sign, values in zip((1.0, -1.0), sides, strict=True)
        )
        slope, lower, other = 0.5 * (right + left)
        apart = np.abs(right[0] - left[0])
        return self._judged(np.concatenate(sides, axis=1), slope, apart, lower, other)

    def _judged(
        self, values: Floats, slope: Numbers, truncated: Floats, lower: Numbers, other: Numbers
    ) -> tuple[Numbers, Floats]:
        if (values == values[:, :1]).all():  # what is the same to the last bit: not read
            return slope, np.zeros(())
        rounding = noise(_ROUNDING * np.abs(values[0]).max(), self._distance)
        return slope, np.asarray(abs(slope - lower) + abs(slope - other) + truncated + rounding)


def _solved(path: FieldPath, scene: Scene, place: float) -> FieldPoint:
    return path.at(scene.device, scene.coil.current, scene.gap, np.array([place]))


def _values(points: Sequence[FieldPoint], name: str) -> Floats:
    """Return a quantity (3, n): by the wanted order, by the lower, with the pull by the stress."""
    read = QUANTITIES[name].read
    assert isinstance(read, AnswerReadout)

    def of(point: FieldPoint, values: dict[str, float]) -> float:
        force, linkage, energy, inductance = (
            Estimate(values[part], 0.0)
            for part in ("force", "flux_linkage", "coenergy", "incremental_inductance")
        )
        whole = MagneticPoint(point.current, point.gap, force, linkage, energy, inductance, "", 0.0)
        return float(read.of(whole).value)

    own = [{part: getattr(p, part) for part in p.coarser} for p in points]
    stress = [{**values, "force": p.force_eggshell} for values, p in zip(own, points, strict=True)]
    lower = [p.coarser for p in points]
    return np.array(
        [[of(p, v) for p, v in zip(points, each, strict=True)] for each in (own, lower, stress)]
    )
