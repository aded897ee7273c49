"""Large parts of a study that differ in a family's numbers only, read off in blocks.

No point is asked a question of its own there, nor looked for in the store: both would take
longer than to read it off the reduced basis.
"""

from __future__ import annotations

import os
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import dataclass
from typing import Any

import numpy as np

from tactgen.geometry.errors import InputError
from tactgen.validation.catalogue.models import gives
from tactgen.validation.engine.answers import Answer
from tactgen.validation.engine.families import (
    MOST_KEYS,
    Box,
    ReducedModel,
    basis,
    family_keys,
    gives_families,
    reduce_family,
)
from tactgen.validation.engine.plan import check_scene
from tactgen.validation.engine.results import Quantity
from tactgen.validation.scene.nearby import ScenesNearby
from tactgen.validation.scene.scene import Scene
from tactgen.validation.studies.whatif.answers import question, reason
from tactgen.validation.studies.whatif.asked.scene_field import as_stated
from tactgen.validation.studies.whatif.by_family import answer_with_warnings

#: Points of one family from which they are read off in blocks.
MANY = 1000
#: Points of one block: their scenes are held at once.
_BLOCK = 1024
#: Points that are tried for one that makes a scene.
_TRIED = 100

Point = dict[str, Any]
#: Places of points, their scenes, and the answers that are being read off.
_Block = tuple[list[int], list[Scene], Future[list[tuple[Quantity, ...]]]]


@dataclass(frozen=True)
class Swept:
    """Answers by the points' places, refusals among them, and how many differ from one another."""

    answers: dict[int, Answer]
    different: int


def sweep(
    model: str,
    quantities: Sequence[str],
    points: Sequence[Point],
    nearby: ScenesNearby,
    announce: Callable[[str], None] = lambda _: None,
    box: Box | None = None,
) -> Swept:
    """Return the answers of a model at the points that it answers in blocks, maybe none.

    Parameters
    ----------
    nearby : ScenesNearby
        The scenes of the points.
    box : dict of str to (float, float), optional
        The range of keys of which more will be asked.
    """
    found: dict[int, Answer] = {}
    different, earlier = 0, dict[tuple[object, ...], tuple[int, ...]]()
    for part in parts(model, quantities, points, nearby):
        same = part.stands_for()
        if same in earlier:  # it differs in what the model does not read
            pairs = zip(part.numbers, earlier[same], strict=True)
            found |= {number: found[other] for number, other in pairs if other in found}
            continue
        earlier[same] = part.numbers
        new = part.answers(box, announce)
        found |= new
        different += sum(answer.status == "ok" for answer in new.values())
    return Swept(found, different)


def parts(
    model: str, quantities: Sequence[str], points: Sequence[Point], nearby: ScenesNearby
) -> list[Part]:
    """Return the parts of a study that a model answers in blocks, maybe none."""
    wanted = tuple(name for name in quantities if gives(model, name))
    if len(points) < MANY or not wanted or not gives_families(model, wanted):
        return []
    first = _first_scene(points, nearby)
    if first is None:
        return []
    own = set(family_keys(model, first, points[0]))
    groups: dict[str, list[int]] = {}
    for number, point in enumerate(points):
        rest = repr([value for key, value in point.items() if key not in own])
        groups.setdefault(rest, []).append(number)
    found = []
    for numbers in groups.values():
        keys = _varied(points, numbers, own)
        if len(numbers) >= MANY and 0 < len(keys) <= MOST_KEYS:
            found.append(Part(model, wanted, points, nearby, tuple(numbers), keys))
    return found


def _first_scene(points: Sequence[Point], nearby: ScenesNearby) -> Scene | None:
    for point in points[:_TRIED]:
        try:
            return nearby.scene(_stated(point))
        except InputError:
            continue
    return None


def _varied(points: Sequence[Point], numbers: Sequence[int], own: set[str]) -> tuple[str, ...]:
    first = points[numbers[0]]
    return tuple(
        key for key in first if key in own and any(points[n][key] != first[key] for n in numbers)
    )


