"""Two long facing strips with opposite currents: the force between them.

ANSYS verification manual VM188: 24 A in conductors 12 mm tall, 0.5 mm thick, 10 mm
apart repel by 9.684e-3 N/m.
"""

from __future__ import annotations

import numpy as np

from tactgen.fem.magnetics.force_3d import eggshell_force, harmonic_weight
from tactgen.fem.magnetics.problem_3d import MagneticSolid, sample
from tactgen.geometry.arrays import Floats
from tactgen.geometry.meshing.mesh import Mesh
from tactgen.geometry.meshing.structured_tets import box_tetrahedra, graded_planes
from tactgen.validation.checks.cases.fineness import counted
from tactgen.validation.checks.cases.magnetics.sphere_in_field import Potential

CURRENT, APART, TALL, THICK = 24.0, 10e-3, 12e-3, 0.5e-3
PUBLISHED_FORCE = 9.684e-3
_SLICE = 2e-3
_NEAR, _FAR = 0.5 * (APART - THICK), 0.5 * (APART + THICK)


def thin_strips() -> float:
    """Return the force per length (N/m) between facing strips, Maxwell's integral solved."""
    ratio = APART / TALL
    factor = 2.0 * ratio * np.arctan(1.0 / ratio) - ratio**2 * np.log1p(1.0 / ratio**2)
    return float(2e-7 * CURRENT**2 / APART * factor)


def conductors(potential: Potential, scale: float) -> tuple[float, float]:
    """Return the force per length (N/m) away from the other bar, by stress and by J x B.

    `scale` is a factor on all cell sizes; 0.7 leaves 0.1 %.
    """
    solid = sample(
        MagneticSolid(_mesh(scale), {}, _conductor_source, flux_normal=("y_low",), copies=2)
    )
    weight = harmonic_weight(solid, ("bar",), ("shell",))
    solver = potential(solid)
    counted(solver.size)
    field = solver.solve(CURRENT)
    cells = solid.problem.mesh.cells_of("bar")
    density = CURRENT / (TALL * THICK)  # along −z here: F_x = −J_z B_y
    flux_density = field.flux_density[cells][..., 1]
    lorentz = 2.0 * float(np.sum(solid.weights[cells] * density * flux_density))
    stress = eggshell_force(field, weight, np.array([1.0, 0.0, 0.0]))
    return stress / _SLICE, lorentz / _SLICE


def _mesh(scale: float) -> Mesh:
    mm = 1e-3 * scale

    def planes(*stops: tuple[float, float]) -> Floats:
        return graded_planes(list(stops), growth=scale)

    far = (1.0, 500.0 * mm)
    x = planes(
        (0.0, 2 * mm), (1.5e-3, 2 * mm), (_NEAR, 0.3 * mm), (_FAR, 0.3 * mm), (13e-3, 6 * mm), far
    )
    y = planes((0.0, 3 * mm), (0.5 * TALL, 0.3 * mm), (14e-3, 6 * mm), far)
    z = np.array([0.0, _SLICE])
    mid = np.meshgrid(*(0.5 * (v[1:] + v[:-1]) for v in (x, y, z)), indexing="ij")
    shell = (mid[0] > 1.5e-3) & (mid[0] < 13e-3) & (mid[1] < 14e-3)
    bar = (mid[0] > _NEAR) & (mid[0] < _FAR) & (mid[1] < 0.5 * TALL)
    region = np.where(bar, 0, np.where(shell, 1, 2))
    return box_tetrahedra(x, y, z, region, ("bar", "shell", "air"))


def _conductor_source(points: Floats) -> Floats:
    """Return T0 between the bars, falling to 0 across each: ±1 A along z."""
    field = np.zeros(points.shape)
    ramp = np.clip((_FAR - points[..., 0]) / THICK, 0.0, 1.0)
    field[..., 1] = np.where(points[..., 1] < 0.5 * TALL, ramp / TALL, 0.0)
    return field
