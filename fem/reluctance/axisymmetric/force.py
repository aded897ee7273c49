"""The axial force on the moving regions of an axisymmetric field, by two independent routes.

*Eggshell*: the air's stress tensor T, weighted by a function g that is 1 on the moving
and 0 on the fixed parts, F = −∫ (T ∇g)_z dV (F. Henrotte, G. Deliège and K. Hameyer,
COMPEL 23, no. 4 (2004)).  With g harmonic the weight is small where the field is worst.

*Virtual work*: the exact derivative of the discrete coenergy when the grid's lines move
with the iron.  It reads the field in the iron too.  No field solution.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tactgen.fem.reluctance.axisymmetric.field import MagneticField
from tactgen.fem.reluctance.axisymmetric.space import (
    Discretisation,
    cells_in_order,
    quadrature_order,
)
from tactgen.fem.reluctance.iron import energy_density
from tactgen.fem.solvers.linear_solver import factorise
from tactgen.geometry.arrays import Floats
from tactgen.geometry.device.steel_law import MU0
from tactgen.geometry.reluctance.section_grid import Grid


@dataclass(frozen=True, eq=False)
class EggshellWeight:
    """Gradient of the weight at the quadrature points, each (n_e, n_q) in 1/m."""

    slope_r: Floats
    slope_z: Floats


def eggshell_weight(discretisation: Discretisation) -> EggshellWeight:
    """Return the harmonic weight between moving and fixed regions, at rest far away.

    Depends on the grid only: one weight serves all currents.
    """
    from skfem import Basis, BilinearForm, ElementQuad2, MeshQuad, condense
    from skfem.helpers import dot, grad

    @BilinearForm
    def laplace(u, v, w):  # type: ignore[no-untyped-def]  # noqa: ANN001, ANN202
        return w.x[0] * dot(grad(u), grad(v))

    grid = discretisation.grid
    mesh = MeshQuad.init_tensor(grid.r, grid.z)
    cells = cells_in_order(grid, mesh)
    basis = Basis(mesh, ElementQuad2(), intorder=quadrature_order(discretisation.order))
    state = _rigid(grid)
    carried, fixed = (np.unique(basis.element_dofs[:, cells[state == value]]) for value in (1, 0))
    edge = basis.get_dofs(mesh.facets_satisfying(lambda x: x[0] > 0.0, boundaries_only=True)).all()
    weight = np.zeros(basis.N)
    weight[carried] = 1.0
    held = np.unique(np.concatenate([carried, fixed, edge]))
    matrix, right, weight, free = condense(
        laplace.assemble(basis), np.zeros(basis.N), x=weight, D=held
    )
    weight[free] = factorise(matrix, definite=True).solve(right)
    slope = basis.interpolate(weight).grad
    return EggshellWeight(np.asarray(slope[0][cells]), np.asarray(slope[1][cells]))


def _rigid(grid: Grid) -> Floats:
    """Return 1 for cells that move, 0 for those at rest, nan in the air between, (n_e,)."""
    state = np.full(grid.labels.shape, np.nan)
    for index, region in enumerate(grid.regions):
        state[grid.labels == index] = 1.0 if region.moves else 0.0
    return state.ravel()


def eggshell_force(field: MagneticField, weight: EggshellWeight) -> float:
    """Return the force on the moving regions along +z (N)."""
    b_r, b_z = np.moveaxis(field.flux_density, -1, 0)
    # T = (B Bᵀ − B²/2) / µ0; ∇g vanishes in every part, so T is needed in air only
    along = b_r * b_z * weight.slope_r + 0.5 * (b_z**2 - b_r**2) * weight.slope_z
    return float(-np.sum(along * field.discretisation.volumes) / MU0)


def virtual_work_force(field: MagneticField) -> float:
    """Return the force on the moving regions along +z (N), ∂W'/∂(displacement) at fixed currents.

    Π is stationary in u, so only the motion counts.  The grid moves at the rate V(z), 1
    on moving and 0 on fixed iron edges: stretching a cell by ∂V/∂z makes its volume grow
    and its B_r fall.  Windings move through the grid: their linkage changes by
    (N/S) ∫ (v − V) ∂A_φ/∂z dV, ∂A_φ/∂z = −B_r, with v = 1 for a moving one.  (Tying the
    grid to windings too would spoil the derivative where one passes a pole.)
    """
    d, grid = field.discretisation, field.discretisation.grid
    b_r = field.flux_density[..., 0]
    velocity = grid.iron_velocity
    columns = grid.r.size - 1
    low, rise = (np.tile(x, columns)[:, None] for x in (velocity[:-1], np.diff(velocity)))
    stored = energy_density(d.iron, field.flux_density) - field.field_strength[..., 0] * b_r
    force = -float(np.sum(rise / d.heights[:, None] * stored * d.volumes))
    windings = [(k, region) for k, region in enumerate(grid.regions) if region.turns]
    for current, (index, winding) in zip(field.currents, windings, strict=True):
        slip = np.where(
            d.cell_labels[:, None] == index, winding.moves - low - rise * d.reference.levels, 0.0
        )
        density = float(current) * winding.turns / winding.section
        force -= density * float(np.sum(slip * b_r * d.volumes))
    return force
