"""A permeable ball in a uniform field: B inside is uniform, 3 µr B0/(µr + 2) in open space.

Here φ = −H0 z is held on a concentric sphere, which is exact too (J. D. Jackson,
Classical Electrodynamics, 3rd ed., section 5.12, with the shell's outer condition).
"""

from __future__ import annotations

import numpy as np

from tactgen.fem.magnetics.problem_3d import MagneticSolid, SampledSolid, sample
from tactgen.fem.magnetics.scalar_potential import ScalarPotential
from tactgen.fem.magnetics.vector_potential import VectorPotential
from tactgen.geometry.device.steel_law import MU0, MagnetisationCurve, linear
from tactgen.validation.checks.cases.fineness import counted
from tactgen.validation.checks.cases.magnetics.sphere_mesh import OUTER, RADIUS, sphere_mesh

Potential = type[VectorPotential] | type[ScalarPotential]


def sampled_ball(n: int, iron: MagnetisationCurve, *, curved: bool = True) -> SampledSolid:
    """Return the problem on `n` intervals per edge, for a field of 1 A/m along z."""
    return sample(
        MagneticSolid(
            sphere_mesh(n, curved=curved),
            {"ball": iron},
            lambda points: np.broadcast_to([0.0, 0.0, 1.0], points.shape),
            flux_normal=("z_low", "outer"),
            copies=8,
        )
    )


def exact_flux_density(permeability: float) -> float:
    """Return B in the ball (T) for 1 A/m, φ = −H0 z held at OUTER."""
    shape = (permeability + 2.0) - (permeability - 1.0) * (RADIUS / OUTER) ** 3
    return 3.0 * permeability * MU0 / shape


def ball_error(
    potential: Potential, n: int, *, curved: bool = True, permeability: float = 1000.0
) -> tuple[float, float]:
    """Return the relative error of B in the ball: of its mean and in the mean square."""
    solid = sampled_ball(n, linear(permeability), curved=curved)
    solver = potential(solid)
    counted(solver.size)
    field = solver.solve(1.0)
    exact = exact_flux_density(permeability)
    cells = solid.problem.mesh.cells_of("ball")
    weights = solid.weights[cells] / solid.weights[cells].sum()
    miss = (field.flux_density[cells] - [0.0, 0.0, exact]) / exact
    mean = float(np.sum(miss[..., 2] * weights))
    return mean, float(np.sqrt(np.sum(np.sum(miss**2, axis=-1) * weights)))
