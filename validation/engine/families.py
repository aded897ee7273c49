"""Many scenes of one family answered together, where a model has a faster way to them.

A family differs in a few numbers only.  A model whose row names a module for it reduces the
family once and then answers a scene in milliseconds; that pays beyond a few scenes.
"""

from __future__ import annotations

import importlib
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Protocol, cast

import numpy as np

from tactgen.geometry.arrays import Floats
from tactgen.validation.catalogue.models import MODELS, reading
from tactgen.validation.engine.inputs import values_read
from tactgen.validation.engine.prospects import Prospect
from tactgen.validation.engine.results import Quantity
from tactgen.validation.scene.nearby import value_of
from tactgen.validation.scene.scene import Scene

#: Most numbers that vary in a family: its range has 2^n corners.
MOST_KEYS = 4

#: Lowest and highest value (SI) of keys, of which many points will be asked.
Box = Mapping[str, tuple[float, float]]


class FamilyModule(Protocol):
    """What a module for families of a model has; `BASIS` is what points are read off, in words."""

    BASIS: str

    def is_family_key(self, scene: Scene, key: str) -> bool:
        """Return whether a scene key may vary within a family."""

    def least_members(self, keys: int) -> int:
        """Return the number of points up to which they are faster without, if so many keys vary."""

    def gives_family(self, quantity: str) -> bool:
        """Return whether a quantity is given for a family."""

    def reduce_family(
        self,
        scene: Scene,
        ranges: Box,
        quantities: Sequence[str],
        members: int,
        announce: Callable[[str], None],
    ) -> ReducedModel:
        """Return what answers for scenes that differ from `scene` in numbers of these ranges.

        About so many `members` will be asked.
        """

    def family_prospect(self, scene: Scene, ranges: Box, quantities: Sequence[str]) -> Prospect:
        """Return whether what it reduces is kept, and what it took to build one as large."""


class ReducedModel(Protocol):
    """A family that was reduced."""

    def answers(self, values: dict[str, Floats]) -> list[tuple[Quantity, ...]]:
        """Return the quantities of scenes whose numbers are `values` (n,) each.

        Raises
        ------
        InputError
            If the model cannot answer for all of them.
        """


@dataclass(frozen=True)
class Family:
    """Scenes that a model answers together.

    Attributes
    ----------
    model : str
        Its name.
    numbers : tuple of int
        Places of the scenes in the list that was looked at.
    keys : tuple of str
        Scene keys in which they differ.
    box : dict of str to (float, float), optional
        The range of these keys, if more of it will be asked.
    """

    model: str
    numbers: tuple[int, ...]
    keys: tuple[str, ...]
    box: Box | None = None

    @property
    def reason(self) -> str:
        """Why they are answered together, for the reader."""
        if self.box is not None:
            return f"{self.model}: the range of {', '.join(self.keys)} by {basis(self.model)}"
        least = _module(self.model).least_members(len(self.keys))
        return (
            f"{self.model}: {len(self.numbers)} points differ in {', '.join(self.keys)} only, and "
            f"more than {least} are answered faster by {basis(self.model)}"
        )


def basis(model: str) -> str:
    """Return what points of a family are read off by a model that has families, in words."""
    return _module(model).BASIS


def gives_families(model: str, quantities: Sequence[str]) -> bool:
    """Return whether a model gives all of these quantities for families of scenes."""
    return bool(MODELS[model].families) and all(map(_module(model).gives_family, quantities))


def family_keys(model: str, scene: Scene, keys: Iterable[str]) -> tuple[str, ...]:
    """Return which scene keys may vary within a family of a model that has families."""
    module = _module(model)
    return tuple(key for key in keys if module.is_family_key(scene, key))


