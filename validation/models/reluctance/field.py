"""The models of the normal actuator that solve the field: in the half section, and in 3D."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np

from tactgen.geometry.arrays import Floats
from tactgen.geometry.device.parameters import Device
from tactgen.geometry.errors import CoarseGridError, InputError
from tactgen.geometry.store.store import cached_result
from tactgen.tmm.reluctance.coenergy_fit import fit
from tactgen.tmm.reluctance.coenergy_map import CoenergyMap, Samples
from tactgen.validation.catalogue.models import MODELS, STROKE
from tactgen.validation.models.display import by_field  # its result may be in the store
from tactgen.validation.models.model import Estimate
from tactgen.validation.models.reluctance.model import MagneticModel
from tactgen.validation.models.reluctance.switching import MagneticPoint, Solver
from tactgen.validation.scene.inputs import values_read
from tactgen.validation.scene.scene import Scene

if TYPE_CHECKING:
    from tactgen.fem.magnetics.actuator_3d import SolidPoint
    from tactgen.fem.magnetics.axisymmetric import FieldPoint
    from tactgen.fem.magnetics.axisymmetric_field import MagneticField

#: How the half section's error bars come about.
_METHOD = (
    "change from the lower polynomial order, for the force no less than the difference between "
    "virtual work and the stress in the air; and truncation of the air"
)

_Found = TypeVar("_Found", "FieldPoint", "SolidPoint")

#: Accuracy in force that a fineness of the grid reaches with its error bar, coarsest first.
REFINEMENTS = ((2e-3, 1.0), (5e-4, 1.5), (0.0, 2.0))
#: The same of the 3D model's sector.
_SECTOR_REFINEMENTS = ((1.3e-2, 0.7), (6e-3, 1.0), (0.0, 1.4))
#: Polynomial order of a field map's samples: their error is then below that of interpolating them.
MAP_ORDER = 3
#: As what they are kept.
SAMPLES = "axisymmetric.samples"
#: What says how far a map must reach, and nothing else of its samples.
MAP_RANGE = ("coil.current", "gap", *STROKE)
#: Currents and gaps of a map in 3D, where each costs a second or more, and its fineness.
_SOLID_MAP = (8, 6)
_SOLID_MAP_REFINEMENT = 0.7


class _FieldModel(MagneticModel):
    """A model that solves the field."""

    def _samples(
        self,
        currents: Floats,
        gaps: Floats,
        rows: Sequence[Sequence[FieldPoint]] | Sequence[Sequence[SolidPoint]],
    ) -> Samples:
        """Rows of points, one row for each gap, as samples of a map."""

        def table(read: Callable[[FieldPoint | SolidPoint], float]) -> Floats:
            return np.array([[read(point) for point in row] for row in rows]).T

        return Samples(
            currents,
            gaps,
            flux_linkage=table(lambda p: p.flux_linkage),
            force=table(lambda p: p.force),
            coenergy=table(lambda p: p.coenergy),
            incremental_inductance=table(lambda p: p.incremental_inductance),
            force_error=table(lambda p: p.errors.force),
            model=self.name,
        )

    def _fitted(self, samples: Samples) -> CoenergyMap:
        return fit(replace(samples, device=self._described()))

    def _geometry(self) -> dict[str, Any]:
        """Inputs of the field besides current and gap, for the store."""
        own = MODELS[self.name].stages["map"]
        return values_read(self.scene, (key for key in own if key not in MAP_RANGE))


class AxisymmetricModel(_FieldModel):
    """The nonlinear field in the half section."""

    name = "axisymmetric"

    def at(self, current: float, gap: float) -> MagneticPoint:
        """Values at a current (A) and gap (m)."""
        return axisymmetric_point(self._solved(current, gap))

    def _solver(self) -> Solver:
        from tactgen.fem.magnetics.axisymmetric import FieldContinuation

        device = self.scene.device
        walk = FieldContinuation(finenesses(REFINEMENTS, self.scene.accuracy), self.scene.accuracy)

        def at(current: float, gap: float) -> MagneticPoint:
            place = nearness(device, current, gap)
            return axisymmetric_point(walk.at(device, current, gap, place))

        return at

    def field(self) -> MagneticField:
        """Field itself at the scene's current and gap."""
        found = self._solved(self.scene.coil.current, self.scene.gap).solution
        assert found is not None
        return found

    def _solved(self, current: float, gap: float) -> FieldPoint:
        from tactgen.fem.magnetics.axisymmetric import solve_point

        device, accuracy = self.scene.device, self.scene.accuracy
        return _fine_enough(
            REFINEMENTS,
            accuracy,
            lambda fineness: solve_point(device, current, gap, refinement=fineness),
        )

    def _map(self) -> CoenergyMap:
        from tactgen.tmm.reluctance.map_range import map_grid

        device = self.scene.device
        currents, gaps = map_grid(device, shared=True)

        def work() -> Samples:
            return self._samples(currents, gaps, field_rows(device, gaps, currents))

        inputs = self._geometry(), currents.tolist(), gaps.tolist()
        code, announce = self.code(), self.stages.announce
        return self._fitted(cached_result(SAMPLES, inputs, code, work, announce=announce))


