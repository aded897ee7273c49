"""Many scenes of the axisymmetric model answered together, which differ in one or two numbers.

What :mod:`validation.engine.families` asks, on
:mod:`validation.models.reluctance.family.field_tables`.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from tactgen.geometry.arrays import Floats
from tactgen.geometry.errors import InputError
from tactgen.geometry.store.store import kept, recalled
from tactgen.validation.catalogue.models import MODELS
from tactgen.validation.catalogue.quantities import QUANTITIES
from tactgen.validation.catalogue.row import AnswerReadout
from tactgen.validation.engine.costs import record, recorded
from tactgen.validation.engine.inputs import values_read
from tactgen.validation.engine.prospects import Prospect
from tactgen.validation.engine.results import Estimate, Quantity
from tactgen.validation.models.reluctance.family.field_tables import (
    PointFamily,
    Ranges,
    field_tables,
)
from tactgen.validation.models.reluctance.point import MagneticPoint
from tactgen.validation.scene.nearby import value_of, with_values
from tactgen.validation.scene.scene import Scene

#: What the points are read off, in words.
BASIS = "a table of fields on a grid that moves with them"
#: As what families are kept.
_KIND = "axisymmetric.family"
#: What makes one.
_MADE_OF = (__name__, "tactgen.fem.magnetics.axisymmetric_path")
_ROW = MODELS["axisymmetric"]
#: Most keys: places solved are five each at least.
_MOST_KEYS = 2
#: Places along a key that a table may take: up to as many points are solved themselves.
_PLACES = (33, 9)


def is_family_key(scene: Scene, key: str) -> bool:
    """Return whether a scene key may vary within a family: a number that a point reads."""
    reads = _ROW.stages["point"]
    if key == "accuracy" or not (key in reads or key.partition(".")[0] in reads):
        return False
    return isinstance(value_of(scene, key), float)


def least_members(keys: int) -> int:
    """Return the number of points up to which a walk from each to the next takes no longer."""
    return int(_PLACES[min(keys, _MOST_KEYS) - 1] ** keys)


def gives_family(quantity: str) -> bool:
    """Return whether a quantity is given for a family: a value at one current and gap."""
    return QUANTITIES[quantity].needs == ("magnetic_point",)


def reduce_family(
    scene: Scene,
    ranges: Ranges,
    quantities: Sequence[str],
    members: int,
    announce: Callable[[str], None] = lambda _: None,
) -> FieldAnswers:
    """Return what answers for about so many scenes that differ from `scene` within `ranges`.

    Raises
    ------
    InputError
        If more than two keys vary, parts do not fit somewhere in the range, no one grid
        reaches over it, or the values are not smooth enough to be interpolated.
    """
    start = time.perf_counter()
    family = point_family(scene, ranges, announce)
    return FieldAnswers(scene, family, tuple(quantities), (time.perf_counter() - start) / members)


def family_prospect(scene: Scene, ranges: Ranges, quantities: Sequence[str]) -> Prospect:
    """Return whether a family of these ranges is kept, and what one over as many keys took.

    Raises
    ------
    InputError
        If more than two keys vary.
    """
    inputs = _inputs(scene, ranges)
    found: PointFamily | None = recalled(_KIND, inputs, _MADE_OF, lambda f: f.covers(ranges))
    return Prospect(found is not None, recorded().get(_cost_name(len(ranges))))


def point_family(
    scene: Scene, ranges: Ranges, announce: Callable[[str], None] = lambda _: None
) -> PointFamily:
    """Return the points of a range, from the store if they are there; as `reduce_family`."""
    wanted = {key: (float(low), float(high)) for key, (low, high) in ranges.items()}

    def serves(found: PointFamily) -> bool:
        if found.covers(wanted):
            return True
        for key, (low, high) in found.ranges.items():
            wanted[key] = (min(low, wanted[key][0]), max(high, wanted[key][1]))
        return False

    def work() -> PointFamily:
        start = time.perf_counter()
        found = field_tables(scene, wanted, announce)
        record({_cost_name(len(wanted)): time.perf_counter() - start})
        return found

    inputs = _inputs(scene, ranges)
    return kept(_KIND, inputs, _MADE_OF, work, serves=serves, announce=announce)


def _cost_name(keys: int) -> str:
    return f"{_KIND} of {keys} keys"


def _inputs(scene: Scene, ranges: Ranges) -> tuple[object, ...]:
    """Return what a family depends on but its range."""
    if len(ranges) > _MOST_KEYS:
        raise InputError(
            f"{len(ranges)} keys vary together ({', '.join(ranges)}), and the field is tabled over "
            f"{_MOST_KEYS} at most; vary fewer"
        )
    rest = values_read(with_values(scene, dict.fromkeys(ranges, 0.0)), _ROW.stages["point"])
    return (rest, sorted(ranges))


@dataclass(frozen=True)
class FieldAnswers:
    """Quantities of scenes of one family; `seconds` is each one's share of what it cost to make."""

    scene: Scene
    family: PointFamily
    quantities: tuple[str, ...]
    seconds: float

    def answers(self, values: dict[str, Floats]) -> list[tuple[Quantity, ...]]:
        """Return the quantities of each scene that differs in `values` (n,) each."""
        family, count = self.family, next(iter(values.values())).size
        table = family.read(values)
        given = []
        for n in range(count):
            current, gap = (
                float(values[key][n]) if key in values else float(value_of(self.scene, key))
                for key in ("coil.current", "gap")
            )
            parts = {name: Estimate(float(v[n]), float(b[n])) for name, (v, b) in table.items()}
            point = MagneticPoint(
                current, gap, parts["force"], parts["flux_linkage"], parts["coenergy"],
                parts["incremental_inductance"], family.method, beyond_table=0.0,
            )  # fmt: skip
            given.append(tuple(self._quantity(name, point) for name in self.quantities))
        return given

    def _quantity(self, name: str, point: MagneticPoint) -> Quantity:
        row = QUANTITIES[name]
        assert isinstance(row.read, AnswerReadout)
        found: Any = row.read.of(point)
        return Quantity(
            name=name, model="axisymmetric", value=np.asarray(found.value), unit=row.unit,
            error=np.asarray(found.error), method=point.method,
            seconds=self.seconds,
        )  # fmt: skip
