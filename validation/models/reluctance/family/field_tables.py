"""The axisymmetric field over one or two numbers of a scene: tables on grids that move with them.

The field is solved at few places of the range, on one grid that moves with the dimensions, each
from those before; all others are read off the polynomial through these.  Where an edge of a part
passes another's, the lines would change their order: there one table ends and the next begins.
The bar is that of the points solved, and of the interpolation what half as many places miss.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from itertools import combinations, pairwise

import numpy as np

from tactgen.geometry.arrays import Floats
from tactgen.geometry.errors import InputError
from tactgen.geometry.reluctance.section_grid import OUTER_RADIUS, actuator_regions, graded_grid
from tactgen.geometry.store.values import storable
from tactgen.validation.models.reluctance.family.nested_grid import Table, nested_table
from tactgen.validation.models.reluctance.field import REFINEMENTS
from tactgen.validation.models.reluctance.warnings import WORTH_A_WORD
from tactgen.validation.scene.nearby import with_values
from tactgen.validation.scene.scene import Scene

#: Names of what a point says.
_NAMES = ("force", "flux_linkage", "coenergy", "incremental_inductance")
#: Interpolation's error in units of the bar from which on it does not count, and above which
#: it counts for too much.
_GOOD, _BAD = 0.2, 1.0
#: Places of one table, and tables of one range, that are too many.
_MOST_PLACES, _MOST_TABLES = 150, 8
#: Edges (m) this close are level.
_LEVEL = 1e-9

Ranges = Mapping[str, tuple[float, float]]


@storable
@dataclass(frozen=True)
class FieldTable:
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

    def places(self, values: Mapping[str, Floats]) -> Floats:
        """Return where values (n,) by key lie in the table, (n, k)."""
        columns = [
            (2.0 * values[key] - low - high) / (high - low)
            for key, (low, high) in self.ranges.items()
        ]
        return np.clip(np.stack(columns, axis=1), -1.0, 1.0)


@storable
@dataclass(frozen=True)
class PointFamily:
    """What the field says over a range: one table, or of one key several, side by side."""

    tables: tuple[FieldTable, ...]

    @property
    def ranges(self) -> dict[str, tuple[float, float]]:
        """Lowest and highest value of each scene key that varies (SI)."""
        first, last = self.tables[0].ranges, self.tables[-1].ranges
        return {key: (first[key][0], last[key][1]) for key in first}

    @property
    def method(self) -> str:
        """How the error bars come about, for the reader."""
        places = sum(next(iter(t.table.values.values())).size for t in self.tables)
        return (
            "change from the lower polynomial order, for the force no less than the difference of "
            f"its two routes, and truncation of the air, at {places} places of the range on grids "
            "that move with it; with what half as many places miss in between"
        )

    def covers(self, ranges: Ranges) -> bool:
        """Return whether all of a range lies within the family's."""
        own = self.ranges
        return all(
            own[key][0] <= low and high <= own[key][1] for key, (low, high) in ranges.items()
        )

    def read(self, values: Mapping[str, Floats]) -> Mapping[str, tuple[Floats, Floats]]:
        """Return by name what the field says at values (n,) by key, with bars, (n,) each."""
        key = next(iter(self.ranges))
        inner = np.array([table.ranges[key][1] for table in self.tables[:-1]])
        which = np.searchsorted(inner, values[key])
        found = {name: (np.empty(which.size), np.empty(which.size)) for name in _NAMES}
        for number in np.unique(which):
            own = which == number
            table = self.tables[number]
            places = table.places({key: at[own] for key, at in values.items()})
            for name, (value, bar) in found.items():
                value[own] = table.table.value(name, places)
                bar[own] = table.table.bar(name, places)
        return found


def field_tables(
    scene: Scene,
    ranges: dict[str, tuple[float, float]],
    announce: Callable[[str], None] = lambda _: None,
) -> PointFamily:
    """Solve over a range, on the coarsest grid that keeps to the scene's accuracy everywhere.

    Raises
    ------
    InputError
        If parts do not fit somewhere in the range, no few grids reach over it, or the values
        are not smooth enough to be interpolated.
    """
    first = next(n for n, (bar, _) in enumerate(REFINEMENTS) if scene.accuracy >= bar)
    for _, refinement in REFINEMENTS[first:]:
        last = refinement == REFINEMENTS[-1][1]
        accuracy = np.inf if last else scene.accuracy
        tables = []
        try:
            for solver in _solvers(scene, ranges, refinement, accuracy):
                solver.announce = announce
                table = nested_table(solver.at, len(ranges), wanted=_GOOD, most=_MOST_PLACES)
                tables.append(FieldTable(solver.ranges, table))
        except _TooCoarse:
            continue
        if max(max(each.table.missed.values()) for each in tables) > _BAD:
            raise InputError(
                f"the field over {', '.join(ranges)} is not smooth enough for a table; the "
                "range is too wide"
            )
        return PointFamily(tuple(tables))
    raise AssertionError("the finest grid is always taken")