class Magnetic3dModel(_FieldModel):
    """The nonlinear field by both potentials in 3D.

    In a sector of the turned device, or, with mesh.kind = "tetwild", in a quarter of the CAD
    solids, which have the slot for the tab if the bimorph stands on the rod.
    """

    name = "magnetic3d"
    _METHOD = (
        "half the difference of vector and scalar potential, relatively no less than the "
        "co-energy's; the force's is the co-energy's, or what half its difference has beyond "
        "that, or what two shells in the air differ by, whichever is largest"
    )

    def at(self, current: float, gap: float) -> MagneticPoint:
        """Values at a current (A) and gap (m)."""
        return _judged(self._solved(current, gap), self._METHOD)

    def _solved(self, current: float, gap: float) -> SolidPoint:
        from tactgen.fem.magnetics.actuator_3d import solve_cad, solve_solid
        from tactgen.geometry.reluctance.sector_tets import Sector
        from tactgen.geometry.reluctance.tets import ActuatorMeshing

        scene = self.scene
        if scene.mesh.kind == "tetwild":
            slot = scene.support.kind == "rod"
            meshing = ActuatorMeshing(slot=slot, time_limit=scene.mesh.time_limit)
            return solve_cad(scene.device, current, gap, meshing)
        return _fine_enough(
            _SECTOR_REFINEMENTS,
            scene.accuracy,
            lambda fineness: solve_solid(scene.device, current, gap, Sector(fineness)),
        )

    def _neighbours(self) -> Any:
        return by_field(self.scene)

    def _map(self) -> CoenergyMap:
        """Map, solved gap by gap: an interrupted one goes on where it was."""
        from tactgen.fem.magnetics.actuator_3d import solve_row
        from tactgen.geometry.reluctance.sector_tets import Sector
        from tactgen.tmm.reluctance.map_range import map_grid

        check_solid_map(self.scene)
        device, announce = self.scene.device, self.stages.announce
        currents, gaps = map_grid(device, *_SOLID_MAP, shared=True)
        geometry = self._geometry()
        sector = Sector(_SOLID_MAP_REFINEMENT)
        rows = []
        for number, gap in enumerate(gaps.tolist(), start=1):
            announce(f"magnetic3d.map, gap {number} of {gaps.size}")
            rows.append(
                cached_result(
                    "magnetic3d.row",
                    (geometry, currents.tolist(), gap),
                    self.code(),
                    partial(solve_row, device, gap, currents, sector),
                    announce=announce,
                )
            )
        return self._fitted(self._samples(currents, gaps, rows))


def check_solid_map(scene: Scene) -> None:
    """Refuse a map in 3D on a mesh of which each gap needs its own, at minutes apiece.

    Raises InputError with what to use instead.
    """
    if scene.mesh.kind == "tetwild":
        raise InputError(
            "mesh.kind = tetwild gives magnetic3d single points only, since each of a map's "
            "takes minutes; leave mesh.kind out to map the swept sector"
        )


def field_rows(
    device: Device, gaps: Floats, currents: Floats
) -> tuple[tuple[FieldPoint, ...], ...]:
    """Points of the half section at gaps (m) and currents (A), one row for each gap.

    Where the order of maps resolves too little, of points a higher one is taken.
    """
    from tactgen.fem.magnetics.axisymmetric import solve_map

    try:
        return solve_map(device, gaps.tolist(), currents.tolist(), order=MAP_ORDER)
    except CoarseGridError:
        return solve_map(device, gaps.tolist(), currents.tolist())


def axisymmetric_point(found: FieldPoint) -> MagneticPoint:
    """Axisymmetric field point in the form of any model."""
    return replace(_judged(found, _METHOD), force_by_stress=found.force_eggshell)


def finenesses(refinements: tuple[tuple[float, float], ...], accuracy: float) -> tuple[float, ...]:
    """Finenesses that may be wanted, coarsest first.

    The first is the one that was found to be enough at the paper's point.
    """
    first = next(n for n, (bar, _) in enumerate(refinements) if accuracy >= bar)
    return tuple(fineness for _, fineness in refinements[first:])


def nearness(device: Device, current: float, gap: float) -> Floats:
    """Place (2,) of a current and gap: in how far it is near, fields differ little."""
    return np.array([current / abs(device.coil.current or 1.0), math.log(gap / device.gap)])


def _judged(found: FieldPoint | SolidPoint, method: str) -> MagneticPoint:
    def judged(name: str) -> Estimate:
        return Estimate(getattr(found, name), getattr(found.errors, name))

    return MagneticPoint(
        current=found.current,
        gap=found.gap,
        force=judged("force"),
        flux_linkage=judged("flux_linkage"),
        coenergy=judged("coenergy"),
        incremental_inductance=judged("incremental_inductance"),
        method=method,
        beyond_table=found.beyond_table,
    )


def _fine_enough(
    refinements: tuple[tuple[float, float], ...], accuracy: float, solve: Callable[[float], _Found]
) -> _Found:
    """Point of the coarsest grid whose force bar is within the accuracy wanted.

    Where the first is not enough the next is tried, up to the finest.
    """
    *coarser, finest = finenesses(refinements, accuracy)
    for fineness in coarser:
        with suppress(CoarseGridError):
            found = solve(fineness)
            if found.errors.force <= accuracy * abs(found.force):
                return found
    return solve(finest)
