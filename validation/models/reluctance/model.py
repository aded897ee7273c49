"""A model of the normal actuator: a point, a co-energy map, switching; and the network as one.

A point is one current at one gap.  The map covers the stroke.  The currents at which the
rod moves are looked up in the map and then solved for at single points, whichever model it is.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import replace

import numpy as np

from tmm.reluctance.coenergy.map import CoenergyMap
from validation.engine.stages import READS, Stages
from validation.models.reluctance.point import MagneticPoint, Measured
from validation.models.reluctance.switching import SwitchingCurrents, switching_currents
from validation.scene.files import leaves
from validation.scene.scene import Scene


class MagneticModel(ABC):
    """One model of the scene's normal actuator; results are computed at most once."""

    name: str

    def __init__(self, scene: Scene, stages: Stages) -> None:
        self.scene, self.stages = scene, stages

    @abstractmethod
    def at(self, current: float, gap: float) -> MagneticPoint:
        """Return the values at a current (A) and gap (m)."""

    @abstractmethod
    def point(self) -> MagneticPoint:
        """Return the values at the scene's current and gap."""

    @abstractmethod
    def _map(self) -> CoenergyMap:
        """Return the co-energy map, solved anew."""

    def map(self) -> CoenergyMap:
        """Return the co-energy map over the stroke."""
        return self.stages.run(f"{self.name}.map", self._map)

    def switching(self) -> SwitchingCurrents:
        """Return the currents at which the rod moves."""

        def work() -> SwitchingCurrents:
            return switching_currents(self.scene.device, self.map(), self.at)

        return self.stages.run(f"{self.name}.switching", work)

    def _described(self) -> str:
        """Return the scene's name and what of it the samples depend on, in SI units."""
        wanted = READS[f"{self.name}.point"]
        groups = self.scene.model_dump(include={path.split(".")[0] for path in wanted})
        read = [f"scene {self.scene.name}"]
        for key, value in leaves(groups):
            if key in wanted or key.split(".")[0] in wanted:
                read.append(f"{key} = {value}")
        return "; ".join(read)


class NetworkModel(MagneticModel):
    """The lumped reluctance network."""

    name = "network"
    _METHOD = "difference from half as many ladder cells; the network's own error is not included"

    def point(self) -> MagneticPoint:
        """Return the values at the scene's current and gap."""
        scene = self.scene
        return self.stages.run("network.point", lambda: self.at(scene.coil.current, scene.gap))

    def at(self, current: float, gap: float) -> MagneticPoint:
        """Return the values at a current (A) and gap (m)."""
        from tmm.reluctance.network import fine_and_coarse, iron_beyond_table

        device = self.scene.device
        fine, coarse = fine_and_coarse(device, np.array([current]), np.array([gap]))

        def judged(name: str) -> Measured:
            value, other = (float(getattr(s, name)[0, 0]) for s in (fine, coarse))
            return Measured(value, abs(value - other))

        return MagneticPoint(
            current=current,
            gap=gap,
            force=judged("force"),
            flux_linkage=judged("flux_linkage"),
            coenergy=judged("coenergy"),
            incremental_inductance=judged("incremental_inductance"),
            method=self._METHOD,
            beyond_table=iron_beyond_table(device, current, gap),
        )

    def _map(self) -> CoenergyMap:
        from tmm.reluctance.coenergy.fit import fit
        from tmm.reluctance.coenergy.range import map_grid
        from tmm.reluctance.network import network_samples

        device = self.scene.device
        found = network_samples(device, *map_grid(device))
        return fit(replace(found, device=self._described()))
