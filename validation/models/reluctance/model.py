"""Models of the normal actuator: a point, a co-energy map, switching; and the network as one.

A point is one current at one gap.  The map covers the stroke.  Currents at which the rod moves are
looked up in the map and then solved for at single points, whichever model it is.
"""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any, TypeVar

import numpy as np

from tactgen.geometry.arrays import Floats
from tactgen.geometry.errors import InputError
from tactgen.geometry.formats import share
from tactgen.tmm.generator.equilibrium import PositionLoop, axial_forces, position_loop
from tactgen.tmm.reluctance.coenergy_map import CoenergyMap
from tactgen.validation.catalogue.models import MODELS
from tactgen.validation.catalogue.quantities import QUANTITIES, AnswerReadout, Need
from tactgen.validation.models.model import Estimate, Model
from tactgen.validation.models.reluctance.switching import (
    MagneticPoint,
    RestingState,
    Solver,
    SwitchingCurrents,
    position_bar,
    resting_state,
    switching_currents,
)
from tactgen.validation.scene.files import leaves
from tactgen.validation.scene.scene import Scene

T = TypeVar("T")

#: Share of the iron beyond the end of its curve that is worth a word: less is a corner or two.
WORTH_A_WORD = 0.01


class MagneticModel(Model):
    """One model of the scene's normal actuator."""

    def answer(self, need: Need) -> Any:
        """Answer that quantities of this analysis are read from."""
        if need == "rest":
            return self.rest()
        if need == "neighbours":
            return self.run("neighbours", self._neighbours)
        return self.point() if need == "magnetic_point" else self.switching()

    def warnings(self, quantities: Sequence[str]) -> tuple[str, ...]:
        """Warnings about currents without value and a short steel curve."""
        reads = {name: QUANTITIES[name].read for name in quantities}
        own = {n: read for n, read in reads.items() if isinstance(read, AnswerReadout)}
        needs: tuple[Need, ...] = ("magnetic_map", "magnetic_point", "rest")
        answers = {need: self.answer(need) for need in needs
                   if any(read.need == need for read in own.values())}  # fmt: skip
        found, spring, steel = [], self.scene.spring, self.scene.steel
        missing = [
            name for name, read in own.items()
            if read.need == "magnetic_map" and np.isnan(read.of(answers[read.need]).value)
        ]  # fmt: skip
        if missing:
            found.append(
                f"{' and '.join(missing)} {'have' if len(missing) > 1 else 'has'} no value in the "
                f"model {self.name}: with up to {answers['magnetic_map'].limit * 1e3:.3g} mA the "
                "pull does not reach the spring's force everywhere (spring.preload = "
                f"{spring.preload * 1e3:g} mN, spring.stiffness = {spring.stiffness:g} N/m); use a "
                "softer spring, a smaller gap or more coil.turns"
            )
        beyond = max((answer.beyond_table for answer in answers.values()), default=0.0)
        if beyond > WORTH_A_WORD:
            found.append(
                f"{share(beyond)} of the iron is magnetised beyond the end of steel.curve = "
                f"{steel.curve} (model {self.name}), which stops before the steel is saturated: "
                "beyond it the iron is taken for saturated; measure or continue the curve to "
                "higher B"
            )
        return tuple(found)

    @abstractmethod
    def at(self, current: float, gap: float) -> MagneticPoint:
        """Values at a current (A) and gap (m)."""

    def _solver(self) -> Solver:
        """Solver for currents and gaps in sequence."""
        return self.at

    def point(self) -> MagneticPoint:
        """Values at the scene's current and gap."""
        scene = self.scene
        return self.run("point", lambda: self.at(scene.coil.current, scene.gap))

    @abstractmethod
    def _map(self) -> CoenergyMap:
        """Co-energy map, solved anew."""

    def _neighbours(self) -> Any:
        """Field between units of the display, where the model gives it."""
        raise NotImplementedError(f"{self.name} knows one actuator")

    def map(self) -> CoenergyMap:
        """Co-energy map over the stroke."""
        return self.run("map", self._map)

    def switching(self) -> SwitchingCurrents:
        """Currents at which the rod moves."""

        def work() -> SwitchingCurrents:
            return switching_currents(self.scene.device, self.map(), self._solver())

        return self.run("switching", work)

    def rest(self) -> RestingState:
        """Where the rod rests at the scene's current."""
        scene = self.scene

        def work() -> RestingState:
            return resting_state(
                scene.device, self.map(), self.at, scene.coil.history, scene.load.normal_force
            )

        return self.run("rest", work)

    def _described(self) -> str:
        """Scene's name and the inputs of its samples, in SI units."""
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
        "difference from half as many ladder cells, in relation no less than that of the "
        "co-energy (force) or the flux linkage (incremental inductance); the network's own "
        "error is not included"
    )

    @classmethod
    def check(cls, scene: Scene) -> None:
        """Refuse a scene whose parts do not form the network's circuit."""
        from tactgen.tmm.reluctance.magnetic_circuit import check_circuit

        check_circuit(scene.device, np.array([scene.gap]))

    def at(self, current: float, gap: float) -> MagneticPoint:
        """Values at a current (A) and gap (m)."""
        from tactgen.tmm.reluctance.network import fine_and_coarse, force_error, iron_beyond_table

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
            force=Estimate(float(fine.force[0, 0]), float(force_error(fine, coarse)[0, 0])),
            flux_linkage=linkage,
            coenergy=judged("coenergy"),
            incremental_inductance=slope,
            method=self._METHOD,
            beyond_table=iron_beyond_table(device, current, gap),
        )

    def _neighbours(self) -> Any:
        from tactgen.validation.models.display import by_network

        return by_network(self.scene)

    def _map(self) -> CoenergyMap:
        from tactgen.tmm.reluctance.map_range import network_map

        # the one that where the rod rests is found by, with its device for the reader
        found = network_map(self.scene.device)
        return replace(found, samples=replace(found.samples, device=self._described()))


