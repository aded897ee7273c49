"""Co-energy maps of the axisymmetric field over dimensions: a few are solved, others lie between.

Samples at the same currents and gaps are smooth functions of a dimension.  What half as many
places miss is judged by what a map leaves open anyway, and added to its interpolation error.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from itertools import product

import numpy as np

from tactgen.geometry.arrays import Floats
from tactgen.geometry.errors import InputError
from tactgen.geometry.store.store import kept, recalled
from tactgen.geometry.store.values import storable
from tactgen.tmm.reluctance.coenergy_fit import fit, largest_share
from tactgen.tmm.reluctance.coenergy_map import CoenergyMap, MapError, Samples
from tactgen.validation.catalogue.models import MODELS
from tactgen.validation.engine.costs import record, recorded
from tactgen.validation.engine.inputs import values_read
from tactgen.validation.engine.prospects import Prospect
from tactgen.validation.models.reluctance.family.nested_grid import (
    Table,
    Value,
    first_points,
    nested_table,
)
from tactgen.validation.models.reluctance.field import MAP_ORDER, MAP_RANGE
from tactgen.validation.scene.nearby import with_values
from tactgen.validation.scene.scene import Scene

_KIND = "axisymmetric.maps"
_MADE_OF = (__name__, "tactgen.fem.magnetics.axisymmetric")
#: What a sample is: by name, and what of it counts as error as a map's fit counts it.
_SAMPLES = {"flux_linkage": 1.0, "force": 1.0, "coenergy": 1.0, "incremental_inductance": 0.1}
#: Share of a sample that is left open between the samples of one map, at least.
_LEFT_OPEN = 0.02
#: What half as many places miss, in units of the bars, at which a table is good.
_GOOD = 1.0
#: Most places, and the places of the smallest table over so many keys.
_MOST_PLACES, _FEWEST = 25, 5

#: Tables over the same dimensions that are held; and a share of a range that is rounding.
_MOST_TABLES, _ROUNDING = 16, 1e-9

Ranges = Mapping[str, tuple[float, float]]
#: By name the values at currents and gaps (c, m), and what they are judged by.
_SampleValues = dict[str, tuple[Value, Value]]


@storable
@dataclass(frozen=True)
class MapTable:
    """Samples of co-energy maps over a range.

    Attributes
    ----------
    ranges : dict of str to (float, float)
        Lowest and highest value of each dimension (SI).
    current, gap : (c,), (m,) float
        Of the samples (A, m).
    table : Table
        Over the range, each axis from −1 to 1.
    """

    ranges: dict[str, tuple[float, float]]
    current: Floats
    gap: Floats
    table: Table

    def covers(self, ranges: Ranges, currents: Floats, gaps: Floats) -> bool:
        """Return whether a range, with currents (A) and gaps (m), lies within the table's."""
        own = {
            **self.ranges,
            "current": (0.0, self.current[-1]),
            "gap": (self.gap[0], self.gap[-1]),
        }
        wanted = {**ranges, "current": (0.0, currents[-1]), "gap": (gaps[0], gaps[-1])}
        slack = {key: _ROUNDING * (high - low) for key, (low, high) in own.items()}
        return all(
            own[key][0] - slack[key] <= low and high <= own[key][1] + slack[key]
            for key, (low, high) in wanted.items()
        )

    def at(self, values: Mapping[str, float], described: str) -> CoenergyMap:
        """Return the map at values by key within the range."""
        columns = [
            (2.0 * values[key] - low - high) / (high - low)
            for key, (low, high) in self.ranges.items()
        ]
        place = np.clip([columns], -1.0, 1.0)
        found = {name: self.table.value(name, place)[0] for name in _SAMPLES}
        missed = {name: self.table.bar(name, place)[0] for name in ("force", "flux_linkage")}
        missed = {
            name: bar * self.table.missed[name] / (1.0 + self.table.missed[name])
            for name, bar in missed.items()
        }
        map_ = fit(
            Samples(
                self.current, self.gap, **found, model="axisymmetric", device=described,
                force_error=self.table.bar("force", place)[0],
            )
        )  # fmt: skip
        between = map_.interpolation_error
        return replace(
            map_,
            interpolation_error=MapError(
                between.flux_linkage + largest_share(missed["flux_linkage"], found["flux_linkage"]),
                between.force + largest_share(missed["force"], found["force"]),
            ),
        )


@storable
@dataclass(frozen=True)
class MapTables:
    """All tables that were made over some dimensions of a scene, the latest last."""

    tables: tuple[MapTable, ...]

    def covering(self, ranges: Ranges, currents: Floats, gaps: Floats) -> MapTable | None:
        """Return the table of the least width that holds a range, currents (A) and gaps (m)."""
        able = [table for table in self.tables if table.covers(ranges, currents, gaps)]
        return min(able, key=lambda t: float(np.prod([b - a for a, b in t.ranges.values()])),
                   default=None)  # fmt: skip


def pays(ranges: Ranges, members: int) -> bool:
    """Return whether a table over the dimensions takes fewer maps than so many scenes do."""
    return bool(ranges) and len(ranges) <= 2 and members > _FEWEST ** len(ranges)


