"""The models of the normal actuator behind one interface: a point, and a co-energy map.

A point is the scene's current at the scene's gap.  The map covers the stroke; pull-in and
holding follow from it by :mod:`tmm.normal_actuator`, whichever model it came from.
"""

from __future__ import annotations

import contextlib
from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from geometry.arrays import Floats
from geometry.errors import InputError
from geometry.mesh_cache import cache_folder
from tmm.coenergy import CoenergyMap
from tmm.coenergy_file import read_map, write_map
from tmm.normal_actuator import Switching, map_grid, switching
from validation.scene import Scene
from validation.stages import Stages

if TYPE_CHECKING:
    from fem.reluctance_field import FieldPoint
    from fem.reluctance_solid import SolidPoint


@dataclass(frozen=True)
class Measured:
    """A value with its numerical error bar, both in the same SI unit."""

    value: float
    bar: float


@dataclass(frozen=True)
class MagneticPoint:
    """The actuator at one current and gap: SI units, pull positive when it closes the gap."""

    force: Measured
    flux_linkage: Measured
    coenergy: Measured
    incremental_inductance: Measured
    method: str

    def inductance(self, current: float) -> Measured:
        """Return the apparent inductance λ/i (H), its limit ∂λ/∂i at zero current."""
        if current == 0.0:
            return self.incremental_inductance
        return Measured(self.flux_linkage.value / current, self.flux_linkage.bar / abs(current))


class MagneticModel(ABC):
    """One model of the scene's normal actuator; results are computed at most once."""

    name: str

    def __init__(self, scene: Scene, stages: Stages) -> None:
        self.scene, self.stages = scene, stages

    @abstractmethod
    def point(self) -> MagneticPoint:
        """Return the values at the scene's current and gap."""

    @abstractmethod
    def map(self) -> CoenergyMap:
        """Return the co-energy map over the stroke."""

    def switching(self) -> Switching:
        """Return the currents at which the rod moves."""
        return switching(self.scene.device, self.map())


