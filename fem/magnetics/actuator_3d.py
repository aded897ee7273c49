"""The reconstructed normal actuator by both potentials in 3D: flux, co-energy, force, error bars.

The winding's source field is vertical, 1/length inside the winding, falling linearly to 0
across it, and 0 above and below: its curl is the winding's uniform current.  In the rod it
is the gradient of what linear elements hold; in the air around and in the sleeve it is
zero, so the sleeve may be moved.  The force is taken on the sleeve, upwards: the pull.

Every value is the mean of the two potentials'.  The co-energies enclose the exact one, so
half their difference is a bound; for flux and force it is an estimate, which is not let
vanish where the co-energies still differ.  (Virtual work is no further witness of the force:
its nodes follow the eggshell's weight, which makes the two one number.)
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tactgen.fem.magnetics.axisymmetric import FieldErrors
from tactgen.fem.magnetics.axisymmetric_space import share_beyond_table
from tactgen.fem.magnetics.force_3d import MotionWeight, eggshell_force, harmonic_weight
from tactgen.fem.magnetics.problem_3d import (
    MagneticField,
    MagneticSolid,
    ScalarPotential,
    SourceField,
    VectorPotential,
    sample,
)
from tactgen.geometry.arrays import Floats
from tactgen.geometry.device.parameters import Device
from tactgen.geometry.device.steel_table import magnetisation_curve
from tactgen.geometry.meshing.mesh import Mesh
from tactgen.geometry.reluctance.section_grid import actuator_regions
from tactgen.geometry.reluctance.sector_tets import Sector, sector_mesh
from tactgen.geometry.reluctance.tets import ActuatorMeshing, actuator_tets
from tactgen.geometry.store.values import storable

#: Where the eggshell's weight falls from 1 to 0: over all air, or next to the sleeve only.
SHELLS = (("near", "air"), ("near",))
_UP = np.array([0.0, 0.0, 1.0])
#: Relative step of current for the incremental inductance, over which the corners of the
#: steel's dH/dB are averaged; at no current, the step in ampere-turns: dH/dB has no corner
#: there, and changes the inductance by less than 1e-4 up to this (by 2.5 % up to one).
_STEP = 0.01
_FIRST_STEP = 1e-3
#: Margin on the error of the force: its mean is always low, beside an independent code by up to
#: 0.95 of the error without it.
_MARGIN = 1.25
#: Scatter of the incremental inductance in full saturation, as in
#: :mod:`fem.magnetics.axisymmetric`.
_SCATTER = 0.02


@storable
@dataclass(frozen=True)
class SolidValues:
    """Solution by one potential; fields as in :class:`SolidPoint`, force by shell."""

    flux_linkage: float
    coenergy: float
    forces: tuple[float, ...]
    incremental_inductance: float
    unknowns: int
    iterations: int
    beyond_table: float


@storable
@dataclass(frozen=True)
class SolidPoint:
    """The actuator at one current (A) and gap (m), by each potential."""

    current: float
    gap: float
    vector: SolidValues
    scalar: SolidValues

    @property
    def flux_linkage(self) -> float:
        """Flux linkage λ (Wb)."""
        return 0.5 * (self.vector.flux_linkage + self.scalar.flux_linkage)

    @property
    def coenergy(self) -> float:
        """Co-energy W' = iλ − W (J)."""
        return 0.5 * (self.vector.coenergy + self.scalar.coenergy)

    @property
    def force(self) -> float:
        """Pull −∂W'/∂g (N) by the wider shell; positive closes the gap."""
        return 0.5 * (self.vector.forces[0] + self.scalar.forces[0])

    @property
    def incremental_inductance(self) -> float:
        """∂λ/∂i (H)."""
        return 0.5 * (self.vector.incremental_inductance + self.scalar.incremental_inductance)

    @property
    def beyond_table(self) -> float:
        """Share of the iron beyond a curve that ends early, by the vector potential's B."""
        return self.vector.beyond_table

    @property
    def errors(self) -> FieldErrors:
        """Estimated errors against the exact field of the same model.

        Half the difference of the potentials; never less than the co-energy's, relatively.  Of
        the force that is too much: its two values mostly lie on either side of the true one, and
        their mean is several times nearer to it.  It counts with the co-energy's share, or with
        what half its difference has beyond that, as in deep saturation, and no less than what two
        shells differ by; all with a margin.  These do not add up: one field that is too coarse is
        the cause of all.  The incremental inductance has the scatter of dH/dB besides.
        """
        a, b = self.vector, self.scalar
        width = abs(a.coenergy - b.coenergy) / (a.coenergy + b.coenergy) if self.current else 0.0
        shells = max(float(np.ptp(by.forces)) for by in (a, b))
        of_energy = width * abs(self.force)
        linear = self.incremental_inductance * self.current
        saturation = abs(self.flux_linkage / linear - 1.0) if self.current else 0.0
        slope = 0.5 * abs(a.incremental_inductance - b.incremental_inductance)
        return FieldErrors(
            flux_linkage=max(
                0.5 * abs(a.flux_linkage - b.flux_linkage), width * abs(self.flux_linkage)
            ),
            coenergy=0.5 * abs(a.coenergy - b.coenergy),
            force=_MARGIN
            * max(of_energy, 0.5 * abs(a.forces[0] - b.forces[0]) - of_energy, shells),
            incremental_inductance=max(slope, width * self.incremental_inductance)
            + _SCATTER * min(1.0, saturation) * self.incremental_inductance,
        )


