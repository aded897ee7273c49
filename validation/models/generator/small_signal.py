"""The machine's answers in small motions: a bimorph by any model on the rod where it rests.

What presses, pulls and induces is the co-energy map of the magnetic model that the scene asks for.
The network itself is asked where the rod rests.  The bars hold the numerical error, not what the
model leaves out of its theory.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Protocol

import numpy as np

from tactgen.geometry.arrays import Complex, Floats, Numbers
from tactgen.geometry.bimorph.ends import Ends
from tactgen.tmm.generator.observed_order import error_bar
from tactgen.tmm.generator.positions import (
    Pull,
    RestingPlace,
    axial_forces,
    resting_place,
    settled_place,
)
from tactgen.tmm.generator.small_signal import (
    Linearised,
    Map,
    axial_poles,
    joined,
    linearised,
    machine,
)
from tactgen.tmm.ports.loads.measured_law import disturbed
from tactgen.tmm.ports.multiport import Multiport, in_series, respond, round_off, terminate
from tactgen.tmm.ports.terminations import tip_stiffness
from tactgen.tmm.reluctance.circuit import CELLS
from tactgen.tmm.reluctance.coenergy.fit import thinned
from tactgen.tmm.reluctance.coenergy.map import CoenergyMap
from tactgen.tmm.reluctance.direct_pull import DirectPull
from tactgen.validation.engine.model import Refined
from tactgen.validation.engine.results import Measured, MeasuredList
from tactgen.validation.scene.scene import Scene

#: The model that is solved where the rod rests, and its ladder's cells there: twice the map's, as
#: slopes in saturated steel converge unevenly where dB/dH changes from cell to cell.
_NETWORK, _CELLS = "network", 2 * CELLS
#: Safety factor on what the observed order of the ladders tells: more than where one slope is
#: judged, since errors of several may cancel in one of the ladders.  With 1.5, 21 of 480 axial
#: motions and impedances of random machines lay outside.
_SAFETY = 2.0
#: Rounding of the roots of a cubic whose roots lie apart.
_ROUNDING = 1e-12


class MachinePull(Pull, Map, Protocol):
    """What the machine reads of a co-energy map: pull and slopes at a current (A) and gap (m)."""


@dataclass(frozen=True)
class _Scaled:
    """A map with all that it says a little larger, by its errors in force and flux linkage."""

    map: CoenergyMap
    by: float
    linkage_by: float

    @property
    def gap_limits(self) -> tuple[float, float]:
        return self.map.gap_limits

    def force(self, current: Floats | float, gap: Floats | float) -> Floats:
        return self.by * self.map.force(current, gap)

    def force_gradient(self, current: Floats | float, gap: Floats | float) -> Floats:
        return self.by * self.map.force_gradient(current, gap)

    def motional_coefficient(self, current: Floats | float, gap: Floats | float) -> Floats:
        return self.by * self.map.motional_coefficient(current, gap)

    def incremental_inductance(self, current: Floats | float, gap: Floats | float) -> Floats:
        return self.linkage_by * self.map.incremental_inductance(current, gap)


@dataclass(frozen=True)
class JudgedRod:
    """The rod in small motions, and by what its error is judged.

    Attributes
    ----------
    fine : Linearised
        The result.
    method : str
        How the error bar comes about, for the reader.
    changed : tuple of (Linearised, float)
        By poorer maps, each with what its distance counts; the bars add.
    ladders : pair of Linearised, optional
        By a ladder of half the cells, and of a quarter: the order is observed.
    """

    fine: Linearised
    method: str = ""
    changed: tuple[tuple[Linearised, float], ...] = ()
    ladders: tuple[Linearised, Linearised] | None = None

    def bar(self, of: Callable[[Linearised], Numbers | float]) -> Floats:
        """Return the error bar of what `of` reads off the rod."""
        value = np.asarray(of(self.fine))
        found = np.zeros(value.shape)
        for rod, counts in self.changed:
            found = found + counts * np.abs(value - of(rod))
        if self.ladders is not None:
            half, quarter = (np.asarray(of(rod)) for rod in self.ladders)
            found = found + error_bar(np.abs(half - quarter), np.abs(value - half), _SAFETY)
        return found


def machine_of(scene: Scene, pull: CoenergyMap) -> JudgedRod:
    """Return the rod about the place where it rests in a scene, and by what it is judged.

    The network is solved there; of another model of the pull there is the map.

    Raises
    ------
    InputError
        If it rests nowhere, or the spring tips its head.
    """
    judged = judged_by_network if scene.map_model == _NETWORK else judged_by_map
    return judged(scene, pull)


def judged_by_network(scene: Scene, pull: CoenergyMap) -> JudgedRod:
    """Return the rod by the network itself, judged by ladders of half and a quarter of the cells.

    The map only says near which place the rod rests; refusals as :func:`machine_of`.
    """
    place = _rest(scene, pull)
    fine, half, quarter = (rod_by_network(scene, pull, place, _CELLS // n) for n in (1, 2, 4))
    method = f"observed order of the network solved there in {_CELLS} cells, half, a quarter"
    return JudgedRod(fine, method, ladders=(half, quarter))


def judged_by_map(scene: Scene, pull: CoenergyMap) -> JudgedRod:
    """Return the rod by a map, judged by that of half the samples and by one that is larger.

    Larger by its stated errors: of the samples, of the fit and between the samples; refusals as
    :func:`machine_of`.
    """
    fine = rod_about(scene, pull)
    sparse, remains = thinned(pull)
    own = _sample_error(pull, abs(scene.coil.current), _rest(scene, pull).lift + scene.gap)
    fitted, between = pull.residual, pull.interpolation_error
    larger = _Scaled(
        pull,
        1.0 + own + fitted.force + between.force,
        1.0 + own + fitted.flux_linkage + between.flux_linkage,
    )
    return JudgedRod(
        fine,
        f"half the change with half the samples of the map by the model {pull.samples.model}, and "
        "the map's stated errors",
        ((rod_about(scene, sparse), remains), (rod_about(scene, larger), 1.0)),
    )


def rod_of(scene: Scene, pull: CoenergyMap) -> Linearised:
    """Return the rod of :func:`machine_of` alone, which costs a third; refusals as there."""
    if scene.map_model == _NETWORK:
        return rod_by_network(scene, pull, _rest(scene, pull), _CELLS)
    return rod_about(scene, pull)


def rod_by_network(scene: Scene, pull: CoenergyMap, near: RestingPlace, cells: int) -> Linearised:
    """Return the rod by the network itself, solved with `cells` where it rests close to a place.

    The map `pull` only bounds the gaps.  If the network holds the rod nowhere close, as it may
    just before it pulls in, the place is looked for anew.
    """
    current = abs(scene.coil.current)
    exact = DirectPull(scene.device, cells, pull.gap_limits)
    forces = axial_forces(scene.device, exact, scene.load.normal_force)
    place = settled_place(forces, current, near)
    if place is None:
        place = resting_place(forces, current, scene.coil.history)
    return linearised(scene.device, scene.beam, place, current, exact)


def of_rod(rod: JudgedRod, of: Callable[[Linearised], float]) -> Measured:
    """Return a number of the rod in small motions, with its bar."""
    return Measured(of(rod.fine), float(rod.bar(of)))


def rod_about(scene: Scene, pull: MachinePull) -> Linearised:
    """Return the rod about the place where it rests, by a map and with nothing to judge it by.

    Raises
    ------
    InputError
        As :func:`machine_of`.
    """
    current = abs(scene.coil.current)
    return linearised(scene.device, scene.beam, _rest(scene, pull), current, pull)


def _rest(scene: Scene, pull: MachinePull) -> RestingPlace:
    forces = axial_forces(scene.device, pull, scene.load.normal_force)
    return resting_place(forces, abs(scene.coil.current), scene.coil.history)


def _sample_error(pull: CoenergyMap, current: float, gap: float) -> float:
    """Return the largest relative error in force of the samples round a current (A) and gap (m)."""
    samples = pull.samples
    if samples.force_error is None:
        return 0.0
    # at no current there is no force to be wrong
    first = max(int(np.searchsorted(samples.current, current, side="right")) - 1, 1)
    near = max(int(np.searchsorted(samples.gap, gap)) - 1, 0)
    some = slice(first, first + 2), slice(near, near + 2)
    return float((samples.force_error[some] / np.abs(samples.force[some])).max())


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
        return np.asarray(self.linear.fine.resistance + 2j * np.pi * port.frequencies * linkage)

    def _judged(self, of: Callable[[Multiport], Complex]) -> MeasuredList:
        """Return what `of` reads off the machine, with the bars of bimorph's ports and map."""
        value = of(self._whole(self.ports.fine))
        rounding = round_off(self._unreduced, ("voltage", "current"))
        rounding = rounding * (1.0 + self.ports.elimination)
        bar: Floats = np.abs(value) * (rounding + self.ports.rounding)
        for coarser, factor in self.ports.coarser:
            bar = bar + factor * np.abs(value - of(self._whole(coarser)))
        bar = bar + self.linear.bar(lambda rod: of(self._whole(self.ports.fine, rod=rod)))
        apart = [
            np.abs(value - of(self._whole(self.ports.fine, ends))) for ends in disturbed(self._ends)
        ]
        return MeasuredList(value, bar + np.hypot(*apart) if apart else bar)

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

    listed: MeasuredList
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
    return MeasuredPoles(MeasuredList(poles, bar, classes), linear.method)
