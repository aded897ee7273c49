"""Stages of a study: run once, timed, keyed by exactly the inputs they read.

A stage that the plan does not contain is refused, so the plan shown to the user is the
plan that runs.  Results of expensive stages are kept in the store, for the next run.
"""

from __future__ import annotations

import hashlib
import json
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any, TypeVar

from geometry.device.steel_law import magnetisation_curve
from geometry.store.store import kept
from validation.catalogue.quantities import MAGNETIC_MODELS
from validation.scene.scene import Scene

T = TypeVar("T")

_PIECES = ("bimorph", "piezo", "shim", "beam", "support.kind", "glue", "rod")
_SOLID = ("bimorph", "piezo", "shim", "support.kind", "glue", "rod")
_GEOMETRY = ("bimorph", "support.kind", "glue", "rod")
_MESH = (*_GEOMETRY, "mesh", "accuracy")
_FIXED = ("support", "load")
_MAGNETIC = (
    "rod.radius", "rod.head_radius", "rod.head_thickness", "rod.flange_radius",
    "rod.flange_thickness", "rod.flange_position", "rod.length", "coil.inner_radius",
    "coil.outer_radius", "coil.length", "coil.position", "coil.turns", "coil.current", "sleeve",
    "steel.curve", "gap",
)  # fmt: skip
#: The map covers what the spring may ask of it.
_MAP = (*_MAGNETIC, "spring")

_SLOT = (
    "support.kind", "rod.slot_depth", "bimorph.width", "bimorph.shim_thickness", "glue.thickness",
)  # fmt: skip

#: What each stage reads, by scene key; a changed voltage re-meshes nothing.
READS: dict[str, tuple[str, ...]] = {
    "lumped.ports": (*_PIECES, "frequency"),
    "lumped.static": _PIECES,
    "lumped.modes": (*_PIECES, *_FIXED),
    "tmm.ports": (*_PIECES, "frequency"),
    "tmm.static": _PIECES,
    "tmm.modes": (*_PIECES, *_FIXED, "modes"),
    "beam.ports": (*_PIECES, "frequency"),
    "beam.static": _PIECES,
    "beam.modes": (*_PIECES, *_FIXED, "modes"),
    # tetrahedra are refined by what is solved on them
    "solid.mesh": (*_MESH, *_SOLID),
    "solid.assembly": (*_MESH, *_SOLID),
    "solid.static": (*_MESH, *_SOLID),
    "solid.modal": (*_MESH, *_SOLID, "modes"),
    "solid.modes_short": (*_MESH, *_SOLID, *_FIXED, "modes"),
    "solid.modes_open": (*_MESH, *_SOLID, *_FIXED, "modes"),
    "solid.ports": (*_MESH, *_SOLID, "frequency"),
    "network.point": _MAGNETIC,
    "network.map": _MAP,
    "network.switching": _MAP,
    "axisymmetric.point": (*_MAGNETIC, "accuracy"),
    "axisymmetric.map": _MAP,
    "axisymmetric.switching": (*_MAP, "accuracy"),
    "magnetic3d.point": (*_MAGNETIC, "accuracy", "mesh.kind", *_SLOT),
    "magnetic3d.map": (*_MAP, "mesh.kind"),
    "magnetic3d.switching": (*_MAP, "accuracy", "mesh.kind"),
    "terminations": ("support", "load", "drive", "bimorph.wiring", "frequency"),
}

#: The mesher's own process is started by its file, which no import names.
_MESHER = "geometry.meshing.tetwild"
_SOLID_CODE = ("validation.models.bimorph.solid", _MESHER)
_FIELD_CODE = ("validation.models.reluctance.field", _MESHER)

#: Stages whose results are kept in the store, with what computes them (modules and packages;
#: what these import counts as well).  All others cost less than reading would.
KEPT: dict[str, tuple[str, ...]] = {
    "solid.static": _SOLID_CODE,
    "solid.modal": _SOLID_CODE,
    "solid.ports": _SOLID_CODE,
    **{
        f"{model}.{stage}": _FIELD_CODE
        for model in MAGNETIC_MODELS
        for stage in ("point", "map", "switching")
    },
}


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
    """

    keys: dict[str, str]
    announce: Callable[[str], None] = lambda _: None
    seconds: dict[str, float] = field(default_factory=dict)
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
                return work()

            if name in KEPT:
                self._results[name] = kept(
                    name, (self.keys[name],), KEPT[name], announced, announce=self.announce
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
            if other.keys.get(name) == key and name in other._results:
                self._results[name] = other._results[name]
                self.seconds[name] = other.seconds[name]


def stage_key(name: str, scene: Scene) -> str:
    """Return the stage's key: a hash of the scene values it reads."""
    values = scene.model_dump(mode="json")
    read: dict[str, Any] = {}
    for path in READS[name]:
        value: Any = values
        for part in path.split("."):
            value = value[part]
        if path == "steel.curve":  # a name, or a file: what counts is what is in it
            curve = magnetisation_curve(scene.steel)
            value = [curve.flux_density.tolist(), curve.field.tolist(), curve.slope_beyond]
        read[path] = value
    text = json.dumps([name, read], sort_keys=True)
    return hashlib.sha256(text.encode()).hexdigest()[:16]
