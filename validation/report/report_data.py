"""Data shared by the sections of a report: the solution and derived values."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    pass
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any

from tactgen.geometry.arrays import Complex
from tactgen.geometry.device.parameters import Device
from tactgen.tmm.ports.elements import outside_known_range
from tactgen.tmm.ports.multiport import passivity_margin, reciprocity_error
from tactgen.validation.catalogue.models import MODELS
from tactgen.validation.catalogue.quantities import QUANTITIES, TIP_DISPLACEMENT
from tactgen.validation.engine.comparison import ComparedRow, compare
from tactgen.validation.engine.solve import Plan, Solution, asks_display, solve
from tactgen.validation.evidence.case import Outcome, run_check
from tactgen.validation.evidence.verification import group_rows
from tactgen.validation.report.reluctance_data import NormalActuator, merged
from tactgen.validation.report.request import is_of_rest, prepared, quantities_of, shown_model
from tactgen.validation.scene.parameter_list import ParameterRow, parameter_rows
from tactgen.validation.scene.scene import Scene

if TYPE_CHECKING:
    from tactgen.geometry.bimorph.bricks import Bricks
    from tactgen.geometry.meshing.mesh import Mesh
    from tactgen.validation.models.bimorph.mesh_pair import TwoMeshModel
    from tactgen.validation.models.difference import Cause, Step
    from tactgen.validation.studies.parameter_uncertainty import Uncertainty


#: What a figure says of each load.
_TITLES = {
    "finger": "under the finger",
    "none": "free tip",
    "mass": "with the tip mass",
    "spring_damper": "on spring and damper",
    "table": "under the measured load",
    "pad": "under imitation skin and its weight",
}


@dataclass(frozen=True)
class LoadCase:
    """A load under which all models' responses are plotted."""

    name: str
    title: str
    solution: Solution

    @property
    def models(self) -> tuple[str, ...]:
        """Models that give the response."""
        return tuple(self.solution.by_model(TIP_DISPLACEMENT.name))

    def curve(self, model: str) -> Complex:
        """Tip displacement (n,); nan where the load model does not reach."""
        values = self.solution.get(TIP_DISPLACEMENT.name, model).value
        outside = outside_known_range(
            self.solution.scene.load, np.asarray(self.solution.scene.frequency)
        )
        return np.where(outside, np.nan, values)

    def summary(self, model: str) -> dict[str, float]:
        """Largest and first displacement (m), where (Hz), and the widest bar."""
        q = self.solution.get(TIP_DISPLACEMENT.name, model)
        size = np.abs(self.curve(model))
        at = int(np.nanargmax(size))
        known = np.isfinite(size) & (size > 0.0)
        first = int(np.flatnonzero(known)[0]) if known.any() else 0
        frequency = np.asarray(self.solution.scene.frequency)
        return {
            "largest": float(size[at]),
            "at": float(frequency[at]),
            "first": float(size[first]),
            "first_at": float(frequency[first]),
            "bar": float(np.max(q.error[known] / size[known], initial=0.0)),
        }


def load_cases(solution: Solution, announce: Callable[[str], None]) -> list[LoadCase]:
    """Solution's response and, without new field solutions, that of another load."""
    scene = solution.scene
    kind = scene.load.kind
    other = "none" if kind != "none" else "finger"
    announce(f"response: {_TITLES[other]}")
    load = scene.load.model_copy(update={"kind": other})
    changed = scene.model_copy(update={"load": load})
    again = solve(changed, quantities=(TIP_DISPLACEMENT.name,), reuse=solution)
    return [LoadCase(kind, _TITLES[kind], solution), LoadCase(other, _TITLES[other], again)]


#: Asymmetry and negative dissipation (relative) that condensing a field model may leave by
#: rounding; a wrong sign or a missing term shows at order one.
INVARIANT_TOLERANCE = 1e-6


