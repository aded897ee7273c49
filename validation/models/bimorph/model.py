"""Common base of the bimorph's models: the same ports, statics and modes; and the tip's load."""

from __future__ import annotations

import importlib
from abc import abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from tactgen.geometry.arrays import Floats
from tactgen.geometry.bimorph.ends import Ends
from tactgen.geometry.bimorph.pieces import CentreLine
from tactgen.geometry.errors import InputError
from tactgen.tmm.ports.elements import tip_stiffness
from tactgen.tmm.ports.measured_load import OF_THE_TABLE, MeasuredLaw
from tactgen.tmm.ports.multiport import Multiport
from tactgen.validation.catalogue.models import MAPS
from tactgen.validation.catalogue.row import Need
from tactgen.validation.engine.model import Model, Modes, Refined
from tactgen.validation.engine.results import Estimate
from tactgen.validation.engine.stages import Stages
from tactgen.validation.models.difference import end_share
from tactgen.validation.scene.scene import Scene

#: Rounding of a formula.
_ROUNDING = 1e-14


@dataclass(frozen=True)
class MeasuredLoad:
    """The load of a scene over frequencies (Hz)."""

    ends: Ends
    frequencies: Floats

    @property
    def method(self) -> str:
        """How the error bars come about."""
        return OF_THE_TABLE if isinstance(self.ends.tip, MeasuredLaw) else "rounding of a formula"

    @property
    def impedance(self) -> Estimate:
        """Force per velocity (n,) in N s/m; nan at 0 Hz, where nothing moves steadily."""
        omega = 2.0 * np.pi * np.where(self.frequencies > 0.0, self.frequencies, np.nan)
        # a real division: of complex numbers by nan numpy warns
        value = tip_stiffness(self.ends.tip, self.frequencies) * (-1j * (1.0 / omega))
        bar = _ROUNDING * np.abs(value)
        if isinstance(self.ends.tip, MeasuredLaw):
            bar = bar + self.ends.tip.error(self.frequencies) / omega
        return Estimate(value, bar)


#: Share of a value from which on an answer by beam theory is given with a warning.
_STUBBY = 0.1


class BimorphModel(Model):
    """One model of the scene's lateral actuator."""

    def __init__(self, scene: Scene, stages: Stages) -> None:
        super().__init__(scene, stages)
        self.frequencies = np.asarray(scene.frequency, dtype=float)

    def answer(self, need: Need) -> Any:
        """What quantities with this need are read from."""
        if need in ("small_signal", "machine_poles"):
            return self._machine(need)
        if need == "crosstalk":
            return self._crosstalk()
        if need == "load":  # of whichever model: the load is the same
            return MeasuredLoad(self.scene.ends, self.frequencies)
        if need == "static":
            return self.static()
        if need == "harmonic":
            return self.ports()
        return self.modes(open_circuit=need == "modes_open")

    def _machine(self, need: Need) -> Any:
        """Machine's answer, with this bimorph on its rod."""
        from tactgen.validation.models.generator.small_signal import (
            SmallSignal,
            machine_of,
            measured_poles,
        )

        pull = importlib.import_module(MAPS).map_of(self.scene, self.stages)
        linear = self.run("machine", lambda: machine_of(self.scene, pull))
        if need == "machine_poles":
            return measured_poles(self.scene, linear)
        return SmallSignal(self.scene, self.ports(), linear)

    def _crosstalk(self) -> Any:
        """What one unit moves at the others, all of them on this bimorph."""
        from tactgen.validation.models.display.crosstalk import crosstalk

        return self.run("crosstalk", lambda: crosstalk(self.scene, self.ports()))

    @abstractmethod
    def ports(self) -> Refined[Multiport]:
        """D(Ω) with losses over the scene's frequencies, parallel wiring."""

    @abstractmethod
    def static(self) -> Refined[Multiport]:
        """Lossless D(0), parallel wiring."""

    @abstractmethod
    def modes(self, *, open_circuit: bool) -> Refined[Modes]:
        """Lossless modes on the scene's support."""


class BeamTheoryModel(BimorphModel):
    """A model of a row of beams: stages ports, static and modes, all of them fast."""

    @classmethod
    def check(cls, scene: Scene) -> None:
        """Refuse a bimorph shorter than it is thick, about which no beam theory says anything."""
        bimorph, mm = scene.bimorph, 1e3
        if bimorph.length < bimorph.thickness:
            raise InputError(
                f"bimorph.length = {bimorph.length * mm:g} mm is less than the layers' thickness "
                f"of {bimorph.thickness * mm:g} mm: that is no beam, and the models lumped, tmm "
                "and beam have no answer; make it longer or ask for --set models=solid"
            )

    def warnings(self, quantities: Sequence[str]) -> tuple[str, ...]:
        """Say of a stubby bimorph how far beam theory may be off."""
        bimorph, share = self.scene.bimorph, end_share(self.scene)
        if share < _STUBBY:
            return ()
        sentence = (
            f"bimorph.length = {1e3 * bimorph.length:g} mm is "
            f"{bimorph.length / bimorph.thickness:.2g} thicknesses and "
            f"{bimorph.length / bimorph.width:.2g} widths, which is stubby for the "
            "one-dimensional models: their deflection, frequency and capacitance may be "
            f"{100.0 * share:.0f} % off by the ends alone; compare with --set models=solid"
        )
        return (sentence,)

    def answer(self, need: Need) -> Any:
        """What quantities with this need are read from; of many units, each its own beam."""
        return self._spread() if need == "spread" else super().answer(need)

    def _spread(self) -> Any:
        from tactgen.validation.models.display.spread import first_frequency, spread

        def first(scene: Scene) -> Estimate:
            return first_frequency(type(self)(scene, self.stages)._modes(open_circuit=False))

        alone = self.scene.model_copy(update={"modes": 1})
        return self.run("spread", lambda: spread(alone, first))

    def ports(self) -> Refined[Multiport]:
        """D(Ω) with losses over the scene's frequencies."""
        return self.run("ports", lambda: self._multiport(self.frequencies, lossy=True))

    def static(self) -> Refined[Multiport]:
        """Lossless D(0)."""
        return self.run("static", lambda: self._multiport(np.zeros(1), lossy=False))

    def modes(self, *, open_circuit: bool) -> Refined[Modes]:
        """Lossless modes."""
        both = self.run("modes", lambda: tuple(self._modes(open_circuit=q) for q in (False, True)))
        return both[open_circuit]

    @abstractmethod
    def mode_lines(self, *, open_circuit: bool) -> list[CentreLine]:
        """Centre line of every mode of :meth:`modes`, of unit tip displacement."""

    @abstractmethod
    def driven_line(self, frequency: float, voltage: float, *, lossy: bool) -> CentreLine:
        """Centre line at a frequency (Hz) and a voltage (V) across each layer.

        Without losses the ends have none either, and the finger is left out, as in statics.
        """

    @abstractmethod
    def _multiport(self, frequencies: Floats, *, lossy: bool) -> Refined[Multiport]:
        """D(Ω), parallel wiring."""

    @abstractmethod
    def _modes(self, *, open_circuit: bool) -> Refined[Modes]:
        """Lossless modes in one circuit."""