def find_families(
    model: str, scenes: Sequence[Scene], quantities: Sequence[str], box: Box | None = None
) -> list[Family]:
    """Return the families among scenes for which a reduced basis pays.

    With a `box`, a range of keys of which many more points will be asked, it pays for few.
    """
    if not scenes or not gives_families(model, quantities):
        return []
    module = _module(model)
    if box is None and len(scenes) <= module.least_members(1):
        return []
    boxed = family_keys(model, scenes[0], box or ())
    if box is not None and not 0 < len(boxed) <= MOST_KEYS:
        return []
    groups = alike(model, scenes, module.is_family_key, boxed)
    if box is not None:
        own = {key: box[key] for key in boxed}
        return [Family(model, numbers, boxed, own) for numbers, _ in groups]
    return [
        Family(model, numbers, keys)
        for numbers, keys in groups
        if 0 < len(keys) <= MOST_KEYS and len(numbers) > module.least_members(len(keys))
    ]


def alike(
    model: str,
    scenes: Sequence[Scene],
    is_own: Callable[[Scene, str], bool],
    boxed: Sequence[str] = (),
) -> list[tuple[tuple[int, ...], tuple[str, ...]]]:
    """Return places of scenes that differ for a model in own keys only, and in which of them.

    Own are the keys that vary and of which `is_own` says so, or those of a box.
    """
    row = MODELS[model]
    reads = {key for stage in row.stages.values() for key in stage} | set(reading(model))
    flat = [_flat(values_read(scene, sorted(reads))) for scene in scenes]
    varied = [key for key in flat[0] if any(one.get(key) != flat[0][key] for one in flat)]
    own = boxed or [key for key in varied if is_own(scenes[0], key)]
    groups: dict[str, list[int]] = {}
    for number, values in enumerate(flat):
        rest = {key: value for key, value in values.items() if key not in own}
        groups.setdefault(repr(rest), []).append(number)
    return [
        (tuple(numbers), tuple(k for k in own if len({flat[n].get(k) for n in numbers}) > 1))
        for numbers in groups.values()
    ]


def answer_family(
    family: Family,
    scenes: Sequence[Scene],
    quantities: Sequence[str],
    announce: Callable[[str], None] = lambda _: None,
) -> list[tuple[Quantity, ...]]:
    """Return the quantities of each of a family's scenes, in the order of its numbers.

    Raises
    ------
    InputError
        If the model cannot reduce the family.
    """
    announce(family.reason)
    chosen = [scenes[number] for number in family.numbers]
    values = {
        key: np.array([value_of(scene, key) for scene in chosen], dtype=float)
        for key in family.keys
    }
    ranges = family_ranges(family, scenes)
    return reduce_family(
        family.model, chosen[0], ranges, quantities, len(chosen), announce
    ).answers(values)  # fmt: skip


def family_prospect(model: str, scene: Scene, ranges: Box, quantities: Sequence[str]) -> Prospect:
    """Return whether a family is kept already, and the seconds recorded for one as large.

    Raises
    ------
    InputError
        If the model cannot reduce the family.
    """
    return _module(model).family_prospect(scene, ranges, quantities)


def family_ranges(family: Family, scenes: Sequence[Scene]) -> Box:
    """Return the range of a family's keys over its scenes, or that of which more will be asked."""
    return family.box or ranges_of(family.keys, [scenes[number] for number in family.numbers])


def ranges_of(keys: Iterable[str], scenes: Sequence[Scene]) -> Box:
    """Return lowest and highest value (SI) of keys over scenes."""
    values = {key: [float(value_of(scene, key)) for scene in scenes] for key in keys}
    return {key: (min(each), max(each)) for key, each in values.items()}


def reduce_family(
    model: str,
    scene: Scene,
    ranges: Box,
    quantities: Sequence[str],
    members: int,
    announce: Callable[[str], None] = lambda _: None,
) -> ReducedModel:
    """Return what answers for about so many scenes that differ from one in at most four numbers.

    Raises
    ------
    InputError
        If the model cannot reduce the family.
    """
    return _module(model).reduce_family(scene, ranges, quantities, members, announce)


def _module(model: str) -> FamilyModule:
    return cast(FamilyModule, importlib.import_module(MODELS[model].families))


def _flat(values: dict[str, Any]) -> dict[str, Any]:
    """Return values by full key."""
    found: dict[str, Any] = {}
    for key, value in values.items():
        if isinstance(value, dict):
            found |= {f"{key}.{name}": inner for name, inner in _flat(value).items()}
        else:
            found[key] = value
    return found
