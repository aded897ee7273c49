"""TEAM problem 20 solved by either potential: force and co-energy at the measured currents."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from tactgen.fem.reluctance.three_d.force import eggshell_force, harmonic_weight
from tactgen.fem.reluctance.three_d.problem import MagneticSolid, sample
from tactgen.geometry.device.steel_law import TEAM20
from tactgen.geometry.reluctance.team20 import Team20Meshing, team20_mesh, team20_source
from tactgen.validation.checks.cases.magnetics.sphere_in_field import Potential

#: Direction in which the pole is pulled.
DOWN = np.array([0.0, 0.0, -1.0])


@dataclass(frozen=True)
class PoleForce:
    """What one current does: N, J, and how many unknowns it took."""

    current: float
    force: float
    coenergy: float
    unknowns: int


def team20_problem(scale: float) -> MagneticSolid:
    """Return a quarter of the problem, cells `scale` times as large as the default's."""
    mesh = team20_mesh(Team20Meshing(scale=scale))
    return MagneticSolid(mesh, {"pole": TEAM20, "yoke": TEAM20}, team20_source, copies=4)


def pole_forces(
    potential: Potential, scale: float, currents: Sequence[float]
) -> Iterator[PoleForce]:
    """Yield the pole's force at each number of ampere-turns, each started from the last."""
    solid = sample(team20_problem(scale))
    weight = harmonic_weight(solid, "pole", ("shell",))
    solver, field = potential(solid), None
    for current in currents:
        field = solver.solve(current, start=field)
        yield PoleForce(current, eggshell_force(field, weight, DOWN), field.coenergy, solver.size)
