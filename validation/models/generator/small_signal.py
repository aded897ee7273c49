"""The machine's answers in small motions: a bimorph by any model on the rod where it rests.

What presses, pulls and induces is the reluctance network's; its own error is not in the bars.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from tactgen.geometry.arrays import Complex, Floats
from tactgen.geometry.bimorph.ends import Ends
from tactgen.tmm.generator.network_pull import network_pull
from tactgen.tmm.generator.positions import axial_forces, resting_place
from tactgen.tmm.generator.small_signal import Linearised, axial_poles, linearised, machine
from tactgen.tmm.ports.loads.measured_law import disturbed
from tactgen.tmm.ports.multiport import Multiport, in_series, respond, round_off, terminate
from tactgen.tmm.ports.terminations import tip_stiffness
from tactgen.validation.engine.model import Refined
from tactgen.validation.engine.results import MeasuredList
from tactgen.validation.scene.scene import Scene

#: Rounding of the roots of a cubic whose roots lie apart.
_ROUNDING = 1e-12


def machine_of(scene: Scene) -> Linearised:
    """Return the rod about the place where it rests in a scene.

    Raises
    ------
    InputError
        If it rests nowhere, or the spring tips its head.
    """
    device, current = scene.device, abs(scene.coil.current)
    pull = network_pull(device)
    forces = axial_forces(device, pull, scene.load.normal_force)
    place = resting_place(forces, current, scene.coil.history)
    return linearised(device, scene.beam, place, current, pull)


@dataclass(frozen=True)
class SmallSignal:
    """The machine on a bimorph's ports, with what judges them.

    Attributes
    ----------
    scene : Scene
        Wiring, tip load and the coil's supply are read.
    ports : Refined[Multiport]
        The bimorph by its model, parallel wiring.
    linear : Linearised
        The rod.
    """

    scene: Scene
    ports: Refined[Multiport]
    linear: Linearised

    @property
    def method(self) -> str:
        """How the error bars come about."""
        return f"of the bimorph's ports: {self.ports.method}; the network's own error is not in it"

    def by_voltage(self, motion: str) -> MeasuredList:
        """Return a motion per volt at the bimorph; the coil's supply holds current or voltage."""

        def of(port: Multiport) -> Complex:
            driven = respond(port, {"voltage": 1.0, "current": 0.0})
            if self.scene.coil.supply == "current":
                return driven.motion[motion]
            alone = respond(port, {"voltage": 0.0, "current": 1.0})
            induced = -2j * np.pi * port.frequencies * driven.effort["current"]
            return driven.motion[motion] + alone.motion[motion] * induced / self._impedance(port)

        return self._judged(of)

    def by_current(self, motion: str) -> MeasuredList:
        """Return a motion per ampere in the coil, the bimorph short-circuited."""
        return self._judged(
            lambda port: respond(port, {"voltage": 0.0, "current": 1.0}).motion[motion]
        )

    def by_coil_voltage(self, motion: str) -> MeasuredList:
        """Return a motion per volt at the coil, the bimorph short-circuited."""

        def of(port: Multiport) -> Complex:
            alone = respond(port, {"voltage": 0.0, "current": 1.0})
            return alone.motion[motion] / self._impedance(port)

        return self._judged(of)

    def impedance(self) -> MeasuredList:
        """Return the coil's voltage per current, the bimorph short-circuited."""
        return self._judged(self._impedance)

    def _impedance(self, port: Multiport) -> Complex:
        linkage = respond(port, {"voltage": 0.0, "current": 1.0}).effort["current"]
        return np.asarray(self.linear.resistance + 2j * np.pi * port.frequencies * linkage)

    def _judged(self, of: Callable[[Multiport], Complex]) -> MeasuredList:
        """Return what `of` reads off the machine, with the bars of the bimorph's ports."""
        port = self._whole(self.ports.fine)
        value = of(port)
        rounding = round_off(port, ("voltage", "current")) * (1.0 + self.ports.elimination)
        bar: Floats = np.abs(value) * (rounding + self.ports.rounding)
        for coarser, factor in self.ports.coarser:
            bar = bar + factor * np.abs(value - of(self._whole(coarser)))
        apart = [
            np.abs(value - of(self._whole(self.ports.fine, ends)))
            for ends in disturbed(self.scene.ends)
        ]
        return MeasuredList(value, bar + np.hypot(*apart) if apart else bar)

    def _whole(self, bimorph: Multiport, ends: Ends | None = None) -> Multiport:
        """Return the machine with the tip's load."""
        if self.scene.bimorph.wiring == "series":
            bimorph = in_series(bimorph)
        load = tip_stiffness((ends or self.scene.ends).tip, bimorph.frequencies)
        return terminate(machine(bimorph, self.linear), {"w_tip": load})


@dataclass(frozen=True)
class MeasuredPoles:
    """The poles of axial motion and coil, with their error bars."""

    listed: MeasuredList
    method: str = "rounding of the roots of a cubic; the network's own error is not in it"


def measured_poles(scene: Scene, linear: Linearised) -> MeasuredPoles:
    """Return the poles with the scene's supply, each said to decay or to grow."""
    poles = axial_poles(linear, voltage=scene.coil.supply == "voltage")
    classes = tuple("decays" if pole.real < 0.0 else "grows" for pole in poles)
    return MeasuredPoles(MeasuredList(poles, _ROUNDING * np.abs(poles), classes))