class Study:
    """One scene, solved for a report; everything is computed at most once."""

    def __init__(
        self, scene: Scene, origins: dict[str, str], announce: Callable[[str], None], *, quick: bool
    ) -> None:
        self.asked = scene.accuracy
        self.scene = prepared(scene, quick=quick)
        self.origins, self.announce, self.quick = origins, announce, quick
        #: What the sections before show, by their ids.
        self.shown: dict[str, dict[str, Any]] = {}

    @cached_property
    def solution(self) -> Solution:
        """All quantities of the scene by all its models."""
        return solve(self.scene, announce=self.announce)

    @property
    def as_it_stands(self) -> bool:
        """Whether nothing of a built-in scene was changed."""
        return set(self.origins.values()) == {f"scene {self.scene.name}"}

    @property
    def lateral(self) -> bool:
        """Whether the scene asks for the lateral actuator."""
        return bool(self.solution.models_of("bimorph"))

    @property
    def machine(self) -> bool:
        """Whether the scene is about the bimorph on the rod's contact."""
        return self.lateral and self.scene.support.kind == "contact"

    @cached_property
    def normal(self) -> NormalActuator | None:
        """The normal actuator, if the scene asks for it; at the paper's current if it has none."""
        models = self.solution.models_of("reluctance")
        if not models or not any(
            QUANTITIES[q.name].actuator == "reluctance" for q in self.solution.quantities
        ):
            return None
        if self.scene.coil.current:
            return NormalActuator(self.solution, self.announce)
        coil = self.scene.coil.model_copy(update={"current": Device().coil.current})
        driven = self.scene.model_copy(update={"coil": coil})
        names = [
            name
            for name in quantities_of(driven.models, {"reluctance"}, quick=self.quick)
            if not is_of_rest(name)
        ]
        solution = solve(driven, tuple(models), names, self.announce, reuse=self.solution)
        return NormalActuator(solution, self.announce)

    @cached_property
    def resting(self) -> list[ComparedRow]:
        """Where the machine's rod rests, by all models, where the normal actuator has no row."""
        found = [q for q in self.solution.quantities if is_of_rest(q.name)]
        return compare(self.scene, found, "reluctance") if not self.scene.coil.current else []

    @property
    def field(self) -> TwoMeshModel | None:
        """The field model to be shown, if the scene asks for one that has fields."""
        from tactgen.validation.models.bimorph.mesh_pair import TwoMeshModel

        model = self.solution.models.get(shown_model(self.scene) or "")
        return model if isinstance(model, TwoMeshModel) else None

    @property
    def shown_mesh(self) -> Mesh | Bricks | None:
        """The mesh to be shown; of bricks known before anything is solved."""
        if shown_model(self.scene) != "solid":
            return self.field.meshes()[0] if self.field else None
        from tactgen.validation.models.bimorph.solid import brick_pair

        return brick_pair(self.scene).meshes[0]

    @property
    def asks_field(self) -> bool:
        """Whether the scene asks for a field model of the lateral actuator."""
        return any(MODELS[name].theory == "solid" for name in self.scene.models)

    @cached_property
    def steps(self) -> list[Step] | None:
        """Steps from the beam to the solid, for a piezoelectric bimorph without rod."""
        scene = self.scene
        if "solid" not in scene.models or scene.support.kind == "rod" or scene.piezo.d31 == 0.0:
            return None
        from tactgen.validation.models.difference import beam_to_solid

        return beam_to_solid(scene, self.announce, level=0 if self.quick else 1)

    @cached_property
    def parameter_uncertainty(self) -> list[Uncertainty]:
        """Uncertainty of the headline numbers from the parameters' ranges."""
        from tactgen.validation.studies.parameter_uncertainty import parameter_uncertainty

        return list(parameter_uncertainty(self.scene, announce=self.announce))

    @cached_property
    def causes(self) -> list[Cause] | None:
        """Differences between beam and solid; in the rod not in a quick report."""
        from tactgen.validation.models.difference import causes, causes_on_rod

        if self.steps:
            return causes(self.steps)
        scene = self.scene
        free = scene.load.kind in ("none", "finger")
        on_rod = scene.support.kind == "rod" and self.asks_field and scene.piezo.d31 != 0.0
        return causes_on_rod(scene, self.announce) if on_rod and free and not self.quick else None

    @cached_property
    def comparison(self) -> list[ComparedRow]:
        """All scalar quantities of the lateral actuator by all its models."""
        return compare(self.scene, self.solution.quantities, "bimorph", self.causes)

    @property
    def compared(self) -> list[ComparedRow]:
        """All scalar quantities that were asked for, of both actuators."""
        lateral = self.comparison if self.lateral else []
        return lateral + self.resting + (self.normal.comparison if self.normal else [])

    @cached_property
    def outcomes(self) -> list[Outcome]:
        """The suite's checks that are about this very scene, if nothing of it was changed."""
        if not self.as_it_stands:
            return []
        about = (
            ("bimorph", self.lateral),
            ("reluctance", self.normal is not None),
            ("motion", self.machine),
            ("display", asks_display(self.scene.quantities)),
        )
        groups = [group for group, asked in about if asked]
        rows = [c for g in groups for c in group_rows(g) if c.scene == self.scene.name]
        found = []
        for check in rows:
            if not check.heavy:
                self.announce(f"check {check.id}")
                found.append(run_check(check))
        return found

    @cached_property
    def invariants(self) -> list[dict[str, Any]]:
        """Reciprocity and passivity of each model's ports over the sweep."""
        found = []
        for name, model in self.solution.models_of("bimorph").items():
            if "harmonic" not in MODELS[name].gives:
                continue
            port = model.answer("harmonic").fine
            asymmetry = float(reciprocity_error(port).max())
            margin = float(passivity_margin(port).min())
            holds = asymmetry < INVARIANT_TOLERANCE and margin > -INVARIANT_TOLERANCE
            found.append(
                {"model": name, "reciprocity": asymmetry, "passivity": margin, "holds": holds}
            )
        return found

    @cached_property
    def cases(self) -> list[LoadCase]:
        """The scene's response and, without new field solutions, that of another load."""
        return load_cases(self.solution, self.announce)

    @cached_property
    def parameters(self) -> list[ParameterRow]:
        """The parameters that this scene's models read."""
        keys: set[str] = set()
        if self.lateral:
            keys |= {"bimorph", "piezo", "shim", "support", "load", "drive", "beam"}
            if self.scene.support.kind == "rod":
                keys |= {"glue", "rod", "coil", "sleeve", "gap"}
        if self.normal:
            keys |= {*MODELS["network"].stages["map"], "coil", "steel"}
        unread = set() if self.scene.steel.curve == "linear" else {"steel.relative_permeability"}
        rows = parameter_rows(self.scene, self.origins)
        return [r for r in rows if {r.key, r.key.split(".")[0]} & keys and r.key not in unread]

    @property
    def plan(self) -> Plan:
        """The stages of the solution, and of the normal actuator's map if it came apart."""
        plan = self.solution.plan
        return merged(plan, self.normal.merged_plan()) if self.normal else plan

    @property
    def seconds(self) -> dict[str, float]:
        """Cost of each stage of the plan."""
        apart = self.normal.seconds if self.normal else {}
        return apart | self.solution.stages.seconds