class CalibratedNetwork(NetworkModel):
    """A network with its known differences from the field taken off.

    Its errors say how far the field may be from it.  The map in which it is looked up where the rod
    moves stays the network's: it only says where to solve.
    """

    _CALIBRATED = "95 % of fresh random actuators, by calibration on axisymmetric fields"

    def __init__(self, network: NetworkModel) -> None:
        super().__init__(network.scene, network.stages)
        self._network = network
        self._answers: dict[str, Any] = {}

    def run(self, stage: str, work: Callable[[], T]) -> T:
        """Result of a stage, computed the first time and not stored."""
        if stage not in self._answers:
            self._answers[stage] = work()
        found: T = self._answers[stage]
        return found

    def map(self) -> CoenergyMap:
        """Co-energy map of the network."""
        return self._network.map()

    def at(self, current: float, gap: float) -> MagneticPoint:
        """Values at a current (A) and gap (m)."""
        from tactgen.tmm.reluctance.calibrated import (
            VALUES,
            State,
            corrected,
            fit_of,
            groups,
            sizes,
        )  # fmt: skip

        plain, device = super().at(current, gap), self.scene.device
        network = State(*(np.array([getattr(plain, name).value]) for name in VALUES))
        at = np.array([current]), np.array([gap])
        found, shares = corrected(device, *at, network)
        outside = fit_of(device).outside(groups(device, *at)[0])
        beyond = f"; beyond the range of the fit: {', '.join(outside)}" if outside else ""
        force, linkage, energy, slope = (
            Estimate(float(value[0]), float(error[0]))
            for value, error in zip(found, shares * sizes(found, *at), strict=True)
        )
        return replace(
            plain, method=f"{self._CALIBRATED}{beyond}", force=force, flux_linkage=linkage,
            coenergy=energy, incremental_inductance=slope,
        )  # fmt: skip


#: Currents of a loop that nobody chose, and how far it goes beyond what moves the rod.
_POINTS, _BEYOND = 121, 1.25


@dataclass(frozen=True)
class RodLoop:
    """The loop by one model of the normal actuator."""

    model: str  #:
    loop: PositionLoop  #:
    #: (c,) Error of the map's pull over the axial stiffness (m)
    rising_bar: Floats
    falling_bar: Floats
    #: Where the rod leaves and comes back; None where a finger presses the tip, of which these say
    #: nothing
    switching: SwitchingCurrents | None


def rod_loop(model: MagneticModel, currents: Floats | None = None) -> RodLoop:
    """Loop of a model over currents (c,) in A, by default up to the switching range.

    Raises InputError if the rod rests nowhere, or the model's map does not reach so high a current.
    """
    scene, pull = model.scene, model.map()
    pressed = scene.load.normal_force
    switching = None if pressed else model.switching()
    if currents is None:
        currents = _currents(switching, pull.current_limit)
    elif currents.max() > pull.current_limit:
        raise InputError(
            f"the map of the model {model.name} ends at {1e3 * pull.current_limit:.4g} mA, below "
            f"{1e3 * currents.max():.4g} mA; ask for less, or set coil.current so high"
        )
    forces = axial_forces(scene.device, pull, pressed)
    loop = position_loop(forces, currents)
    rising, falling = (
        np.array([position_bar(forces, pull, i, p) for i, p in zip(currents, way, strict=True)])
        for way in (loop.rising, loop.falling)
    )
    return RodLoop(model.name, loop, rising, falling, switching)


def _currents(switching: SwitchingCurrents | None, limit: float) -> Floats:
    largest = limit
    if switching is not None and np.isfinite(switching.pull_in.value):
        largest = min(limit, _BEYOND * switching.pull_in.value)
    return np.linspace(0.0, largest, _POINTS)
