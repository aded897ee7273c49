"""The pull of one actuator in an endless square array of equal ones, by both potentials.

All are driven with one current.  With the same polarity everywhere the flux does not cross the
cell's wall; with alternating polarity, as on a chessboard, the wall is crossed at right angles.
Both on one mesh, so that what the mesh does to them is nearly one error.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from tactgen.fem.magnetics.actuator_3d import winding_source
from tactgen.fem.magnetics.force_3d import MotionWeight, eggshell_force, harmonic_weight
from tactgen.fem.magnetics.problem_3d import (
    MagneticSolid,
    SampledSolid,
    ScalarPotential,
    SourceField,
    VectorPotential,
    sample,
)
from tactgen.geometry.arrays import Floats
from tactgen.geometry.device.parameters import Device
from tactgen.geometry.device.steel_table import magnetisation_curve
from tactgen.geometry.reluctance.sector_tets import (
    COPIES,
    COUNTS,
    PLACES,
    UNITS,
    Cell,
    cell_mesh,
    nine_mesh,
    part_of,
)
from tactgen.geometry.reluctance.tets import PARTS
from tactgen.geometry.store.values import storable

#: The cell's square wall.
_WALL = "mantle"
_UP = np.array([0.0, 0.0, 1.0])


@storable
@dataclass(frozen=True)
class ArrayForces:
    """Pulls (N) of one actuator in the array, each by the vector and the scalar potential."""

    #: (float, float) All polarities equal, or neighbours opposite
    same: tuple[float, float]
    alternating: tuple[float, float]


def array_forces(
    device: Device, current: float, gap: float, pitch: float, cell: Cell | None = None
) -> ArrayForces:
    """Pull with all actuators of a square array driven; current in A, lengths in m.

    Raises InputError if the parts do not fit at this gap, or not into the pitch, SolverError if a
    field does not converge.
    """
    mesh = cell_mesh(device, gap, pitch, cell or Cell())
    steel = magnetisation_curve(device.steel)
    turns = current * device.coil.turns

    def pulls(walls: tuple[str, ...]) -> tuple[float, float]:
        problem = MagneticSolid(
            mesh, {"rod": steel, "sleeve": steel}, winding_source(device, gap), walls, COPIES
        )
        solid = sample(problem)
        weight = harmonic_weight(solid, ("sleeve",), ("near", "air"))
        vector = eggshell_force(VectorPotential(solid).solve(turns), weight, _UP)
        return vector, eggshell_force(ScalarPotential(solid).solve(turns), weight, _UP)

    return ArrayForces(same=pulls(()), alternating=pulls((_WALL,)))


#: The way in which a rod goes that closes its gap.
_DOWN = np.array([0.0, 0.0, -1.0])
#: Air around a rod with its winding.
SHELL = ("near", "air")
#: How finely each of the nine is divided.
_CELL = Cell(refinement=0.5, layers=2)


@storable
@dataclass(frozen=True)
class NineForces:
    """Pulls (N) on one rod of each kind, each by the vector and the scalar potential.

    A pull is what drives the rod with its winding towards its sleeve.  The sleeve feels another
    one, since neighbours pull on either.
    """

    #: (float, float) Of the middle unit, of each of the four beside it, of each of the four on the
    #: diagonals
    middle: tuple[float, float]
    beside: tuple[float, float]
    diagonal: tuple[float, float]
    #: (float, float) Sum of the forces on all parts of the nine (N), which by Newton's third law is
    #: none
    unbalanced: tuple[float, float]


def nine_forces(
    device: Device,
    currents: Sequence[Mapping[str, float]],
    gap: float,
    pitch: float,
    cell: Cell | None = None,
) -> tuple[NineForces, ...]:
    """Pulls for each choice of currents (A), which are by unit of `UNITS`; lengths in m.

    Raises InputError if the parts do not fit at this gap, or not into the pitch, SolverError if a
    field does not converge.
    """
    solids = nine_solids(device, currents, gap, pitch, cell or _CELL)
    weights = motion_weights(solids[0])
    pulls = [
        [vertical_forces(potential(solid), weights) for solid in solids]
        for potential in (VectorPotential, ScalarPotential)
    ]
    return tuple(_read(vector, scalar) for vector, scalar in zip(*pulls, strict=True))


def _read(vector: dict[str, float], scalar: dict[str, float]) -> NineForces:
    rods = {unit: (vector[unit] / COUNTS[unit], scalar[unit] / COUNTS[unit]) for unit in UNITS}
    return NineForces(**rods, unbalanced=(sum(vector.values()), sum(scalar.values())))


def nine_solids(
    device: Device, currents: Sequence[Mapping[str, float]], gap: float, pitch: float, cell: Cell
) -> list[SampledSolid]:
    """Eighth of nine units with each choice of currents (A) as one ampere-turn.

    Raises as :func:`nine_forces`.
    """
    steel = magnetisation_curve(device.steel)
    iron = {part_of(unit, part): steel for unit in UNITS for part in ("rod", "sleeve")}
    mesh = nine_mesh(device, gap, pitch, cell)
    none = sample(MagneticSolid(mesh, iron, np.zeros_like, copies=COPIES))
    own = winding_source(device, gap)
    return [
        replace(none, source=device.coil.turns * _placed(own, by, pitch)(none.points))
        for by in currents
    ]


def _placed(own: SourceField, currents: Mapping[str, float], pitch: float) -> SourceField:
    """T0 (A/m) per turn of windings with these currents (A), each at its unit's place."""

    def source(points: Floats) -> Floats:
        field = np.zeros(points.shape)
        for unit, current in currents.items():
            field += current * own(points - pitch * np.array([*PLACES[unit], 0.0]))
        return field

    return source


def motion_weights(solid: SampledSolid) -> dict[str, MotionWeight]:
    """Weights of all bodies: by unit its rod with the winding, and its sleeve."""
    weights = {}
    for unit in UNITS:
        rod, coil, sleeve = (part_of(unit, part) for part in PARTS)
        weights[unit] = harmonic_weight(solid, (rod, coil), SHELL)
        weights[sleeve] = harmonic_weight(solid, (sleeve,), SHELL)
    return weights


def vertical_forces(
    potential: VectorPotential | ScalarPotential, weights: Mapping[str, MotionWeight]
) -> dict[str, float]:
    """Forces (N) downwards at the stated currents, of all units of a kind together."""
    field = potential.solve(1.0)
    return {name: eggshell_force(field, weight, _DOWN) for name, weight in weights.items()}
