"""The axisymmetric field against exact solutions."""

from __future__ import annotations

import itertools
import math
from dataclasses import replace

import numpy as np
import pytest

from tactgen.fem.magnetics.axisymmetric_field import solve_field, truncation_error
from tactgen.fem.magnetics.axisymmetric_force import virtual_work_force
from tactgen.fem.magnetics.axisymmetric_space import discretise, lowered
from tactgen.fem.solvers.linear_solver import SolverError
from tactgen.geometry.device.magnetisation import MU0, TEAM20, MagnetisationCurve
from tactgen.geometry.reluctance.section_grid import Grid, Region, graded_grid
from tactgen.validation.evidence.cases.coils import HIGH, LOW


def test_truncation_falls_with_the_cube_of_the_radius():
    """The closed boundary costs as much coenergy as the dipole estimate says, ∝ R⁻³."""
    found, estimates = [], []
    for radius in (0.4, 0.8, 1.6, 6.4):
        d = discretise(graded_grid((LOW, HIGH), radius, refinement=2.0), 4)
        field = solve_field(d, np.array([2.0, 3.0]))
        found.append(field.coenergy)
        estimates.append(truncation_error(field))
    lost = [found[-1] - value for value in found[:-1]]
    # next multipole: (coil / R)² ≈ 2 % at the smallest radius, and the same of the reference
    orders = [math.log2(a / b) for a, b in itertools.pairwise(lost)]
    assert orders == pytest.approx([3.0, 3.0], abs=0.1)
    # the cylinder encloses the sphere of the estimate
    assert all(0.7 * bound < lack < bound for lack, bound in zip(lost, estimates, strict=False))


#: A pot-like pair: a winding around a rod over a plate, small and saturable.
POLE = Region("pole", (0.0, 2e-3), (0.3e-3, 6e-3), TEAM20, moves=True)
PLATE = Region("plate", (0.0, 5e-3), (-2e-3, 0.0), TEAM20)
COIL = Region("coil", (2.5e-3, 4e-3), (1e-3, 5e-3), turns=100.0, moves=True)


@pytest.mark.parametrize("current", [0.01, 1.0, 30.0])
def test_energies_and_derivatives_belong_together(current):
    """W + W' = iλ; ∂W'/∂i = λ; ∂λ/∂i as found; force = ∂W'/∂z, exactly of the discrete field."""
    parts = (POLE, PLATE, COIL)
    d = discretise(graded_grid(parts, 0.1), 3)

    def at(i, z=0.0):
        grid = d.grid.fitted(tuple(part.displaced(z) for part in parts))
        return solve_field(d.on(grid), np.array([i]))

    field = at(current)
    linkage = field.flux_linkage[0]
    magnitude = np.linalg.norm(field.flux_density, axis=-1)
    coenergy = magnitude**2 / (2.0 * MU0)
    iron = field.discretisation.cell_labels < 2
    iron &= field.discretisation.cell_labels >= 0
    coenergy[iron] = TEAM20.coenergy_density(magnitude[iron])
    # Galerkin: ∫ H·B dV = iλ up to the tolerance of Newton's method
    assert np.sum(coenergy * d.volumes) == pytest.approx(field.coenergy, rel=1e-8)
    step = 1e-3 * current
    more, less = at(current + step), at(current - step)
    # central differences: (1e-3)² times a third derivative of order one
    assert (more.coenergy - less.coenergy) / (2.0 * step) == pytest.approx(linkage, rel=1e-5)
    slope = (more.flux_linkage[0] - less.flux_linkage[0]) / (2.0 * step)
    assert slope == pytest.approx(field.incremental_inductance[0, 0], rel=1e-3)
    shift = 1e-8
    raised, sunk = at(current, shift), at(current, -shift)
    force = (raised.coenergy - sunk.coenergy) / (2.0 * shift)
    # difference of coenergies good to 1e-13 over 2e-8 m / 0.3 mm, about 1e-8 of the force
    assert force == pytest.approx(virtual_work_force(field), rel=1e-6)


def test_lower_order_is_contained():
    """The tables one order lower give the same problem as a fresh discretisation of that order."""
    grid = graded_grid((POLE, PLATE, COIL), 0.1)
    fine = discretise(grid, 4)
    part, nested = lowered(fine)
    fresh = discretise(grid, 3)
    a, b = (solve_field(d, np.ones(1)) for d in (part, fresh))
    assert part.size == fresh.size == nested.size
    # the part keeps the finer quadrature, which for a curve with corners is not the same integral
    assert a.flux_linkage == pytest.approx(b.flux_linkage, rel=1e-5)
    raised = np.zeros(fine.size)
    raised[nested] = a.potential
    warm = solve_field(fine, np.ones(1), raised)
    cold = solve_field(fine, np.ones(1))
    assert warm.flux_linkage == pytest.approx(cold.flux_linkage, rel=1e-9)
    assert warm.iterations < cold.iterations
    # a larger space holds more coenergy at given current: the minimum of the energy is lower
    assert cold.coenergy > a.coenergy


@pytest.mark.parametrize(
    ("current", "ratio"),
    [
        *itertools.product((1e-6, 1e4), (1e-6, 1e6)),
        (1.0, 1.0),
        *(
            pytest.param(*case, marks=pytest.mark.heavy)
            for case in (*itertools.product((1e-3, 1.0, 1e2), (1e-6, 1e6)), (1e-3, 1.0), (1e2, 1.0))
        ),
    ],
)
def test_badly_graded_grids(current, ratio):
    """Cells of any aspect ratio, up to a million ampere-turns: it converges towards one field."""
    marks_r = [0.0, 2e-3, 2.5e-3, 4e-3, 5e-3, 0.05]
    marks_z = [-0.05, -2e-3, 0.0, 0.3e-3, 1e-3, 5e-3, 6e-3, 0.05]
    lines = [
        np.unique(np.concatenate([marks, np.array(marks[:-1]) + np.diff(marks) / (1.0 + ratio)]))
        for marks in (marks_r, marks_z)
    ]
    regions = (POLE, PLATE, COIL)
    grid = Grid(*lines, regions)
    good = graded_grid(regions, 0.05)
    coenergies = [
        solve_field(discretise(g, order), np.array([current])).coenergy
        for g, order in ((grid, 2), (grid, 4), (good, 4))
    ]
    # the coenergy of any discretisation is too small, and less so in a larger space
    assert 0.0 < coenergies[0] < coenergies[1] < coenergies[2]
    assert coenergies[1] > 0.5 * coenergies[2]


def test_no_silent_wrong_answer(monkeypatch):
    """A field that is not converged is refused with a sentence, never returned."""
    monkeypatch.setattr("tactgen.fem.solvers.newton._MAX_STEPS", 2)
    d = discretise(graded_grid((POLE, PLATE, COIL), 0.1), 2)
    with pytest.raises(SolverError, match="did not settle in 2 Newton steps"):
        solve_field(d, np.array([30.0]))


def test_a_singular_problem_is_refused():
    """A curve whose energy has no minimum (H falls below zero) ends in an error, not a number."""
    upside_down = MagnetisationCurve(np.array([0.0, 1.0]), np.array([0.0, -1e6]), -1e6)
    parts = (replace(POLE, curve=upside_down), replace(PLATE, curve=upside_down), COIL)
    with pytest.raises(SolverError):
        solve_field(discretise(graded_grid(parts, 0.1), 2), np.array([1.0]))
