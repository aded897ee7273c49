"""What the models of the lateral actuator have in common: the same ports, statics and modes."""

from __future__ import annotations

from abc import abstractmethod
from typing import Any

import numpy as np

from tactgen.tmm.ports.multiport import Multiport
from tactgen.validation.catalogue.needs import Need
from tactgen.validation.engine.model import Model, Modes, Refined
from tactgen.validation.engine.stages import Stages
from tactgen.validation.scene.scene import Scene


class BimorphModel(Model):
    """One model of the scene's lateral actuator."""

    def __init__(self, scene: Scene, stages: Stages) -> None:
        super().__init__(scene, stages)
        self.frequencies = np.asarray(scene.frequency, dtype=float)

    def answer(self, need: Need) -> Refined[Any]:
        """Return what quantities with this need are read from."""
        if need == "static":
            return self.static()
        if need == "harmonic":
            return self.ports()
        return self.modes(open_circuit=need == "modes_open")

    @abstractmethod
    def ports(self) -> Refined[Multiport]:
        """Return D(Ω) with losses over the scene's frequencies, parallel wiring."""

    @abstractmethod
    def static(self) -> Refined[Multiport]:
        """Return the lossless D(0), parallel wiring."""

    @abstractmethod
    def modes(self, *, open_circuit: bool) -> Refined[Modes]:
        """Return the lossless modes on the scene's support."""