def map_table(
    scene: Scene, ranges: Ranges, all_ranges: Ranges, announce: Callable[[str], None]
) -> MapTable:
    """Return a table over dimensions, from the store if one there holds their range.

    Parameters
    ----------
    ranges, all_ranges : mapping
        Lowest and highest value of the dimensions, and of all that varies.

    Raises
    ------
    InputError
        If parts do not fit somewhere in the range, or the samples are not smooth enough.
    """
    currents, gaps = _grid(scene, all_ranges)
    inputs = _inputs(scene, ranges)

    def work() -> MapTables:
        start = time.perf_counter()
        found = _tabled(scene, dict(ranges), currents, gaps, announce)
        record({_cost_name(ranges): time.perf_counter() - start})
        earlier: MapTables | None = recalled(_KIND, inputs, _MADE_OF)
        return MapTables((*(earlier.tables if earlier else ()), found)[-_MOST_TABLES:])

    def serves(found: MapTables) -> bool:
        return found.covering(ranges, currents, gaps) is not None

    tables = kept(_KIND, inputs, _MADE_OF, work, serves=serves, announce=announce)
    found = tables.covering(ranges, currents, gaps)
    assert found is not None
    return found


def map_prospect(scene: Scene, ranges: Ranges, all_ranges: Ranges) -> Prospect:
    """Return whether the table is kept, and what one over as many keys took here."""
    held = kept_table(scene, ranges, all_ranges) is not None
    return Prospect(held, recorded().get(_cost_name(ranges)))


def first_maps(
    scene: Scene, ranges: Ranges, all_ranges: Ranges
) -> list[Callable[[], _SampleValues]]:
    """Return what computes and keeps the samples of each of the smallest table's maps.

    None where the table is there.
    """
    if kept_table(scene, ranges, all_ranges):
        return []
    currents, gaps = _grid(scene, all_ranges)
    places = product(first_points().tolist(), repeat=len(ranges))
    return [partial(_samples, _scene_at(scene, ranges, each), currents, gaps) for each in places]


def kept_table(scene: Scene, ranges: Ranges, all_ranges: Ranges) -> MapTable | None:
    """Return a table that holds the range, if there is one in the store."""
    tables: MapTables | None = recalled(_KIND, _inputs(scene, ranges), _MADE_OF)
    return tables.covering(ranges, *_grid(scene, all_ranges)) if tables else None


def _cost_name(ranges: Ranges) -> str:
    return f"{_KIND} of {len(ranges)} keys"


def _inputs(scene: Scene, ranges: Ranges) -> tuple[object, ...]:
    """Return what a table over some dimensions depends on but for their range."""
    own = (key for key in MODELS["axisymmetric"].stages["map"] if key not in MAP_RANGE)
    rest = values_read(with_values(scene, dict.fromkeys(ranges, 0.0)), own)
    return rest, sorted(ranges)


def _grid(scene: Scene, ranges: Ranges) -> tuple[Floats, Floats]:
    """Return currents (A) and gaps (m) that the maps of all scenes of a range must cover."""
    from tactgen.tmm.reluctance.map_range import map_grid

    corners = [dict(zip(ranges, ends, strict=True)) for ends in product(*ranges.values())]
    grids = [map_grid(with_values(scene, corner).device, shared=True) for corner in corners]
    currents = max((grid[0] for grid in grids), key=lambda each: float(each[-1]))
    gaps = [grid[1] for grid in grids]
    least, largest = min(g[0] for g in gaps), max(g[-1] for g in gaps)
    return currents, np.geomspace(least, largest, gaps[0].size)


def _tabled(
    scene: Scene,
    ranges: dict[str, tuple[float, float]],
    currents: Floats,
    gaps: Floats,
    announce: Callable[[str], None],
) -> MapTable:
    done = 0

    def solve(place: Floats) -> _SampleValues:
        nonlocal done
        done += 1
        announce(f"axisymmetric: map {done} over {', '.join(ranges)}")
        return _samples(_scene_at(scene, ranges, place.tolist()), currents, gaps)

    table = nested_table(solve, len(ranges), wanted=_GOOD, most=_MOST_PLACES)
    if max(table.missed.values()) > len(ranges) * _GOOD:
        raise InputError(
            f"maps over {', '.join(ranges)} are not smooth enough for a table; the range is too "
            "wide"
        )
    return MapTable(ranges, currents, gaps, table)


def _scene_at(scene: Scene, ranges: Ranges, place: Sequence[float]) -> Scene:
    """Return the scene at a place of a table, each axis from −1 to 1."""
    values = {
        key: 0.5 * ((1.0 - x) * low + (1.0 + x) * high)
        for x, (key, (low, high)) in zip(place, ranges.items(), strict=True)
    }
    return with_values(scene, values)


def _samples(scene: Scene, currents: Floats, gaps: Floats) -> _SampleValues:
    """Return the samples of a scene's map with what they are judged by, kept."""
    inputs = *_inputs(scene, {}), currents.tolist(), gaps.tolist()
    return kept(f"{_KIND}.samples", inputs, _MADE_OF, partial(_solved, scene, currents, gaps))


def _solved(scene: Scene, currents: Floats, gaps: Floats) -> _SampleValues:
    from tactgen.fem.magnetics.axisymmetric import solve_map

    rows = solve_map(scene.device, gaps.tolist(), currents.tolist(), order=MAP_ORDER)
    found: _SampleValues = {}
    for name, counts in _SAMPLES.items():
        value = np.array([[getattr(point, name) for point in row] for row in rows]).T
        bar = np.array([[getattr(point.errors, name) for point in row] for row in rows]).T
        found[name] = (value, np.maximum(bar, _LEFT_OPEN * np.abs(value)) / counts)
    return found
