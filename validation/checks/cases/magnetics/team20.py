"""TEAM problem 20 solved by either potential: what was measured of it, at those currents."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from tactgen.fem.magnetics.force_3d import eggshell_force, harmonic_weight
from tactgen.fem.magnetics.problem_3d import MagneticField, MagneticSolid, sample
from tactgen.geometry.arrays import Floats
from tactgen.geometry.device.steel_law import TEAM20
from tactgen.geometry.reluctance.team20 import (
    HALF_WAY_UP,
    LEG_SECTION,
    POLE_SECTION,
    PROBES,
    Team20Meshing,
    team20_mesh,
    team20_source,
)
from tactgen.validation.checks.cases.fineness import counted
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


@dataclass(frozen=True)
class FluxDensities:
    """Vertical flux densities (T), as they were measured.

    Attributes
    ----------
    centre, corner : float
        In the middle of the gap, below the pole's centre and below its corner.
    pole, yoke : float
        Mean over a section of the pole and of one leg of the yoke, half way up the coil.
    """

    centre: float
    corner: float
    pole: float
    yoke: float


def team20_problem(scale: float) -> MagneticSolid:
    """Return a quarter of the problem, cells `scale` times as large as the default's."""
    mesh = team20_mesh(Team20Meshing(scale=scale))
    return MagneticSolid(mesh, {"pole": TEAM20, "yoke": TEAM20}, team20_source, copies=4)


def pole_forces(
    potential: Potential, scale: float, currents: Sequence[float]
) -> Iterator[PoleForce]:
    """Yield the pole's force at each number of ampere-turns, each started from the last."""
    for force, _ in pole_states(potential, scale, currents):
        yield force


def pole_states(
    potential: Potential, scale: float, currents: Sequence[float]
) -> Iterator[tuple[PoleForce, MagneticField]]:
    """Yield the same with the field."""
    solid = sample(team20_problem(scale))
    weight = harmonic_weight(solid, ("pole",), ("shell",))
    solver, field = potential(solid), None
    counted(solver.size)
    for current in currents:
        field = solver.solve(current, start=field)
        force = eggshell_force(field, weight, DOWN)
        yield PoleForce(current, force, field.coenergy, solver.size), field


def flux_densities(field: MagneticField) -> FluxDensities:
    """Read off a field what was measured beside the force."""
    centre, corner = field.flux_density_at(np.array(PROBES))[:, 2]
    pole, yoke = (
        abs(float(np.mean(field.flux_density_at(_section(*sides))[:, 2])))
        for sides in (POLE_SECTION, LEG_SECTION)
    )
    return FluxDensities(float(centre), float(corner), pole, yoke)


def _section(x: tuple[float, float], y: tuple[float, float]) -> Floats:
    """Return the middles (n, 3) of 20 by 20 equal parts of a section half way up the coil."""
    shares = (np.arange(20) + 0.5) / 20.0
    along = (low + (high - low) * shares for low, high in (x, y))
    grid = np.meshgrid(*along, [HALF_WAY_UP], indexing="ij")
    return np.stack([c.ravel() for c in grid], axis=1)