class NetworkModel(MagneticModel):
    """The lumped reluctance network."""

    name = "network"
    _METHOD = "difference from half as many ladder cells; the network's own error is not included"

    def point(self) -> MagneticPoint:
        """Return the values at the scene's current and gap."""
        return self.stages.run("network.point", self._point)

    def map(self) -> CoenergyMap:
        """Return the co-energy map over the stroke."""

        def work() -> CoenergyMap:
            from tmm.coenergy_fit import fit
            from tmm.reluctance_network import network_samples

            device = self.scene.device
            return fit(network_samples(device, *map_grid(device)))

        return self.stages.run("network.map", work)

    def _point(self) -> MagneticPoint:
        from tmm.reluctance_circuit import CELLS
        from tmm.reluctance_network import network_samples

        scene = self.scene
        at = np.array([scene.coil.current]), np.array([scene.gap])
        fine, coarse = (
            network_samples(scene.device, *at, cells=cells) for cells in (CELLS, CELLS // 2)
        )

        def judged(name: str) -> Measured:
            value, other = (float(getattr(s, name)[0, 0]) for s in (fine, coarse))
            return Measured(value, abs(value - other))

        return MagneticPoint(
            force=judged("force"),
            flux_linkage=judged("flux_linkage"),
            coenergy=judged("coenergy"),
            incremental_inductance=judged("incremental_inductance"),
            method=self._METHOD,
        )


class AxisymmetricModel(MagneticModel):
    """The nonlinear field in the half section."""

    name = "axisymmetric"
    _METHOD = (
        "change from the lower polynomial order, truncation of the air, and for the force the "
        "difference between virtual work and the stress in the air"
    )

    def field(self) -> FieldPoint:
        """Return the field at the scene's current and gap."""

        def work() -> FieldPoint:
            from fem.reluctance_field import solve_point

            refinement = _coarsest(_REFINEMENTS, self.scene.accuracy)
            return solve_point(self.scene.device, refinement=refinement)

        return self.stages.run("axisymmetric.point", work)

    def point(self) -> MagneticPoint:
        """Return the values at the scene's current and gap."""
        return _judged(self.field(), self._METHOD)

    def map(self) -> CoenergyMap:
        """Return the co-energy map over the stroke, kept on disk between runs."""

        def work() -> CoenergyMap:
            file = cache_folder() / f"coenergy-{self.stages.keys['axisymmetric.map']}.nc"
            with contextlib.suppress(InputError):
                return read_map(file)
            found = self._map()
            with contextlib.suppress(InputError, OSError):
                file.parent.mkdir(parents=True, exist_ok=True)
                write_map(file, found)
            return found

        return self.stages.run("axisymmetric.map", work)

    def _map(self) -> CoenergyMap:
        from fem.reluctance_field import solve_map

        device = self.scene.device
        currents, gaps = map_grid(device)
        rows = solve_map(device, gaps.tolist(), currents.tolist(), order=_MAP_ORDER)

        def table(read: Callable[[FieldPoint], float]) -> Floats:
            return np.array([[read(point) for point in row] for row in rows]).T

        return CoenergyMap.from_samples(
            currents,
            gaps,
            flux_linkage=table(lambda p: p.flux_linkage),
            force=table(lambda p: p.force),
            coenergy=table(lambda p: p.coenergy),
            incremental_inductance=table(lambda p: p.incremental_inductance),
            force_error=table(lambda p: p.errors.force),
            model=self.name,
            device=f"scene {self.scene.name}",
        )


class Magnetic3dModel(MagneticModel):
    """The nonlinear field by both potentials in 3D.

    In a sector of the turned device, or, with mesh.kind = "tetwild", in a quarter of the CAD
    solids, which have the slot for the tab if the bimorph stands on the rod.
    """

    name = "magnetic3d"
    _METHOD = (
        "half the difference of vector and scalar potential; for the force also what two shells "
        "in the air differ by"
    )

    def field(self) -> SolidPoint:
        """Return the field at the scene's current and gap."""

        def work() -> SolidPoint:
            from fem.reluctance_solid import solve_cad, solve_solid
            from fem.reluctance_swept import Sector
            from geometry.actuator_tets import ActuatorMeshing

            scene = self.scene
            if scene.mesh.kind == "tetwild":
                slot = scene.support.kind == "rod"
                meshing = ActuatorMeshing(slot=slot, time_limit=scene.mesh.time_limit)
                return solve_cad(scene.device, meshing=meshing)
            refinement = _coarsest(_SECTOR_REFINEMENTS, scene.accuracy)
            return solve_solid(scene.device, sector=Sector(refinement))

        return self.stages.run("magnetic3d.point", work)

    def point(self) -> MagneticPoint:
        """Return the values at the scene's current and gap."""
        return _judged(self.field(), self._METHOD)

    def map(self) -> CoenergyMap:
        """Refuse, since a map takes a hundred points and more.

        Raises
        ------
        InputError
            Always; the catalogue keeps plans from asking.
        """
        raise InputError(
            "model magnetic3d gives single points only; take pull_in_current, holding_current and "
            "maps from model network or axisymmetric"
        )


def _judged(found: FieldPoint | SolidPoint, method: str) -> MagneticPoint:
    def judged(name: str) -> Measured:
        return Measured(getattr(found, name), getattr(found.errors, name))

    return MagneticPoint(
        force=judged("force"),
        flux_linkage=judged("flux_linkage"),
        coenergy=judged("coenergy"),
        incremental_inductance=judged("incremental_inductance"),
        method=method,
    )


#: Accuracy in force that a fineness of the grid reaches with its error bar, coarsest first.
_REFINEMENTS = ((2e-3, 1.0), (5e-4, 1.5), (0.0, 2.0))
#: The same of the 3D model's sector.
_SECTOR_REFINEMENTS = ((2.5e-2, 0.7), (1.3e-2, 1.0), (0.0, 1.4))


def _coarsest(refinements: tuple[tuple[float, float], ...], accuracy: float) -> float:
    """Return the coarsest grid whose force bar was found within the accuracy wanted."""
    return next(fineness for bar, fineness in refinements if accuracy >= bar)


#: Polynomial order of a map's samples: their error is then below that of interpolating them.
_MAP_ORDER = 3

_CLASSES: dict[str, type[MagneticModel]] = {
    c.name: c for c in (NetworkModel, AxisymmetricModel, Magnetic3dModel)
}


def read_magnetic(name: str, model: MagneticModel) -> tuple[Measured, str]:
    """Return a quantity of the catalogue, and how its error bar comes about."""
    if name in ("pull_in_current", "holding_current"):
        return _switching_current(name, model)
    point = model.point()
    if name == "inductance":
        return point.inductance(model.scene.coil.current), point.method
    value: Measured = getattr(point, "force" if name == "magnetic_force" else name)
    return value, point.method


def _switching_current(name: str, model: MagneticModel) -> tuple[Measured, str]:
    """Return the current, and the map's force error over the slope of the force with it."""
    device = model.scene.device
    found, pull = model.switching(), model.map()
    current = found.pull_in if name == "pull_in_current" else found.holding
    gap = device.gap if name == "pull_in_current" else device.spring.stop_gap
    below, force = (float(pull.force(share * current, gap)) for share in (1.0 - _STEP, 1.0))
    bar = pull.force_bar(current, gap) * _STEP * current / (force - below)
    return Measured(current, bar), "the map's error in force, over the force's slope with current"


#: Relative step of current for the slope of the force.
_STEP = 1e-3


def make_magnetic_model(name: str, scene: Scene, stages: Stages) -> MagneticModel:
    """Return the named model of a scene's normal actuator."""
    return _CLASSES[name](scene, stages)
