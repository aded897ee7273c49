"""Many scenes of one family answered together, where a model has a faster way to them.

A family differs in a few numbers only.  A model whose row names a module for it reduces the
family once and then answers a scene in milliseconds; that pays beyond a few scenes.
"""

from __future__ import annotations

import importlib
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Protocol, cast

import numpy as np

from tactgen.geometry.arrays import Floats
from tactgen.validation.catalogue.models import MODELS, reading_reads
from tactgen.validation.engine.results import Quantity
from tactgen.validation.engine.stages import values_read
from tactgen.validation.scene.scene import Scene

#: Most numbers that vary in a family: its range has 2^n corners.
_MOST_KEYS = 4

#: Lowest and highest value (SI) of keys, of which many points will be asked.
Box = Mapping[str, tuple[float, float]]


class FamilyModule(Protocol):
    """What a module for families of a model has."""

    def is_family_key(self, scene: Scene, key: str) -> bool:
        """Return whether a scene key may vary within a family."""

    def gives_family(self, quantity: str) -> bool:
        """Return whether a quantity is given for a family."""

    def answer_family(
        self,
        scene: Scene,
        values: dict[str, Floats],
        quantities: Sequence[str],
        ranges: Box,
        announce: Callable[[str], None],
    ) -> list[tuple[Quantity, ...]]:
        """Return the quantities of scenes that differ from `scene` in `values` (n,) each.

        The values lie in `ranges`, as will those that are asked next.
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
            return f"{self.model}: the range of {', '.join(self.keys)} by one reduced basis"
        return (
            f"{self.model}: {len(self.numbers)} points differ in {', '.join(self.keys)} only, and "
            f"more than {_least(len(self.keys))} are answered faster by one reduced basis"
        )


def find_families(
    model: str, scenes: Sequence[Scene], quantities: Sequence[str], box: Box | None = None
) -> list[Family]:
    """Return the families among scenes for which a reduced basis pays.

    With a `box`, a range of keys of which many more points will be asked, it pays for few.
    """
    row = MODELS[model]
    if not row.families or not scenes or (box is None and len(scenes) <= _least(1)):
        return []
    module = _module(model)
    if not all(module.gives_family(name) for name in quantities):
        return []
    boxed = tuple(key for key in box or () if module.is_family_key(scenes[0], key))
    if box is not None and not 0 < len(boxed) <= _MOST_KEYS:
        return []
    reads = {key for stage in row.stages.values() for key in stage} | set(reading_reads(model))
    flat = [_flat(values_read(scene, sorted(reads))) for scene in scenes]
    varied = [key for key in flat[0] if any(one.get(key) != flat[0][key] for one in flat)]
    own = [key for key in varied if module.is_family_key(scenes[0], key)]
    if box is not None:
        own = list(boxed)
    groups: dict[str, list[int]] = {}
    for number, values in enumerate(flat):
        rest = {key: value for key, value in values.items() if key not in own}
        groups.setdefault(repr(rest), []).append(number)
    found = []
    for numbers in groups.values():
        if box is not None:
            found.append(Family(model, tuple(numbers), boxed, {key: box[key] for key in boxed}))
            continue
        first = flat[numbers[0]]
        keys = tuple(k for k in own if any(flat[n][k] != first[k] for n in numbers))
        if keys and len(keys) <= _MOST_KEYS and len(numbers) > _least(len(keys)):
            found.append(Family(model, tuple(numbers), keys))
    return found


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
        key: np.array([_value(scene, key) for scene in chosen], dtype=float) for key in family.keys
    }
    ranges = family.box or {key: (float(v.min()), float(v.max())) for key, v in values.items()}
    return _module(family.model).answer_family(chosen[0], values, quantities, ranges, announce)


def _least(keys: int) -> int:
    """Return the number of points up to which single answers take no longer.

    A basis takes what its middle, its corners and some members between them have to say, each
    in more classes of motion than a single answer needs.
    """
    return int(2 * (1 + 2**keys + keys))


def _module(model: str) -> FamilyModule:
    return cast(FamilyModule, importlib.import_module(MODELS[model].families))


def _value(scene: Scene, key: str) -> float:
    found: Any = scene
    for part in key.split("."):
        found = getattr(found, part)
    return float(found)


def _flat(values: dict[str, Any]) -> dict[str, Any]:
    """Return values by full key."""
    found: dict[str, Any] = {}
    for key, value in values.items():
        if isinstance(value, dict):
            found |= {f"{key}.{name}": inner for name, inner in _flat(value).items()}
        else:
            found[key] = value
    return found