def actuator_problem(device: Device, gap: float, mesh: Mesh, copies: int) -> MagneticSolid:
    """Field problem on a mesh with :data:`geometry.reluctance.tets.REGIONS`."""
    steel = magnetisation_curve(device.steel)
    return MagneticSolid(
        mesh, {"rod": steel, "sleeve": steel}, winding_source(device, gap), copies=copies
    )


def winding_source(device: Device, gap: float) -> SourceField:
    """T0 of the winding (A/m) for one ampere-turn; z = 0 is the sleeve's top face."""
    coil = next(part for part in actuator_regions(device, gap) if part.turns)
    (inner, outer), (low, high) = coil.radii, coil.heights

    def source(points: Floats) -> Floats:
        r, z = np.hypot(points[..., 0], points[..., 1]), points[..., 2]
        ramp = np.clip((outer - r) / (outer - inner), 0.0, 1.0) / (high - low)
        field = np.zeros(points.shape)
        field[..., 2] = np.where((z > low) & (z < high), ramp, 0.0)
        return field

    return source


def solve_solid(device: Device, current: float, gap: float, sector: Sector) -> SolidPoint:
    """Solve the actuator's field in 3D at one current (A) and gap (m).

    Raises InputError if the parts do not fit at this gap, SolverError if a field does not converge.
    """
    return solve_row(device, gap, np.array([current]), sector)[0]


def solve_cad(device: Device, current: float, gap: float, meshing: ActuatorMeshing) -> SolidPoint:
    """Solve the same on the CAD solids in a box of air, meshed by fTetWild, slot and all.

    Not in the bars is where the air ends: at the default third of the axisymmetric field's distance
    that has 0.06 % more force on the paper's device.

    Raises InputError if the parts do not fit at this gap, MeshError if no mesh passes its checks,
    SolverError if a field does not converge.
    """
    actuator_regions(device, gap)  # refuses before anything is built
    mesh = actuator_tets(device, gap, meshing)
    problem = actuator_problem(device, gap, mesh, 4)
    return solve_problem(problem, gap, np.array([current]), device.coil.turns)[0]


def solve_row(
    device: Device, gap: float, currents: Floats, sector: Sector
) -> tuple[SolidPoint, ...]:
    """Solve the swept sector at one gap (m) for all currents (c,) (A), each from the one before.

    Raises as :func:`solve_solid`.
    """
    problem = actuator_problem(device, gap, sector_mesh(device, gap, sector), sector.copies)
    return solve_problem(problem, gap, currents, device.coil.turns)


def solve_problem(
    problem: MagneticSolid, gap: float, currents: Floats, turns: float
) -> tuple[SolidPoint, ...]:
    """Solve a field problem of the actuator by both potentials, as :func:`solve_row`."""
    solid = sample(problem)
    weights = tuple(harmonic_weight(solid, ("sleeve",), shell) for shell in SHELLS)

    def along(potential: VectorPotential | ScalarPotential) -> list[SolidValues]:
        field, found = None, []
        for current in currents:
            field = potential.solve(float(current) * turns, start=field)
            found.append(_values(potential, field, weights, turns))
        return found

    # the vector potential's matrices are gone before the scalar's are made
    pairs = zip(along(VectorPotential(solid)), along(ScalarPotential(solid)), strict=True)
    return tuple(
        SolidPoint(float(current), gap, vector, scalar)
        for current, (vector, scalar) in zip(currents, pairs, strict=True)
    )


def _values(
    potential: VectorPotential | ScalarPotential,
    field: MagneticField,
    weights: tuple[MotionWeight, ...],
    turns: float,
) -> SolidValues:
    solid = field.solid
    return SolidValues(
        flux_linkage=turns * field.flux_linkage,
        coenergy=field.coenergy,
        forces=tuple(eggshell_force(field, weight, _UP) for weight in weights),
        incremental_inductance=turns**2 * _flux_per_current(potential, field),
        unknowns=potential.size,
        iterations=field.iterations,
        beyond_table=share_beyond_table(solid.iron, field.flux_density, solid.weights),
    )


def _flux_per_current(potential: VectorPotential | ScalarPotential, field: MagneticField) -> float:
    """Change of the flux per turn with the ampere-turns (H), by a central difference."""
    step = _STEP * abs(field.current) or _FIRST_STEP
    ahead, behind = (
        potential.solve(field.current + change, start=field).flux_linkage
        for change in (step, -step)
    )
    return (ahead - behind) / (2.0 * step)