class _TooCoarse(Exception):
    """A point's bar is wider than asked for, and there is a finer grid."""


def _solvers(
    scene: Scene, ranges: dict[str, tuple[float, float]], refinement: float, accuracy: float
) -> list[_Solver]:
    """Return what solves over parts of a range, side by side, each on a grid that reaches it."""
    waiting = _parts(scene, ranges)
    found: list[_Solver] = []
    while waiting:
        part = waiting.pop(0)
        solver = _Solver(scene, part, accuracy)
        if solver.takes_grid(refinement):
            found.append(solver)
        elif len(ranges) == 1 and len(found) + len(waiting) + 2 <= _MOST_TABLES:
            ((key, (low, high)),) = part.items()
            middle = 0.5 * (low + high)
            waiting[:0] = [{key: (low, middle)}, {key: (middle, high)}]
        else:
            raise InputError(f"no one grid reaches over the range of {', '.join(ranges)}")
    return found


def _parts(
    scene: Scene, ranges: dict[str, tuple[float, float]]
) -> list[dict[str, tuple[float, float]]]:
    """Return a range in parts within which no edge passes another; of two keys the whole."""
    if len(ranges) > 1:
        return [ranges]
    ((key, (low, high)),) = ranges.items()
    ends = []
    for value in (low, high):
        there = with_values(scene, {key: value})
        ends.append(actuator_regions(there.device, there.gap))
    if len(ends[0]) != len(ends[1]):
        raise InputError(f"a part comes or goes over the range of {key}")
    passed = {0.0, 1.0}
    for along in ("radii", "heights"):
        before, after = (np.ravel([getattr(part, along) for part in end]) for end in ends)
        for n, m in combinations(range(before.size), 2):
            apart, then = before[n] - before[m], after[n] - after[m]
            # all of them go evenly with the key
            if apart * then < 0.0 and min(abs(apart), abs(then)) > _LEVEL:
                passed.add(float(apart / (apart - then)))
    return [
        {key: (low + a * (high - low), low + b * (high - low))} for a, b in pairwise(sorted(passed))
    ]


class _Solver:
    """The field at places of a range, on one grid."""

    announce: Callable[[str], None]

    def __init__(
        self, scene: Scene, ranges: dict[str, tuple[float, float]], accuracy: float
    ) -> None:
        self.ranges = ranges
        self._scene, self._accuracy = scene, accuracy
        self._done = 0

    def takes_grid(self, refinement: float) -> bool:
        """Take the grid of the middle or of an end of the range, if one reaches all three."""
        from tactgen.fem.magnetics.axisymmetric_path import FieldPath

        ends = [self._changed(np.full(len(self.ranges), x)) for x in (0.0, 1.0, -1.0)]
        regions = [actuator_regions(each.device, each.gap) for each in ends]
        for home, own in zip(ends, regions, strict=True):
            grid = graded_grid(own, OUTER_RADIUS, refinement=refinement)
            if all(grid.fitted(each) is not None for each in regions):
                self._path = FieldPath(home.device, home.gap, refinement=refinement)
                return True
        return False

    def at(self, place: Floats) -> dict[str, tuple[float, float]]:
        """Return the values with their bars at a place (k,)."""
        self._done += 1
        low, high = next(iter(self.ranges.values()))
        self.announce(
            f"axisymmetric: field {self._done} over {next(iter(self.ranges))} = {low:g} to {high:g}"
        )
        scene = self._changed(place)
        found = self._path.at(scene.device, scene.coil.current, scene.gap, place)
        if found.beyond_table > WORTH_A_WORD:
            raise InputError("steel.curve ends too early for some of them")
        if found.errors.force > self._accuracy * abs(found.force):
            raise _TooCoarse
        return {name: (getattr(found, name), getattr(found.errors, name)) for name in _NAMES}

    def _changed(self, place: Floats) -> Scene:
        values = {
            key: 0.5 * ((1.0 - x) * low + (1.0 + x) * high)
            for x, (key, (low, high)) in zip(place.tolist(), self.ranges.items(), strict=True)
        }
        return with_values(self._scene, values)
