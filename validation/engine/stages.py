"""Stages of a study: run once, timed, keyed by exactly the inputs they read.

A stage that the plan does not contain is refused, so the plan shown to the user is the
plan that runs.  Results of expensive stages are kept in the store, for the next run.
"""

from __future__ import annotations

import hashlib
import json
import time
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from typing import Any, TypeVar

from tactgen.geometry.device.load_table import load_table
from tactgen.geometry.device.steel_table import magnetisation_curve
from tactgen.geometry.store.store import kept
from tactgen.validation.catalogue.detection import threshold_of
from tactgen.validation.catalogue.models import MODELS, stage_code, stage_reads
from tactgen.validation.scene.scene import Scene

T = TypeVar("T")


@dataclass
class Stages:
    """Runs stages lazily and remembers their results and costs.

    Attributes
    ----------
    keys : dict of str to str
        Stages of the plan with the key of each.
    seconds : dict of str to float
        Wall-clock cost of each stage that ran.
    announce : callable
        Told the name of each stage as it is computed.
    computed : set of str
        Stages that were computed, not recalled or taken over.
    keeps : bool
        Whether results are looked for in the store, and kept there.
    """

    keys: dict[str, str]
    announce: Callable[[str], None] = lambda _: None
    seconds: dict[str, float] = field(default_factory=dict)
    computed: set[str] = field(default_factory=set)
    keeps: bool = True
    _results: dict[str, Any] = field(default_factory=dict)

    def run(self, name: str, work: Callable[[], T]) -> T:
        """Return the stage's result: of this run, from the store, or computed now.

        Raises
        ------
        RuntimeError
            If the stage is not part of the plan: a defect of the plan, not of the input.
        """
        if name not in self._results:
            if name not in self.keys:
                raise RuntimeError(f"stage {name} ran although the plan skips it")
            start, inner = time.perf_counter(), sum(self.seconds.values())

            def announced() -> T:
                self.announce(name)
                self.computed.add(name)
                return work()

            code = stage_code().get(name)
            if self.keeps and code is not None:
                self._results[name] = kept(
                    name, (self.keys[name],), code, announced, announce=self.announce
                )
            else:
                self._results[name] = announced()
            spent_inside = sum(self.seconds.values()) - inner
            self.seconds[name] = time.perf_counter() - start - spent_inside
        result: T = self._results[name]
        return result

    def adopt(self, other: Stages) -> None:
        """Take over the results of another study whose inputs, by key, were the same."""
        for name, key in self.keys.items():
            if other.keys.get(name) == key and name in other.seconds:
                self.seconds[name] = other.seconds[name]
                if name in other._results:
                    self._results[name] = other._results[name]

    def to_travel(self) -> Stages:
        """Return what another process can adopt: all costs, and the results that can be stored."""
        stored = stage_code()
        results = {name: result for name, result in self._results.items() if name in stored}
        return Stages(self.keys, _unheard, self.seconds, self.computed, self.keeps, results)


def _unheard(_: str) -> None:
    """Take an announcement, as a process does that nobody listens to."""


def stage_key(name: str, scene: Scene) -> str:
    """Return the stage's key: a hash of the scene values it reads."""
    return stage_keys((name,), scene)[name]


def stage_keys(names: Iterable[str], scene: Scene) -> dict[str, str]:
    """Return the keys of stages by name."""
    reads, values = stage_reads(), scene.model_dump(mode="json")
    texts = {
        name: json.dumps([name, _read(scene, values, reads[name])], sort_keys=True)
        for name in names
    }
    return {name: hashlib.sha256(t.encode()).hexdigest()[:16] for name, t in texts.items()}


def values_read(scene: Scene, keys: Iterable[str]) -> dict[str, Any]:
    """Return a scene's values by key or group, as plain values that a hash can be made of."""
    return _read(scene, scene.model_dump(mode="json"), keys)


def _read(scene: Scene, values: dict[str, Any], keys: Iterable[str]) -> dict[str, Any]:
    read: dict[str, Any] = {}
    for path in keys:
        value: Any = values
        for part in path.split("."):
            value = value[part]
        if path == "steel.curve":  # a name, or a file: what counts is what is in it
            curve = magnetisation_curve(scene.steel)
            value = [curve.flux_density.tolist(), curve.field.tolist(), curve.slope_beyond]
        if path == "load" and scene.load.kind == "table":
            table = load_table(scene.load)
            content = [table.frequencies.tolist(), table.impedance.real.tolist()]
            value = {**value, "file": [*content, table.impedance.imag.tolist()]}
        if path == "threshold" and scene.threshold.kind == "table":
            points = threshold_of(scene.threshold).points
            value = [[point.frequency, point.amplitude] for point in points]
        if path == "support":
            value = _support(scene, values)
        if path == "models":  # what counts is whose map pulls at the rod, and that map's inputs
            stage = f"{scene.map_model}.map"
            value = [stage, _read(scene, values, stage_reads()[stage])]
        read[path] = value
    return read


#: What the springs of a contact follow from, where a field says how hard it is pressed.
_HELD_BY = (
    "support.kind", "contact", "guide", "rod", "coil", "spring", "gap", "load.normal_force",
    "models",
)  # fmt: skip


def _support(scene: Scene, values: dict[str, Any]) -> dict[str, Any]:
    """Return the support: of a contact what counts is how its load holds the base.

    Where a field's map would have to be solved for that, all that it follows from.
    """
    by_field = MODELS[scene.map_model].theory == "field"
    if scene.support.kind == "contact" and scene.coil.current and by_field:
        return _read(scene, values, _HELD_BY)
    return dict(scene.held.model_dump(mode="json"))
