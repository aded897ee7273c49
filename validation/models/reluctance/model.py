"""A model of the normal actuator: a point, a co-energy map, switching; and the network as one.

A point is one current at one gap.  The map covers the stroke.  The currents at which the
rod moves are looked up in the map and then solved for at single points, whichever model it is.
"""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from tactgen.tmm.reluctance.coenergy_map import CoenergyMap
from tactgen.validation.catalogue.models import MODELS
from tactgen.validation.catalogue.row import Need
from tactgen.validation.engine.model import Model
from tactgen.validation.engine.results import Estimate
from tactgen.validation.models.reluctance.point import MagneticPoint
from tactgen.validation.models.reluctance.rest import RestingState, resting_state
from tactgen.validation.models.reluctance.switching import (
    Solver,
    SwitchingCurrents,
    switching_currents,
)
from tactgen.validation.models.reluctance.warnings import magnetic_warnings
from tactgen.validation.scene.files import leaves
from tactgen.validation.scene.scene import Scene


class MagneticModel(Model):
    """One model of the scene's normal actuator."""

    def answer(self, need: Need) -> Any:
        """Return what quantities with this need are read from."""
        if need == "rest":
            return self.rest()
        if need == "neighbours":
            return self.run("neighbours", self._neighbours)
        return self.point() if need == "magnetic_point" else self.switching()

    def warnings(self, quantities: Sequence[str]) -> tuple[str, ...]:
        """Return which currents have no value, and whether the steel's curve was too short."""
        return magnetic_warnings(self.name, self.scene, quantities, self.answer)

    @abstractmethod
    def at(self, current: float, gap: float) -> MagneticPoint:
        """Return the values at a current (A) and gap (m)."""

    def _solver(self) -> Solver:
        """Return what solves currents and gaps one after another, as `at` does each alone."""
        return self.at

    @abstractmethod
    def point(self) -> MagneticPoint:
        """Return the values at the scene's current and gap."""

    @abstractmethod
    def _map(self) -> CoenergyMap:
        """Return the co-energy map, solved anew."""

    def _neighbours(self) -> Any:
        """Return the field between units of the display, where the model gives it."""
        raise NotImplementedError(f"{self.name} knows one actuator")

    def map(self) -> CoenergyMap:
        """Return the co-energy map over the stroke."""
        return self.run("map", self._map)

    def switching(self) -> SwitchingCurrents:
        """Return the currents at which the rod moves."""

        def work() -> SwitchingCurrents:
            return switching_currents(self.scene.device, self.map(), self._solver())

        return self.run("switching", work)

    def rest(self) -> RestingState:
        """Return where the rod rests at the scene's current."""
        scene = self.scene

        def work() -> RestingState:
            return resting_state(
                scene.device, self.map(), self.at, scene.coil.history, scene.load.normal_force
            )

        return self.run("rest", work)

    def _described(self) -> str:
        """Return the scene's name and what of it the samples depend on, in SI units."""
        wanted = MODELS[self.name].stages["point"]
        groups = self.scene.model_dump(include={path.split(".")[0] for path in wanted})
        read = [f"scene {self.scene.name}"]
        for key, value in leaves(groups):
            if key in wanted or key.split(".")[0] in wanted:
                read.append(f"{key} = {value}")
        return "; ".join(read)


class NetworkModel(MagneticModel):
    """The lumped reluctance network."""

    name = "network"
    _METHOD = (
        "difference from half as many ladder cells, of the incremental inductance no less in "
        "relation than of the flux linkage; the network's own error is not included"
    )

    @classmethod
    def check(cls, scene: Scene) -> None:
        """Refuse a scene whose parts do not form the network's circuit."""
        from tactgen.tmm.reluctance.circuit import check_circuit

        check_circuit(scene.device, np.array([scene.gap]))

    def point(self) -> MagneticPoint:
        """Return the values at the scene's current and gap."""
        scene = self.scene
        return self.run("point", lambda: self.at(scene.coil.current, scene.gap))

    def at(self, current: float, gap: float) -> MagneticPoint:
        """Return the values at a current (A) and gap (m)."""
        from tactgen.tmm.reluctance.network import fine_and_coarse, iron_beyond_table

        device = self.scene.device
        fine, coarse = fine_and_coarse(device, np.array([current]), np.array([gap]))

        def judged(name: str) -> Estimate:
            value, other = (float(getattr(s, name)[0, 0]) for s in (fine, coarse))
            return Estimate(value, abs(value - other))

        linkage, slope = judged("flux_linkage"), judged("incremental_inductance")
        if linkage.value:
            # two ladders' slopes may agree by chance: in relation one is off by no less than λ
            slope = replace(
                slope, error=max(slope.error, abs(slope.value * linkage.error / linkage.value))
            )  # fmt: skip
        return MagneticPoint(
            current=current,
            gap=gap,
            force=judged("force"),
            flux_linkage=linkage,
            coenergy=judged("coenergy"),
            incremental_inductance=slope,
            method=self._METHOD,
            beyond_table=iron_beyond_table(device, current, gap),
        )

    def _neighbours(self) -> Any:
        from tactgen.validation.models.display.field import by_network

        return by_network(self.scene)

    def _map(self) -> CoenergyMap:
        from tactgen.tmm.reluctance.map_range import network_pull

        # the one that where the rod rests is found by, with its device for the reader
        found = network_pull(self.scene.device)
        return replace(found, samples=replace(found.samples, device=self._described()))
