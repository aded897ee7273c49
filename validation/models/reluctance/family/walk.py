"""Scenes of the axisymmetric model one after another, on grids and maps that they share.

What :mod:`validation.engine.walks` asks.  Each answer is that of the scene alone: its fields are
solved, only their starts, grids and the map that says where to look come from nearby.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import cached_property
from typing import Any

import numpy as np

from tactgen.fem.magnetics.axisymmetric_path import FieldWalk
from tactgen.geometry.arrays import Floats
from tactgen.geometry.store.store import is_kept
from tactgen.tmm.reluctance.coenergy_map import CoenergyMap
from tactgen.validation.catalogue.models import MODELS, stage_code
from tactgen.validation.catalogue.quantities import QUANTITIES
from tactgen.validation.catalogue.row import Need
from tactgen.validation.engine.costs import recorded
from tactgen.validation.engine.families import Box
from tactgen.validation.engine.plan import make_plan
from tactgen.validation.engine.prospects import Prospect
from tactgen.validation.engine.results import Quantity
from tactgen.validation.engine.solve import evaluate
from tactgen.validation.engine.stages import Stages
from tactgen.validation.models.reluctance.family.map_table import (
    MapTable,
    first_maps,
    kept_table,
    map_prospect,
    map_table,
    pays,
)
from tactgen.validation.models.reluctance.field import (
    MAP_RANGE,
    REFINEMENTS,
    SAMPLES,
    AxisymmetricModel,
    axisymmetric_point,
    finenesses,
    nearness,
)
from tactgen.validation.models.reluctance.point import MagneticPoint
from tactgen.validation.models.reluctance.switching import Balances, Learned
from tactgen.validation.scene.nearby import value_of
from tactgen.validation.scene.scene import Scene

_NAME = AxisymmetricModel.name


def is_walk_key(scene: Scene, key: str) -> bool:
    """Return whether a scene key may vary within a walk: a number, but for the accuracy."""
    row = MODELS[_NAME]
    if key == "accuracy" or not (row.reads(key) or row.reads(key.partition(".")[0])):
        return False
    return isinstance(value_of(scene, key), float)


def walk_shares(
    scene: Scene, ranges: Box, quantities: Sequence[str], members: int
) -> tuple[str, Prospect] | None:
    """Return what all walks of these ranges share and compute once: a map, or a table of them."""
    of_stroke = _of_stroke(quantities)
    if not of_stroke:
        return None
    users = f"for {', '.join(of_stroke)} alone"
    dimensions = _tabled(scene, ranges, quantities, members)
    if dimensions:
        shared = f"a table of co-energy maps over {', '.join(dimensions)}, {users}"
        return shared, map_prospect(scene, dimensions, ranges)
    if _dimensions(ranges):
        return None
    samples = AxisymmetricModel(scene, Stages({})).samples_inputs()
    prospect = Prospect(
        is_kept(SAMPLES, samples, stage_code()["axisymmetric.map"]),
        recorded().get("axisymmetric.map"),
    )
    return f"the samples of a co-energy map, {users}", prospect


def walk_parts(
    scene: Scene, ranges: Box, quantities: Sequence[str], members: int
) -> Sequence[Callable[[], object]]:
    """Return what of the table of maps can be computed and kept side by side."""
    dimensions = _tabled(scene, ranges, quantities, members)
    return first_maps(scene, dimensions, ranges) if dimensions else []


def prepare_walk(
    scene: Scene,
    ranges: Box,
    quantities: Sequence[str],
    members: int,
    announce: Callable[[str], None] = lambda _: None,
) -> None:
    """Compute the table of maps of these ranges, if there is to be one, and keep it.

    Raises
    ------
    InputError
        As :func:`validation.models.reluctance.family.map_table.map_table`.
    """
    dimensions = _tabled(scene, ranges, quantities, members)
    if dimensions:
        map_table(scene, dimensions, ranges, announce)


def begin_walk(scene: Scene, ranges: Box, quantities: Sequence[str], members: int) -> WalkedAnswers:
    """Return a walk over scenes that differ from one in numbers of these ranges."""
    dimensions = _tabled(scene, ranges, quantities, members)
    maps = kept_table(scene, dimensions, ranges) if dimensions else None
    return WalkedAnswers(scene, ranges, tuple(quantities), maps)


def _tabled(scene: Scene, ranges: Box, quantities: Sequence[str], members: int) -> Box:
    """Return the ranges of dimensions over which maps are tabled, if any."""
    found = _dimensions(ranges)
    if not found or not _of_stroke(quantities):
        return {}
    return found if pays(found, members) or kept_table(scene, found, ranges) else {}


def _of_stroke(quantities: Sequence[str]) -> list[str]:
    """Return the quantities that need a map."""
    return [name for name in quantities if QUANTITIES[name].needs != ("magnetic_point",)]


def _dimensions(ranges: Box) -> Box:
    """Return the ranges of keys of which each value has samples of its own."""
    return {key: ends for key, ends in _of_field(ranges).items() if key not in MAP_RANGE}


def _of_field(ranges: Box) -> Box:
    """Return the ranges of keys that the field depends on."""
    reads = MODELS[_NAME].stages["point"]
    return {k: e for k, e in ranges.items() if k in reads or k.partition(".")[0] in reads}


class WalkedAnswers:
    """What solves the scenes of a walk."""

    def __init__(
        self, scene: Scene, ranges: Box, quantities: tuple[str, ...], maps: MapTable | None
    ) -> None:
        self._home, self._quantities, self.maps = scene.device, quantities, maps
        self._ranges = _dimensions(ranges)
        self._walk = FieldWalk(finenesses(REFINEMENTS, scene.accuracy), scene.accuracy)
        self.learned: Learned = {}

    def solved(self, scene: Scene) -> tuple[tuple[Quantity, ...], tuple[str, ...]]:
        """Return a scene's quantities, and what must be told of them.

        Raises
        ------
        InputError
            If the model cannot take the scene.
        SolverError
            If a field does not converge.
        """
        plan = make_plan(scene, (_NAME,), self._quantities)
        model = _WalkedModel(scene, Stages(plan.keys, keeps=False), self)
        found = tuple(evaluate(name, model) for name in self._quantities)
        return found, model.warnings(self._quantities)

    def at(self, scene: Scene, current: float, gap: float) -> MagneticPoint:
        """Return the values of a scene at a current (A) and gap (m)."""
        place = np.concatenate([self._place(scene), nearness(self._home, current, gap)])
        return axisymmetric_point(self._walk.at(scene.device, current, gap, place))

    def _place(self, scene: Scene) -> Floats:
        return np.array(
            [
                (2.0 * value_of(scene, key) - low - high) / (high - low)
                for key, (low, high) in self._ranges.items()
            ]
        )


class _WalkedModel(AxisymmetricModel):
    """The model of one scene of a walk."""

    def __init__(self, scene: Scene, stages: Stages, walk: WalkedAnswers) -> None:
        super().__init__(scene, stages)
        self._walk = walk

    def at(self, current: float, gap: float) -> MagneticPoint:
        return self._walk.at(self.scene, current, gap)

    def answer(self, need: Need) -> Any:
        """As of any scene, but that only the currents that are asked for are solved for."""
        return self._balances if need == "magnetic_map" else super().answer(need)

    @cached_property
    def _balances(self) -> Balances:
        return Balances(self.scene.device, self.map(), self.at, self._walk.learned)

    def _map(self) -> CoenergyMap:
        maps = self._walk.maps
        if maps is None:
            return super()._map()
        values = {key: float(value_of(self.scene, key)) for key in maps.ranges}
        return maps.at(values, self._described())
