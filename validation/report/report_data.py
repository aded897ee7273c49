"""Data shared by the sections of a report: the solution and derived values."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from concurrent.futures import Future
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from functools import cached_property, partial
from typing import TYPE_CHECKING, Any

import numpy as np

from tactgen.geometry.arrays import Complex
from tactgen.geometry.device.parameters import Circuit, Device, Support
from tactgen.geometry.operating_system import core_count
from tactgen.tmm.ports.multiport import passivity_margin, reciprocity_error
from tactgen.tmm.ports.supports_and_loads import outside_known_range
from tactgen.validation.catalogue.models import MODELS
from tactgen.validation.catalogue.quantities import QUANTITIES
from tactgen.validation.engine.comparison import ComparedRow, compare
from tactgen.validation.engine.processes import processes
from tactgen.validation.engine.solve import Solution, asks_display, solve
from tactgen.validation.evidence.case import Outcome, run_check
from tactgen.validation.evidence.verification import group_rows
from tactgen.validation.models.model import Quantity
from tactgen.validation.models.reluctance.field import AxisymmetricModel
from tactgen.validation.report.reluctance_data import NormalActuator, is_of_rest, needs_map
from tactgen.validation.report.request import prepared, quantities_of
from tactgen.validation.scene.parameter_list import ParameterRow, parameter_rows
from tactgen.validation.scene.scene import Scene
from tactgen.validation.scene.warnings import idle

if TYPE_CHECKING:
    from tactgen.validation.models.difference import Step
    from tactgen.validation.studies.parameter_uncertainty import Uncertainty


#: What a template shows, by name.
Context = dict[str, Any]


@dataclass(frozen=True)
class Section:
    """One section: its anchor (also the template's name), its title, its contents.

    A section whose function returns None is left out; numbers and contents follow.
    """

    id: str
    title: str
    context: Callable[[Study], Context | None]


#: Asymmetry and negative dissipation (relative) that condensing a field model may leave by
#: rounding; a wrong sign or a missing term shows at order one.
INVARIANT_TOLERANCE = 1e-6
#: Groups of keys that describe the device and its conditions, not the computation.
_DEVICE = {*Device.model_fields, "support", "load", "drive", "beam", "limits", "skin", "display"}


class Study:
    """One scene, solved for a report; everything is computed at most once."""

    def __init__(
        self, scene: Scene, origins: dict[str, str], announce: Callable[[str], None], *, quick: bool
    ) -> None:
        self.scene = prepared(scene, quick=quick)
        self.origins, self.announce, self.quick = origins, announce, quick
        #: What the sections before show, by their ids.
        self.shown: dict[str, Context] = {}
        self._begun: Mapping[str, Future[Any]] = {}

    @contextmanager
    def ahead(self, jobs: Mapping[str, tuple[Any, ...]]) -> Iterator[None]:
        """Begin functions with what they are given in another process, by their section's id."""
        if not jobs or core_count() < 2:
            yield
            return
        with processes(1) as pool:
            self._begun = {name: pool.submit(*job) for name, job in jobs.items()}
            yield

    def begun(self, name: str, work: Callable[[], Any]) -> Any:
        """Result of a section's work, which another process may have begun."""
        future = self._begun.get(name)
        if future is not None:
            with suppress(BrokenProcessPool):  # it was ended from outside
                return future.result()
        return work()

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
        """The normal actuator, if the scene asks for it; at the paper's current if it has none.

        Then also by the field, at points: a network's error bar does not tell that it is a tenth
        off, and the machine's scene asks for it as a spring.
        """
        models = self.solution.models_of("reluctance")
        if not models or not any(
            QUANTITIES[q.name].actuator == "reluctance" for q in self.solution.quantities
        ):
            return None
        if self.scene.coil.current:
            return NormalActuator(self.solution, self.announce)
        coil = self.scene.coil.model_copy(update={"current": Device().coil.current})
        # held so that no rod rests, for which a field solves a map
        held = Support(kind="clamped")
        driven = self.scene.model_copy(update={"coil": coil, "support": held})
        asked = any(MODELS[name].theory == "field" for name in models)
        names = [
            name
            for name in quantities_of(driven.models, {"reluctance"}, quick=self.quick)
            if not is_of_rest(name) and (asked or not needs_map(name))
        ]
        every = tuple(models) if asked else (*models, AxisymmetricModel.name)
        solution = solve(driven, every, names, self.announce, reuse=self.solution)
        return NormalActuator(solution, self.announce, at_rest=False)

    @cached_property
    def resting(self) -> list[ComparedRow]:
        """Where the machine's rod rests, by all models, where the normal actuator has no row."""
        found = [q for q in self.solution.quantities if is_of_rest(q.name)]
        return compare(self.scene, found, "reluctance") if not self.scene.coil.current else []

    @property
    def asks_field(self) -> bool:
        """Whether the scene asks for a field model of the lateral actuator."""
        return any(MODELS[name].theory == "solid" for name in self.scene.models)

    @property
    def has_steps(self) -> bool:
        """Whether steps lead from the beam to the solid: a piezoelectric bimorph without rod."""
        scene, bimorph = self.scene, self.scene.bimorph
        simple = not (bimorph.layers or bimorph.tip_extension or scene.support.kind == "rod")
        return "solid" in scene.models and simple and scene.piezo.d31 != 0.0

    @cached_property
    def steps(self) -> list[Step] | None:
        """Steps from the beam to the solid, where there are any."""
        if not self.has_steps:
            return None
        from tactgen.validation.models.difference import beam_to_solid

        level = 0 if self.quick else 1
        work = partial(beam_to_solid, self.scene, self.announce, level=level)
        return self.begun("bridge", work)  # type: ignore[no-any-return]

    @cached_property
    def parameter_uncertainty(self) -> list[Uncertainty]:
        """Uncertainty of the headline numbers from the parameters' ranges."""
        from tactgen.validation.studies.parameter_uncertainty import parameter_uncertainty

        work = partial(parameter_uncertainty, self.scene, announce=self.announce)
        return list(self.begun("uncertainty", work))

    @cached_property
    def comparison(self) -> list[ComparedRow]:
        """All scalar quantities of the lateral actuator by all its models."""
        return compare(self.scene, self.solution.quantities, "bimorph")

    @cached_property
    def relative_errors(self) -> dict[str, float]:
        """Numerical errors of the most detailed models' single numbers, by label."""
        cells = {row.info.label: row.most_detailed for row in self.compared}
        return {
            label: cell.error / abs(cell.value)
            for label, cell in cells.items()
            if math.isfinite(cell.value) and math.isfinite(cell.error) and cell.value
        }  # fmt: skip

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
    def invariants(self) -> list[Context]:
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

    def known(self, q: Quantity) -> Complex:
        """Response (n,); nan where the load model does not reach."""
        outside = outside_known_range(self.scene.load, np.asarray(self.scene.frequency))
        return np.where(outside, np.nan, q.value)

    @cached_property
    def parameters(self) -> list[ParameterRow]:
        """The device's parameters that this scene's models, or sections, read."""
        # switching and heat of the coil are shown in any case
        magnetic = {*MODELS["network"].stages["map"], "coil", "steel"} if self.normal else set()
        unread = set() if self.scene.steel.curve == "linear" else {"steel.relative_permeability"}

        def read(key: str) -> bool:
            group = key.partition(".")[0]
            if {key, group} & magnetic:
                return key not in unread
            described = group in _DEVICE or (group == "circuit" and self.scene.circuit != Circuit())
            return described and not idle(self.scene, key)

        return [row for row in parameter_rows(self.scene, self.origins) if read(row.key)]
