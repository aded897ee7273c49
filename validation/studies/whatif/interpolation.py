"""Parts of a study that a model's surrogate answers: many points over a few numbers.

A surrogate pays where there are more points than it is made from, by a model that takes long.
Where it cannot be made, or is not accurate enough, the points are solved one by one.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from tactgen.geometry.arrays import Floats
from tactgen.geometry.errors import InputError
from tactgen.geometry.formats import share
from tactgen.validation.catalogue.models import MODELS, gives, reading
from tactgen.validation.engine.answers import Answer
from tactgen.validation.engine.solve import check_scene
from tactgen.validation.engine.surrogate import (
    MOST_KEYS,
    Ranges,
    Surrogate,
    design_points,
    design_scene,
    design_size,
    fit_surrogate,
)
from tactgen.validation.engine.warnings import number_warnings, request_warnings
from tactgen.validation.models.model import Quantity
from tactgen.validation.scene.keys import read_as
from tactgen.validation.scene.scene import Scene
from tactgen.validation.scene.variation import ScenesNearby
from tactgen.validation.studies.whatif.axes import as_stated, scene_field
from tactgen.validation.studies.whatif.point_answers import reason

#: Values by key.
Point = Mapping[str, Any]

#: Keys and groups that say how a model is solved, and that nothing is smooth over.
_NUMERICAL = ("mesh", "accuracy", "modes", "frequency", "limits", "beam")
#: Error of interpolation up to which a surrogate serves, relative: that of the answers, or this.
_LEAST_ACCURACY = 1e-2
#: Points up to which it is looked which of them make scenes, before the range is chosen; and from
#: which a surrogate may pay.
_CHECKED, _MANY_ENOUGH = 2000, design_size(1)
#: Points whose answers are given at a time.
_BLOCK = 1024


@dataclass(frozen=True)
class Part:
    """Points of a study that differ for a model in a few numbers only."""

    model: str  #: Its name
    quantities: tuple[str, ...]  #: Those of the study that it gives
    numbers: tuple[int, ...]  #: Places of the points
    ranges: Ranges  #: Lowest and highest value (SI) of the keys in which they differ
    first: Point  #: The first of the points
    nearby: ScenesNearby  #: The model's scenes

    @property
    def key(self) -> str:
        """Identity of its surrogate within the study."""
        others = [value for key, value in self.first.items() if key not in self.ranges]
        return repr((self.model, self.ranges, others))

    @property
    def reason(self) -> str:
        """Description of the interpolation."""
        return (
            f"{self.model}: {len(self.numbers)} points differ in {', '.join(self.ranges)} only and "
            f"are interpolated between {design_size(len(self.ranges))} solutions"
        )

    def scene(self, point: Point) -> Scene:
        """Scene at a point; InputError if there is none."""
        found = self.nearby.scene(as_stated(point))
        check_scene(found, (self.model,), self.quantities)
        return found

    def design(self) -> list[dict[str, Any]]:
        """Points that the surrogate is made from, with the modes that it needs.

        Raises InputError if the first point makes no scene.
        """
        base = self.scene(self.first)
        modes = design_scene(base, self.quantities).modes
        more = {"modes": modes} if modes != base.modes else {}
        return [{**self.first, **point, **more} for point in design_points(self.ranges)]

    def surrogate(self, given: Sequence[Answer]) -> Surrogate:
        """Surrogate through the answers at :meth:`design`.

        Raises InputError if it cannot be made, or is off by more than the accuracy that is wanted.
        """
        scene = self.scene(self.first)
        answers = [one.quantities if one.status == "ok" else None for one in given]
        found = fit_surrogate(scene, self.ranges, answers)
        for name in found.fits:
            error = found.interpolation_error(name)
            if error > max(scene.accuracy, _LEAST_ACCURACY):
                raise InputError(f"{name} would be interpolated to {share(error)} only")
        return found

    def answers(
        self, surrogate: Surrogate, points: Sequence[Point], announce: Callable[[str], None]
    ) -> dict[int, Answer]:
        """Answers by place; refused points are left out."""
        found: dict[int, Answer] = {}
        for start in range(0, len(self.numbers), _BLOCK):
            announce(f"{self.model}: {start} of {len(self.numbers)} points interpolated")
            scenes: dict[int, Scene] = {}
            for number in self.numbers[start : start + _BLOCK]:
                try:
                    scenes[number] = self.scene(points[number])
                except InputError as error:
                    found[number] = Answer("refused", reason(error))
            values: dict[str, Floats] = {
                key: np.array([float(points[n][key]) for n in scenes]) for key in self.ranges
            }
            known = surrogate.answers(values) if scenes else ()
            for (number, scene), given in zip(scenes.items(), known, strict=True):
                if answer := _with_warnings(scene, self.model, given):
                    found[number] = answer
        return found


def find_parts(
    model: str,
    quantities: Sequence[str],
    points: Sequence[Point],
    nearby: ScenesNearby,
    ranges: Ranges | None = None,
) -> list[Part]:
    """Parts of a study that a model's surrogate is to answer, maybe none.

    With `ranges`, of which many more points will be asked, it pays for few.
    """
    wanted = tuple(name for name in quantities if gives(model, name))
    if MODELS[model].quick or not wanted or not points:
        return []
    own = {key for key in points[0] if _is_smooth(model, key, points)}
    groups: dict[str, list[int]] = {}
    for number, point in enumerate(points):
        others = repr([value for key, value in point.items() if key not in own])
        groups.setdefault(others, []).append(number)
    found = []
    for numbers in groups.values():
        if ranges is not None:
            over: Ranges = {key: ends for key, ends in ranges.items() if key in own}
        elif len(numbers) > _MANY_ENOUGH:
            if len(numbers) <= _CHECKED:  # the range ends where the parts no longer fit
                numbers = [n for n in numbers if _is_scene(nearby, points[n])]
            over = _ranges(points, numbers, own)
        else:
            continue
        if not 0 < len(over) <= MOST_KEYS:
            continue
        different = {tuple(points[n][key] for key in over) for n in numbers}
        if len(different) > (design_size(len(over)) if ranges is None else 0):
            found.append(Part(model, wanted, tuple(numbers), over, points[numbers[0]], nearby))
    return found


def _is_scene(nearby: ScenesNearby, point: Point) -> bool:
    try:
        nearby.scene(as_stated(point))
    except InputError:
        return False
    return True


def _ranges(points: Sequence[Point], numbers: Sequence[int], own: set[str]) -> Ranges:
    found = {}
    for key in (key for key in points[0] if key in own):
        values = [float(points[n][key]) for n in numbers]
        if values and min(values) < max(values):
            found[key] = min(values), max(values)
    return found


def _is_smooth(model: str, key: str, points: Sequence[Point]) -> bool:
    """Whether a key is a number over which a model's answers may be interpolated."""
    field, value = scene_field(key), points[0][key]
    if not field.numeric or field.whole or not isinstance(value, float):
        return False
    key = read_as(key)
    group = key.partition(".")[0]
    if group in _NUMERICAL:
        return False
    read = {path for stage in MODELS[model].stages.values() for path in stage}
    return bool({key, group} & (read | set(reading(model))))


def _with_warnings(scene: Scene, model: str, given: tuple[Quantity, ...]) -> Answer | None:
    """Answer with its warnings; None where the request is refused."""
    names = [quantity.name for quantity in given]
    try:
        warnings = request_warnings(scene, (model,), names) + number_warnings(scene, given)
    except InputError:
        return None
    return Answer("ok", "", given, warnings, sum(quantity.seconds for quantity in given))