def _stated(point: Point) -> Point:
    return {key: as_stated(key, value) for key, value in point.items()}


@dataclass(frozen=True)
class Part:
    """Points, by their `numbers`, that differ in `keys` only."""

    model: str
    quantities: tuple[str, ...]
    points: Sequence[Point]
    nearby: ScenesNearby
    numbers: tuple[int, ...]
    keys: tuple[str, ...]

    @property
    def reason(self) -> str:
        """Why they are answered in blocks, for the reader."""
        return (
            f"{self.model}: {len(self.numbers)} points differ in {', '.join(self.keys)} only and "
            f"are read off {basis(self.model)}"
        )

    @property
    def scene(self) -> Scene:
        """The first of their scenes; InputError if it is none."""
        return self.nearby.scene(_stated(self.points[self.numbers[0]]))

    def ranges(self, box: Box | None = None) -> dict[str, tuple[float, float]]:
        """Return the range of the keys, or that of which more will be asked."""
        found = {}
        for key in self.keys:
            values = [float(self.points[n][key]) for n in self.numbers]
            found[key] = (box or {}).get(key, (min(values), max(values)))
        return found

    def stands_for(self) -> tuple[object, ...]:
        """Return what the answers at these points depend on."""
        values = tuple(tuple(self.points[n][key] for key in self.keys) for n in self.numbers)
        try:
            return repr(question(self.scene, self.model, self.quantities).inputs), values
        except InputError:
            return self.numbers[0], values

    def answers(self, box: Box | None, announce: Callable[[str], None]) -> dict[int, Answer]:
        """Return the answers by place; none where the model cannot reduce the range."""
        found: dict[int, Answer] = {}
        waiting: deque[_Block] = deque()
        threads = len(os.sched_getaffinity(0))
        reduced: ReducedModel | None = None
        announce(self.reason)
        with ThreadPoolExecutor(threads) as pool:
            for block, scenes in self._blocks(found):
                try:
                    reduced = reduced or reduce_family(
                        self.model, scenes[0], self.ranges(box), self.quantities,
                        len(self.numbers), announce,
                    )  # fmt: skip
                except InputError as error:
                    announce(f"{self.model}: one by one, since {error}")
                    return {}
                values = {k: np.array([float(self.points[n][k]) for n in block]) for k in self.keys}
                waiting.append((block, scenes, pool.submit(reduced.answers, values)))
                if len(waiting) > threads:
                    self._take(waiting.popleft(), found, announce)
                announce(f"{self.model}: {len(found)} of {len(self.numbers)} points")
            while waiting:
                self._take(waiting.popleft(), found, announce)
        return found

    def _blocks(self, refused: dict[int, Answer]) -> Iterator[tuple[list[int], list[Scene]]]:
        """Yield points that make scenes, with these; the others are refused."""
        for start in range(0, len(self.numbers), _BLOCK):
            block, scenes = [], []
            for number in self.numbers[start : start + _BLOCK]:
                try:
                    scene = self.nearby.scene(_stated(self.points[number]))
                    check_scene(scene, (self.model,), self.quantities)
                except InputError as error:
                    refused[number] = Answer("refused", reason(error))
                    continue
                block.append(number)
                scenes.append(scene)
            if block:
                yield block, scenes

    def _take(
        self,
        block: _Block,
        found: dict[int, Answer],
        announce: Callable[[str], None],
    ) -> None:
        """Add the answers of a block; where they cannot be given, these points are left out."""
        numbers, scenes, future = block
        try:
            given = future.result()
        except InputError as error:
            announce(f"{self.model}: {len(numbers)} points one by one, since {error}")
            return
        for number, scene, quantities in zip(numbers, scenes, given, strict=True):
            answer = answer_with_warnings(scene, self.model, quantities)
            if answer is not None:
                found[number] = answer
