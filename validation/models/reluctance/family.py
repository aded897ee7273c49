"""Many scenes of the axisymmetric model answered together, which differ in one or two numbers.

What :mod:`validation.engine.families` asks.  The field is solved at few places of the range, on
one grid that moves with the dimensions, each from those before; all others are read off the
polynomial through these.  The bar is that of the points solved, and of the interpolation what
half as many places miss.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from tactgen.geometry.arrays import Floats
from tactgen.geometry.errors import InputError
from tactgen.geometry.store.store import kept, recalled
from tactgen.geometry.store.values import storable
from tactgen.validation.catalogue.models import MODELS
from tactgen.validation.catalogue.quantities import QUANTITIES
from tactgen.validation.catalogue.row import AnswerReadout
from tactgen.validation.engine.costs import record, recorded
from tactgen.validation.engine.outlook import Prospect
from tactgen.validation.engine.results import Measured, Quantity
from tactgen.validation.engine.stages import values_read
from tactgen.validation.models.reluctance.field import REFINEMENTS
from tactgen.validation.models.reluctance.nested_grid import Table, nested_table
from tactgen.validation.models.reluctance.point import MagneticPoint
from tactgen.validation.models.reluctance.warnings import WORTH_A_WORD
from tactgen.validation.scene.keys import value_of, with_values
from tactgen.validation.scene.scene import Scene

#: What the points are read off, in words.
BASIS = "one table of fields on a grid that moves with them"
#: As what families are kept.
_KIND = "axisymmetric.family"
#: What makes one.
_MADE_OF = (__name__, "tactgen.fem.reluctance.axisymmetric.path")
_ROW = MODELS["axisymmetric"]
#: Names of what a point says.
_NAMES = ("force", "flux_linkage", "coenergy", "incremental_inductance")
#: Most keys: places solved are five each at least.
_MOST_KEYS = 2
#: Interpolation's error in units of the bar from which on it does not count, and above which
#: it counts for too much.
_GOOD, _BAD = 0.2, 1.0
#: Places that are too many.
_MOST_PLACES = 150

Ranges = Mapping[str, tuple[float, float]]


@storable
@dataclass(frozen=True, eq=False)
class PointFamily:
    """What the field says over a range.

    Attributes
    ----------
    ranges : dict of str to (float, float)
        Lowest and highest value of each scene key that varies (SI).
    table : Table
        Over the range, each axis from −1 to 1.
    """

    ranges: dict[str, tuple[float, float]]
    table: Table

    @property
    def method(self) -> str:
        """How the error bars come about, for the reader."""
        places = next(iter(self.table.values.values())).size
        return (
            f"change from the lower polynomial order, truncation of the air, and for the force "
            f"the difference of its two routes, at {places} places of the range on one moved "
            "grid; with what half as many places miss in between"
        )

    def covers(self, ranges: Ranges) -> bool:
        """Return whether all of a range lies within the family's."""
        return all(
            self.ranges[key][0] <= low and high <= self.ranges[key][1]
            for key, (low, high) in ranges.items()
        )

    def places(self, values: Mapping[str, Floats]) -> Floats:
        """Return where values (n,) by key lie in the table, (n, k)."""
        columns = []
        for key, (low, high) in self.ranges.items():
            columns.append((2.0 * values[key] - low - high) / (high - low))
        return np.clip(np.stack(columns, axis=1), -1.0, 1.0)


def is_family_key(scene: Scene, key: str) -> bool:
    """Return whether a scene key may vary within a family: a number that a point reads."""
    reads = _ROW.stages["point"]
    if key == "accuracy" or not (key in reads or key.partition(".")[0] in reads):
        return False
    return isinstance(value_of(scene, key), float)


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
        found = _built(scene, wanted, announce)
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


def _built(
    scene: Scene, ranges: dict[str, tuple[float, float]], announce: Callable[[str], None]
) -> PointFamily:
    """Solve on the coarsest grid that keeps to the accuracy wherever it is asked."""
    first = next(n for n, (bar, _) in enumerate(REFINEMENTS) if scene.accuracy >= bar)
    for _, refinement in REFINEMENTS[first:]:
        solver = _Solver(scene, ranges, refinement, announce)
        last = refinement == REFINEMENTS[-1][1]
        solver.accuracy = np.inf if last else scene.accuracy
        try:
            table = nested_table(solver.at, len(ranges), wanted=_GOOD, most=_MOST_PLACES)
        except _TooCoarse:
            continue
        if max(table.missed.values()) > _BAD:
            raise InputError(
                f"the field over {', '.join(ranges)} is not smooth enough for one table; the "
                "range is too wide"
            )
        return PointFamily(ranges, table)
    raise AssertionError("the finest grid is always taken")


class _TooCoarse(Exception):
    """A point's bar is wider than asked for, and there is a finer grid."""


class _Solver:
    """The field at places of a range, on one grid."""

    accuracy = np.inf

    def __init__(
        self,
        scene: Scene,
        ranges: dict[str, tuple[float, float]],
        refinement: float,
        announce: Callable[[str], None],
    ) -> None:
        from tactgen.fem.reluctance.axisymmetric.path import FieldPath

        self._scene, self._ranges, self._announce = scene, ranges, announce
        self._done = 0
        ends = [self._changed(np.full(len(ranges), x)) for x in (-1.0, 0.0, 1.0)]
        for home in (ends[1], ends[2], ends[0]):
            path = FieldPath(home.device, home.gap, refinement=refinement)
            if all(path.reaches(each.device, each.gap) for each in ends):
                self._path = path
                return
        raise InputError(f"no one grid reaches over the range of {', '.join(ranges)}")

    def at(self, place: Floats) -> dict[str, tuple[float, float]]:
        """Return the values with their bars at a place (k,)."""
        self._done += 1
        self._announce(f"axisymmetric: field {self._done} of one range")
        scene = self._changed(place)
        found = self._path.at(scene.device, scene.coil.current, scene.gap, place)
        if found.beyond_table > WORTH_A_WORD:
            raise InputError("steel.curve ends too early for some of them")
        if found.errors.force > self.accuracy * abs(found.force):
            raise _TooCoarse
        return {name: (getattr(found, name), getattr(found.errors, name)) for name in _NAMES}

    def _changed(self, place: Floats) -> Scene:
        values = {
            key: 0.5 * ((1.0 - x) * low + (1.0 + x) * high)
            for x, (key, (low, high)) in zip(place.tolist(), self._ranges.items(), strict=True)
        }
        return with_values(self._scene, values)


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
        places = family.places(values)
        table = {
            name: (family.table.value(name, places), family.table.bar(name, places))
            for name in _NAMES
        }
        given = []
        for n in range(count):
            current, gap = (
                float(values[key][n]) if key in values else float(value_of(self.scene, key))
                for key in ("coil.current", "gap")
            )
            parts = {name: Measured(float(v[n]), float(b[n])) for name, (v, b) in table.items()}
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
            uncertainty=np.asarray(found.bar), uncertainty_method=point.method,
            seconds=self.seconds,
        )  # fmt: skip
