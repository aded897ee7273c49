"""The pull of one actuator in an endless square array of equal ones, by both potentials.

All are driven with one current.  With the same polarity everywhere the flux does not cross the
cell's wall; with alternating polarity, as on a chessboard, the wall is crossed at right angles.
Both on one mesh, so that what the mesh does to them is nearly one error.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tactgen.fem.reluctance.three_d.actuator import winding_source
from tactgen.fem.reluctance.three_d.force import eggshell_force, harmonic_weight
from tactgen.fem.reluctance.three_d.problem import MagneticSolid, sample
from tactgen.fem.reluctance.three_d.scalar_potential import ScalarPotential
from tactgen.fem.reluctance.three_d.vector_potential import VectorPotential
from tactgen.geometry.device.parameters import Device
from tactgen.geometry.device.steel_table import magnetisation_curve
from tactgen.geometry.reluctance.sector_tets import COPIES, Cell, cell_mesh
from tactgen.geometry.store.values import storable

#: The cell's square wall.
_WALL = "mantle"
_UP = np.array([0.0, 0.0, 1.0])


@storable
@dataclass(frozen=True)
class ArrayForces:
    """Pulls (N) of one actuator in the array, each by the vector and the scalar potential.

    Attributes
    ----------
    same, alternating : (float, float)
        All polarities equal, or neighbours opposite.
    """

    same: tuple[float, float]
    alternating: tuple[float, float]


def array_forces(
    device: Device, current: float, gap: float, pitch: float, cell: Cell | None = None
) -> ArrayForces:
    """Return the pull with all actuators of a square array driven; current in A, lengths in m.

    Raises
    ------
    InputError
        If the parts do not fit at this gap, or not into the pitch.
    SolverError
        If a field does not converge.
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
