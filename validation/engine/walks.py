"""Scenes solved one after another, each from those before, where a model has such a way.

A walk shares what nearby scenes have in common, such as a grid that moves or a table of maps, and
gives what each alone would, at less cost.  How it goes depends on the scenes it is made for only.
"""

from __future__ import annotations

import importlib
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Protocol, cast

from tactgen.validation.catalogue.models import MODELS
from tactgen.validation.catalogue.quantities import QUANTITIES
from tactgen.validation.engine.costs import record, recorded
from tactgen.validation.engine.families import Box, alike, ranges_of
from tactgen.validation.engine.prospects import Prospect
from tactgen.validation.engine.results import Quantity
from tactgen.validation.scene.scene import Scene

#: Scenes of one walk: a study has as many walks as these make, side by side.
LONGEST = 16


class Walk(Protocol):
    """What solves scenes within its ranges."""

    def solved(self, scene: Scene) -> tuple[tuple[Quantity, ...], tuple[str, ...]]:
        """Return a scene's quantities, and what must be told of them."""


class WalkModule(Protocol):
    """What a module for walks of a model has."""

    def is_walk_key(self, scene: Scene, key: str) -> bool:
        """Return whether a scene key may vary within a walk."""

    def walk_shares(
        self, scene: Scene, ranges: Box, quantities: Sequence[str], members: int
    ) -> tuple[str, Prospect] | None:
        """Return what all walks of these ranges share and compute once, if anything.

        In words, whether it is kept, and what one as large took here.
        """

    def walk_parts(
        self, scene: Scene, ranges: Box, quantities: Sequence[str], members: int
    ) -> Sequence[Callable[[], object]]:
        """Return what of that can be computed and kept side by side, by other processes."""

    def prepare_walk(
        self,
        scene: Scene,
        ranges: Box,
        quantities: Sequence[str],
        members: int,
        announce: Callable[[str], None],
    ) -> None:
        """Compute what the walks of these ranges share, and keep it."""  # fmt: skip

    def begin_walk(
        self, scene: Scene, ranges: Box, quantities: Sequence[str], members: int
    ) -> Walk:
        """Return a walk over scenes that differ from one in numbers of these ranges."""


@dataclass(frozen=True)
class Route:
    """Scenes that a model solves one after another.

    Attributes
    ----------
    model : str
        Its name.
    numbers : tuple of int
        Places of the scenes in the list that was looked at.
    scene : Scene
        The first of them.
    ranges : dict of str to (float, float)
        Lowest and highest value (SI) of the scene keys in which they differ, or may.
    """

    model: str
    numbers: tuple[int, ...]
    scene: Scene
    ranges: Box

    @property
    def reason(self) -> str:
        """How they are solved, for the reader."""
        return (
            f"{self.model}: {len(self.numbers)} points over {', '.join(self.ranges)} are solved "
            "one after another, each from those before"
        )

    def shares(self, quantities: Sequence[str]) -> tuple[str, Prospect] | None:
        """Return what all of them share and compute once, as of a walk's module."""
        return _module(self.model).walk_shares(
            self.scene, self.ranges, quantities, len(self.numbers)
        )

    def shared_parts(self, quantities: Sequence[str]) -> Sequence[Callable[[], object]]:
        """Return what of that can be computed and kept side by side, by other processes."""
        return _module(self.model).walk_parts(
            self.scene, self.ranges, quantities, len(self.numbers)
        )

    def prepare(self, quantities: Sequence[str], announce: Callable[[str], None]) -> None:
        """Compute what all of them share, and keep it."""
        _module(self.model).prepare_walk(
            self.scene, self.ranges, quantities, len(self.numbers), announce
        )

    def seconds(self, quantities: Sequence[str]) -> float | None:
        """Return what a scene took when the like were last walked through here, if recorded."""
        return recorded().get(self._cost_name(quantities))

    def took(self, quantities: Sequence[str], seconds: float) -> None:
        """Write down what a scene took."""
        record({self._cost_name(quantities): seconds})

    def _cost_name(self, quantities: Sequence[str]) -> str:
        needs = {need for name in quantities for need in QUANTITIES[name].needs}
        return f"{self.model} walked for {', '.join(sorted(needs))}"

    def parts(self) -> Iterator[tuple[int, ...]]:
        """Yield the places of scenes that are walked through one after another."""
        for start in range(0, len(self.numbers), LONGEST):
            yield self.numbers[start : start + LONGEST]

    def begin(self, quantities: Sequence[str]) -> Walk:
        """Return what solves some of them."""
        return _module(self.model).begin_walk(
            self.scene, self.ranges, quantities, len(self.numbers)
        )


def find_routes(model: str, scenes: Sequence[Scene], box: Box | None = None) -> list[Route]:
    """Return how scenes are solved each from those before, where there are more than one.

    With a `box`, a range of keys of which more will be asked, one is enough.
    """
    if not MODELS[model].walks or not scenes:
        return []
    module = _module(model)
    boxed = {k: ends for k, ends in (box or {}).items() if module.is_walk_key(scenes[0], k)}
    found = []
    for numbers, keys in alike(model, scenes, module.is_walk_key, tuple(boxed)):
        if boxed or (keys and len(numbers) > 1):
            own = [scenes[n] for n in numbers]
            found.append(Route(model, numbers, own[0], boxed or ranges_of(keys, own)))
    return found


def _module(model: str) -> WalkModule:
    return cast(WalkModule, importlib.import_module(MODELS[model].walks))
