"""Data shared by the report sections on the normal actuator."""

from __future__ import annotations

from collections.abc import Callable
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from tactgen.geometry.arrays import Floats
from tactgen.geometry.device.parameters import Device
from tactgen.tmm.reluctance.coenergy_map import CoenergyMap
from tactgen.validation.catalogue.models import MODELS, ranked
from tactgen.validation.catalogue.quantities import FLUX_LINKAGE, MAGNETIC_FORCE, QUANTITIES
from tactgen.validation.engine.comparison import ComparedRow, compare
from tactgen.validation.engine.solve import Solution, solve
from tactgen.validation.models.model import Quantity
from tactgen.validation.models.reluctance.field import AxisymmetricModel, field_rows
from tactgen.validation.models.reluctance.model import (
    MagneticModel,
    NetworkModel,
    RodLoop,
    rod_loop,
)
from tactgen.validation.models.reluctance.switching import MagneticPoint, SwitchingCurrents
from tactgen.validation.scene.variation import is_papers_actuator

if TYPE_CHECKING:
    from tactgen.fem.magnetics.axisymmetric import FieldPoint
    from tactgen.validation.models.difference import Step

#: Curves of a family: shares of the scene's current.
_SHARES = (0.25, 0.5, 0.75, 1.0, 1.25)
#: Curves of a family: this many gaps, from stop to stop.
_GAPS = 4


class NormalActuator:
    """The normal actuator of a study; everything is computed at most once.

    The solution is by models of the normal actuator, at a current.  If it holds no quantity that
    needs a map, maps come from the network, which costs nothing, and if `at_rest` also tell where
    the rod rests.
    """

    def __init__(
        self, solution: Solution, announce: Callable[[str], None], *, at_rest: bool = True
    ) -> None:
        self.solution, self.announce, self._at_rest = solution, announce, at_rest
        self.scene, self.device = solution.scene, solution.scene.device
        self.current, self.gap = self.scene.coil.current, self.scene.gap
        #: Whether it is the paper's actuator, perhaps changed
        self.is_papers = is_papers_actuator(self.scene)
        asked = solution.models_of("reluctance")
        #: Models asked for, cheapest first, and the one that others are held against
        self.models = tuple(name for name in MODELS if name in asked)
        self.reference = ranked(self.models)[-1]
        field = solution.models.get(AxisymmetricModel.name)
        #: The field model, if the scene asks for it
        self.field_model = field if isinstance(field, AxisymmetricModel) else None
        #: Whether a model that solves the field is asked for
        self.has_field = MODELS[self.reference].theory == "field"
        #: Currents (A) and gaps (m) of the families
        self.currents: Floats = np.multiply(_SHARES, self.current)
        self.gaps: Floats = np.geomspace(self.scene.spring.stop_gap, self.gap, _GAPS)
        self._points: dict[tuple[str, float, float], MagneticPoint] = {}

    @property
    def turns_are_set(self) -> bool:
        """Whether iron, coil and gap are those for which the number of turns was chosen."""
        device, usual = self.device, Device()
        coil = device.coil.model_copy(update={"current": usual.coil.current})
        return (device.rod, coil, device.sleeve, device.steel, device.gap) == (
            usual.rod, usual.coil, usual.sleeve, usual.steel, usual.gap,
        )  # fmt: skip

    @cached_property
    def mapped(self) -> Solution:
        """The solution whose models have maps."""
        if any(needs_map(q.name) for q in self.solution.quantities):
            return self.solution
        names = [n for n in QUANTITIES if needs_map(n) and (self._at_rest or not is_of_rest(n))]
        return solve(self.scene, (NetworkModel.name,), names, self.announce, reuse=self.solution)

    @cached_property
    def maps(self) -> dict[str, CoenergyMap]:
        """Co-energy map by model, the most detailed last."""
        return {name: model.map() for name, model in self._mapped_models.items()}

    @property
    def _mapped_models(self) -> dict[str, MagneticModel]:
        given = {q.model for q in self.mapped.quantities if needs_map(q.name)}
        models = self.mapped.models
        return {
            name: model
            for name in MODELS
            if name in given and isinstance(model := models.get(name), MagneticModel)
        }

    @cached_property
    def loops(self) -> tuple[RodLoop, ...]:
        """Where the rod is while the current rises and falls, by each model that has a map."""
        return tuple(rod_loop(model) for model in reversed(self._mapped_models.values()))

    @property
    def pull(self) -> CoenergyMap:
        """The map that pictures show: the reference's if it has one."""
        return self.maps[self.pull_model]

    @property
    def pull_model(self) -> str:
        """The model of that map."""
        return self.reference if self.reference in self.maps else list(self.maps)[-1]

    @cached_property
    def quantities(self) -> tuple[Quantity, ...]:
        """All of the normal actuator's quantities."""
        found = self.solution.quantities
        if self.mapped is not self.solution:
            found += self.mapped.quantities
        return tuple(q for q in found if QUANTITIES[q.name].actuator == "reluctance")

    @cached_property
    def comparison(self) -> list[ComparedRow]:
        """All quantities by all models; the one they are held against stands last."""
        return compare(self.scene, self.quantities, "reluctance")

    @cached_property
    def steps(self) -> list[Step]:
        """Steps from the one-gap formula over the network to the field, if that was asked for."""
        from tactgen.validation.models.difference import formula_to_field

        field = None
        if self.has_field:
            point = self.point(self.current, self.gap)
            values = point.force.value, point.flux_linkage.value
            field = dict(zip((MAGNETIC_FORCE.name, FLUX_LINKAGE.name), values, strict=True))
        return formula_to_field(self.device, self.current, self.gap, field)

    @cached_property
    def switching(self) -> dict[str, SwitchingCurrents]:
        """Switching currents by model."""
        return {name: model.switching() for name, model in self._mapped_models.items()}

    @cached_property
    def points(self) -> tuple[FieldPoint, ...]:
        """Single solutions of the field along both families, where it has no map."""
        if self.field_model is None or self.field_model.name in self.maps:
            return ()
        self.announce("field at single points")
        across = field_rows(self.device, self.gaps, np.array([self.current]))
        along = field_rows(self.device, np.array([self.gap]), self.currents)
        return tuple(point for row in (*across, *along) for point in row)

    def point(self, current: float, gap: float, *, mapped: bool = False) -> MagneticPoint:
        """Point (A, m) by the model that others are held against, or by the one `mapped`.

        It is solved once; the scene's own is the one behind its quantities.
        """
        model = self.mapped.models[self.pull_model] if mapped else None
        model = model or self.solution.models[self.reference]
        assert isinstance(model, MagneticModel)
        key = (model.name, current, gap)
        if key not in self._points:
            own = (current, gap) == (self.current, self.gap)
            planned = f"{model.name}.point" in model.stages.keys
            self._points[key] = model.point() if own and planned else model.at(current, gap)
        return self._points[key]


def is_of_rest(quantity: str) -> bool:
    """Whether a quantity is about where the rod rests."""
    return "rest" in QUANTITIES[quantity].needs


def needs_map(quantity: str) -> bool:
    """Whether a quantity needs a whole map: of a field, the better part of a minute."""
    return bool({"magnetic_map", "rest"} & set(QUANTITIES[quantity].needs))
