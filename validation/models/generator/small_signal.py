"""The machine's answers in small motions: a bimorph by any model on the rod where it rests.

What presses, pulls and induces is the co-energy map of the magnetic model that the scene asks for.
The network itself is asked where the rod rests.  The bars hold the numerical error, not what the
model leaves out of its theory.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from tactgen.geometry.arrays import Complex, Floats
from tactgen.geometry.bimorph.ends import Ends
from tactgen.tmm.generator.small_signal import (
    Linearised,
    axial_poles,
    joined,
    machine,
)
from tactgen.tmm.ports.elements import tip_stiffness
from tactgen.tmm.ports.measured_load import disturbed
from tactgen.tmm.ports.multiport import Multiport, in_series, respond, terminate
from tactgen.validation.engine.model import Refined
from tactgen.validation.engine.reading import rounding_of_ports
from tactgen.validation.engine.results import Estimate
from tactgen.validation.models.generator.judged_rod import JudgedRod
from tactgen.validation.scene.scene import Scene

#: Rounding of the roots of a cubic whose roots lie apart.
_ROUNDING = 1e-12


@dataclass(frozen=True)
class SmallSignal:
    """The machine on a bimorph's ports, with what judges them.

    Attributes
    ----------
    scene : Scene
        Wiring, tip load and the coil's supply are read.
    ports : Refined[Multiport]
        The bimorph by its model, parallel wiring.
    linear : JudgedRod
        The rod, and by what it is judged.
    """

    scene: Scene
    ports: Refined[Multiport]
    linear: JudgedRod

    @property
    def method(self) -> str:
        """How the error bars come about."""
        return f"of the bimorph's ports: {self.ports.method}; of the pull: {self.linear.method}"

    def by_voltage(self, motion: str) -> Estimate:
        """Return a motion per volt at the bimorph; the coil's supply holds current or voltage."""

        def of(port: Multiport) -> Complex:
            driven = respond(port, {"voltage": 1.0, "current": 0.0})
            if self.scene.coil.supply == "current":
                return driven.motion[motion]
            alone = respond(port, {"voltage": 0.0, "current": 1.0})
            induced = -2j * np.pi * port.frequencies * driven.effort["current"]
            return driven.motion[motion] + alone.motion[motion] * induced / self._impedance(port)

        return self._judged(of)

    def by_current(self, motion: str) -> Estimate:
        """Return a motion per ampere in the coil, the bimorph short-circuited."""
        return self._judged(
            lambda port: respond(port, {"voltage": 0.0, "current": 1.0}).motion[motion]
        )

    def by_coil_voltage(self, motion: str) -> Estimate:
        """Return a motion per volt at the coil, the bimorph short-circuited."""

        def of(port: Multiport) -> Complex:
            alone = respond(port, {"voltage": 0.0, "current": 1.0})
            return alone.motion[motion] / self._impedance(port)

        return self._judged(of)

    def impedance(self) -> Estimate:
        """Return the coil's voltage per current, the bimorph short-circuited."""
        return self._judged(self._impedance)

    def _impedance(self, port: Multiport) -> Complex:
        linkage = respond(port, {"voltage": 0.0, "current": 1.0}).effort["current"]
        return np.asarray(self.linear.fine.resistance + 2j * np.pi * port.frequencies * linkage)

    def _judged(self, of: Callable[[Multiport], Complex]) -> Estimate:
        """Return what `of` reads off the machine, with the bars of bimorph's ports and map."""
        value = of(self._whole(self.ports.fine))
        rounding = rounding_of_ports(self.ports, self._unreduced, ("voltage", "current"))
        bar: Floats = np.abs(value) * (rounding + self.ports.rounding)
        for coarser, factor in self.ports.coarser:
            bar = bar + factor * np.abs(value - of(self._whole(coarser)))
        bar = bar + self.linear.bar(lambda rod: of(self._whole(self.ports.fine, rod=rod)))
        apart = [
            np.abs(value - of(self._whole(self.ports.fine, ends))) for ends in disturbed(self._ends)
        ]
        return Estimate(value, bar + np.hypot(*apart) if apart else bar)

    @cached_property
    def _ends(self) -> Ends:
        return self.scene.ends

    @cached_property
    def _unreduced(self) -> Multiport:
        """The machine with the tip's load, the ports between its parts included."""
        return self._loaded(joined(self._wired(self.ports.fine), self.linear.fine), self._ends)

    def _whole(
        self, bimorph: Multiport, ends: Ends | None = None, rod: Linearised | None = None
    ) -> Multiport:
        """Return the machine with the tip's load."""
        port = machine(self._wired(bimorph), rod or self.linear.fine)
        return self._loaded(port, ends or self._ends)

    def _wired(self, bimorph: Multiport) -> Multiport:
        return in_series(bimorph) if self.scene.bimorph.wiring == "series" else bimorph

    def _loaded(self, port: Multiport, ends: Ends) -> Multiport:
        return terminate(port, {"w_tip": tip_stiffness(ends.tip, port.frequencies)})


@dataclass(frozen=True)
class MeasuredPoles:
    """The poles of axial motion and coil, with their error bars."""

    listed: Estimate
    method: str


def measured_poles(scene: Scene, linear: JudgedRod) -> MeasuredPoles:
    """Return the poles with the scene's supply, each said to decay or to grow."""

    def of(rod: Linearised) -> Complex:
        return axial_poles(rod, voltage=scene.coil.supply == "voltage")

    poles = of(linear.fine)

    def partners(rod: Linearised) -> Complex:
        # the nearest: two real ones may become a pair
        others = of(rod)
        return np.asarray(others[np.abs(poles[:, None] - others).argmin(axis=1)])

    bar = _ROUNDING * np.abs(poles) + linear.bar(partners)
    classes = tuple("decays" if pole.real < 0.0 else "grows" for pole in poles)
    return MeasuredPoles(Estimate(poles, bar, classes=classes), linear.method)
