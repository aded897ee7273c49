"""The machine in small motions: a bimorph by any model on its rod, linearised where it rests.

What pulls and induces is the magnetic model that the scene asks for: the network itself, solved
there, or another model's co-energy map.  The errors are numerical, not those of the theory.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from tactgen.geometry.arrays import Complex, Floats, Numbers
from tactgen.geometry.bimorph.boundary_conditions import Ends
from tactgen.tmm.generator.equilibrium import (
    Pull,
    RestingPlace,
    axial_forces,
    resting_place,
    settled_place,
)
from tactgen.tmm.generator.small_signal import Linearised, axial_poles, joined, linearised, machine
from tactgen.tmm.generator.transient.time_integration import error_bar
from tactgen.tmm.ports.measured_loads import disturbed
from tactgen.tmm.ports.multiport import Multiport, respond, wired
from tactgen.tmm.ports.readout import measured
from tactgen.tmm.ports.supports_and_loads import load_tip
from tactgen.tmm.reluctance.coenergy_fit import thinned
from tactgen.tmm.reluctance.coenergy_map import CoenergyMap
from tactgen.tmm.reluctance.magnetic_circuit import CELLS
from tactgen.tmm.reluctance.network import DirectForce
from tactgen.validation.models.model import Estimate, Refined, rounding_of_ports
from tactgen.validation.scene.scene import Scene

#: The model that is solved where the rod rests, and its ladder's cells there: twice the map's, as
#: slopes in saturated steel converge unevenly where dB/dH changes from cell to cell.
_NETWORK, CELLS_AT_REST = "network", 2 * CELLS
#: Safety factor on what the observed order of the ladders tells: more than where one slope is
#: judged, since errors of several may cancel in one of the ladders.  With 1.5, 9 of 240 impedances
#: of random machines' coils lay outside.
_SAFETY = 2.5
#: Currents, and gaps, between which the slopes of two maps are compared around a place.
_PLACES = 5


@dataclass(frozen=True)
class ScaledMap:
    """A map with its force times a factor and more by a constant, its linkage times another."""

    map: CoenergyMap
    by: float = 1.0
    linkage_by: float = 1.0
    more: float = 0.0  #: N

    @property
    def gap_limits(self) -> tuple[float, float]:
        """Gap limits of the map (m)."""
        return self.map.gap_limits

    def force(self, current: Floats | float, gap: Floats | float) -> Floats:
        """Pull (N)."""
        return np.asarray(self.by * self.map.force(current, gap) + self.more)

    def force_gradient(self, current: Floats | float, gap: Floats | float) -> Floats:
        """∂F/∂g (N/m)."""
        return self.by * self.map.force_gradient(current, gap)

    def motional_coefficient(self, current: Floats | float, gap: Floats | float) -> Floats:
        """∂λ/∂g (V s/m)."""
        return self.by * self.map.motional_coefficient(current, gap)

    def incremental_inductance(self, current: Floats | float, gap: Floats | float) -> Floats:
        """∂λ/∂i (H)."""
        return self.linkage_by * self.map.incremental_inductance(current, gap)


@dataclass(frozen=True)
class RodWithError:
    """Rod in small motions, with the basis of its error."""

    fine: Linearised  #: The result
    method: str = ""  #: How the error bar comes about, for the reader
    #: By poorer maps, each with what its distance counts; the bars add
    changed: tuple[tuple[Linearised, float], ...] = ()
    #: By a ladder of half the cells, and of a quarter: the order is observed
    ladders: tuple[Linearised, Linearised] | None = None

    def bar(self, of: Callable[[Linearised], Numbers | float]) -> Floats:
        """Error of a readout of the rod."""
        value = np.asarray(of(self.fine))
        found = np.zeros(value.shape)
        for rod, counts in self.changed:
            found = found + counts * np.abs(value - of(rod))
        if self.ladders is not None:
            half, quarter = (np.asarray(of(rod)) for rod in self.ladders)
            found = found + error_bar(np.abs(half - quarter), np.abs(value - half), _SAFETY)
        return found


@dataclass(frozen=True)
class HalvedMap:
    """A map of half the samples, its slopes no closer to the whole map's than they are around.

    At one point the slopes of both may agree by chance; on average over the cells next to it they
    do not.  Of one current and gap at a time.
    """

    whole: CoenergyMap
    half: CoenergyMap

    @property
    def gap_limits(self) -> tuple[float, float]:
        """Gap limits of the whole map (m)."""
        return self.whole.gap_limits

    def force(self, current: Floats | float, gap: Floats | float) -> Floats:
        """Pull of the half (N)."""
        return self.half.force(current, gap)

    def force_gradient(self, current: Floats | float, gap: Floats | float) -> Floats:
        """∂F/∂g (N/m)."""
        return self._slope("force_gradient", current, gap)

    def motional_coefficient(self, current: Floats | float, gap: Floats | float) -> Floats:
        """∂λ/∂g (V s/m)."""
        return self._slope("motional_coefficient", current, gap)

    def incremental_inductance(self, current: Floats | float, gap: Floats | float) -> Floats:
        """∂λ/∂i (H)."""
        return self._slope("incremental_inductance", current, gap)

    def _slope(self, name: str, current: Floats | float, gap: Floats | float) -> Floats:
        def apart(i: Floats | float, g: Floats | float) -> Floats:
            return np.asarray(getattr(self.half, name)(i, g) - getattr(self.whole, name)(i, g))

        samples = self.whole.samples
        around = apart(_around(samples.current, current)[:, None], _around(samples.gap, gap))
        here = apart(current, gap)
        size = np.maximum(np.abs(here), np.sqrt(np.mean(around**2)))
        return np.asarray(getattr(self.whole, name)(current, gap) + np.copysign(size, here))


def _around(points: Floats, at: Floats | float) -> Floats:
    """Places around one as far as the next samples are apart there, inside the range."""
    k = int(np.clip(np.searchsorted(points, float(at)), 1, points.size - 1))
    near = float(at) + (points[k] - points[k - 1]) * np.linspace(-1.0, 1.0, _PLACES)
    return np.asarray(np.clip(near, points[0], points[-1]))


def machine_of(scene: Scene, pull: CoenergyMap) -> RodWithError:
    """Rod about its equilibrium in a scene, with the basis of its error.

    The network is solved there, judged by ladders of half and a quarter of the cells; of another
    model of the pull there is the map, judged by that of half the samples and by one that is
    larger by its stated errors.

    Raises InputError if it rests nowhere, or the spring tips its head.
    """
    place = _rest(scene, pull)
    if scene.map_model == _NETWORK:
        ladders = (
            DirectForce(scene.device, CELLS_AT_REST // n, pull.gap_limits) for n in (1, 2, 4)
        )
        fine, half, quarter = (rod_by_network(scene, ladder, place) for ladder in ladders)
        cells = f"{CELLS_AT_REST} cells, half, a quarter"
        method = f"observed order of the network solved there in {cells}"
        return RodWithError(fine, method, ladders=(half, quarter))
    sparse, remains = thinned(pull)
    own = _sample_error(pull, abs(scene.coil.current), place.lift + scene.gap)
    between = pull.interpolation_error
    larger = ScaledMap(pull, 1.0 + own + between.force, 1.0 + own + between.flux_linkage)
    return RodWithError(
        rod_about(scene, pull),
        f"half the change with half the samples of the map by the model {pull.samples.model}, of "
        "slopes no less than around, and the map's stated errors",
        ((rod_about(scene, HalvedMap(pull, sparse)), remains), (rod_about(scene, larger), 1.0)),
    )


def rod_of(scene: Scene, pull: CoenergyMap) -> Linearised:
    """Rod of :func:`machine_of` alone, which costs a third; refusals as there."""
    if scene.map_model == _NETWORK:
        exact = DirectForce(scene.device, CELLS_AT_REST, pull.gap_limits)
        return rod_by_network(scene, exact, _rest(scene, pull))
    return rod_about(scene, pull)


def rod_by_network(scene: Scene, exact: DirectForce, near: RestingPlace) -> Linearised:
    """Rod by the network itself, solved where it rests close to a place.

    If the network holds the rod nowhere close, as it may just before it pulls in, the place is
    looked for anew.
    """
    current = abs(scene.coil.current)
    forces = axial_forces(scene.device, exact, scene.load.normal_force)
    place = settled_place(forces, current, near)
    if place is None:
        place = resting_place(forces, current, scene.coil.history)
    return linearised(scene.device, scene.beam, place, current, exact, scene.ends.tip)


def of_rod(rod: RodWithError, of: Callable[[Linearised], float]) -> Estimate:
    """Number of the rod in small motions, with its bar."""
    return Estimate(of(rod.fine), float(rod.bar(of)))


def rod_about(scene: Scene, pull: Pull) -> Linearised:
    """Rod about the place where it rests, by a map and with nothing to judge it by.

    Raises InputError as :func:`machine_of`.
    """
    current = abs(scene.coil.current)
    return linearised(scene.device, scene.beam, _rest(scene, pull), current, pull, scene.ends.tip)


def _rest(scene: Scene, pull: Pull) -> RestingPlace:
    forces = axial_forces(scene.device, pull, scene.load.normal_force)
    return resting_place(forces, abs(scene.coil.current), scene.coil.history)


def _sample_error(pull: CoenergyMap, current: float, gap: float) -> float:
    """Largest relative error in force of the samples round a current (A) and gap (m)."""
    samples = pull.samples
    if samples.force_error is None:
        return 0.0
    # at no current there is no force to be wrong
    first = max(int(np.searchsorted(samples.current, current, side="right")) - 1, 1)
    near = max(int(np.searchsorted(samples.gap, gap)) - 1, 0)
    some = slice(first, first + 2), slice(near, near + 2)
    return float((samples.force_error[some] / np.abs(samples.force[some])).max())


#: Rounding of the roots of a cubic whose roots lie apart.
_ROUNDING = 1e-12


@dataclass(frozen=True)
class SmallSignal:
    """Machine on a bimorph's ports, with the basis of its error."""

    scene: Scene  #: Wiring, tip load and the coil's supply are read
    ports: Refined[Multiport]  #: The bimorph by its model, parallel wiring
    linear: RodWithError  #: The rod, and by what it is judged

    @property
    def method(self) -> str:
        """Description of the error estimate."""
        return f"of the bimorph's ports: {self.ports.method}; of the pull: {self.linear.method}"

    def by_voltage(self, motion: str) -> Estimate:
        """Motion per volt at the bimorph; the coil's supply holds current or voltage."""

        def of(port: Multiport) -> Complex:
            driven = respond(port, {"voltage": 1.0, "current": 0.0})
            moved = measured(driven.motion, motion)
            if self.scene.coil.supply == "current":
                return moved
            alone = respond(port, {"voltage": 0.0, "current": 1.0})
            induced = -2j * np.pi * port.frequencies * driven.effort["current"]
            return moved + measured(alone.motion, motion) * induced / self._impedance(port)

        return self._judged(of)

    def by_current(self, motion: str) -> Estimate:
        """Motion per ampere in the coil, the bimorph short-circuited."""
        return self._judged(
            lambda port: respond(port, {"voltage": 0.0, "current": 1.0}).motion[motion]
        )

    def by_coil_voltage(self, motion: str) -> Estimate:
        """Motion per volt at the coil, the bimorph short-circuited."""

        def of(port: Multiport) -> Complex:
            alone = respond(port, {"voltage": 0.0, "current": 1.0})
            return alone.motion[motion] / self._impedance(port)

        return self._judged(of)

    def impedance(self) -> Estimate:
        """Coil's voltage per current, the bimorph short-circuited."""
        return self._judged(self._impedance)

    def _impedance(self, port: Multiport) -> Complex:
        linkage = respond(port, {"voltage": 0.0, "current": 1.0}).effort["current"]
        return np.asarray(self.linear.fine.resistance + 2j * np.pi * port.frequencies * linkage)

    def _judged(self, of: Callable[[Multiport], Complex]) -> Estimate:
        """Quantity of the machine with errors from the ports and the map."""
        value = of(self._whole(self.ports.fine))
        # the ports between the machine's parts included
        parts = joined(wired(self.ports.fine, self.scene.bimorph.wiring), self.linear.fine)
        unreduced = load_tip(parts, self._ends.tip)
        rounding = rounding_of_ports(self.ports, unreduced, ("voltage", "current"))
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

    def _whole(
        self, bimorph: Multiport, ends: Ends | None = None, rod: Linearised | None = None
    ) -> Multiport:
        """Machine with the tip's load."""
        port = machine(wired(bimorph, self.scene.bimorph.wiring), rod or self.linear.fine)
        return load_tip(port, (ends or self._ends).tip)


@dataclass(frozen=True)
class MeasuredPoles:
    """The poles of axial motion and coil, with their error bars."""

    listed: Estimate
    method: str


def measured_poles(scene: Scene, linear: RodWithError) -> MeasuredPoles:
    """Poles with the scene's supply, each said to decay or to grow."""

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
