"""The axial force on the moving regions of an axisymmetric field, by two independent routes.

*Eggshell*: the air's stress tensor T, weighted by a function g that is 1 on the moving
and 0 on the fixed parts, F = −∫ (T ∇g)_z dV (F. Henrotte, G. Deliège and K. Hameyer,
COMPEL 23, no. 4 (2004)).  With g harmonic the weight is small where the field is worst.

*Virtual work*: the exact derivative of the discrete coenergy when the grid's lines move
with the iron.  It reads the field in the iron too.  No field solution.
"""

from __future__ import annotations

import numpy as np

from tactgen.fem.elements.pattern import Pattern
from tactgen.fem.magnetics.axisymmetric_field import MagneticField
from tactgen.fem.magnetics.axisymmetric_space import (
    Discretisation,
    energy_density,
    functions_of_order,
)
from tactgen.fem.solvers.newton import Factors
from tactgen.geometry.arrays import Floats
from tactgen.geometry.device.magnetisation import MU0
from tactgen.geometry.reluctance.section_grid import Grid


class Eggshell:
    """The harmonic weight between moving and fixed regions, at rest far away.

    One for all grids of the same cells, wherever their lines lie; on each it serves all currents.
    """

    def __init__(self, discretisation: Discretisation) -> None:
        d = discretisation
        functions, self._cell_dofs, kept = functions_of_order(d, min(2, d.order))
        self._reference = d.reference.of_functions(functions)
        state, size = _rigid(d.grid), kept.size
        carried, fixed = (np.unique(self._cell_dofs[state == value]) for value in (1, 0))
        # of a function that is 1 all over a cell only the corners' parts are not zero
        corners = np.unique(self._cell_dofs[:, :4])
        self._held = np.zeros(size)
        self._held[np.intersect1d(carried, corners)] = 1.0
        between = np.isin(kept, d.free)
        between[carried] = between[fixed] = False
        self._free = np.flatnonzero(between)
        self._pattern = Pattern(self._cell_dofs, self._free)
        self._factors = Factors()

    def weight(self, discretisation: Discretisation) -> Floats:
        """Slopes (2, n_e, n_q) of the weight along r and z (1/m) at the field's quadrature points.

        On one of these grids.
        """
        d, reference = discretisation, self._reference
        widths, heights = np.diff(d.grid.r)[:, None], d.heights[:, None]
        radii = d.grid.r[:-1, None] + widths * reference.across
        density = (radii * reference.weights)[..., None]
        slope_r, slope_z = reference.slope_r, reference.slope_z
        local = d.of_columns(
            widths[..., None] * (slope_z.T @ (density * slope_z)),
            slope_r.T @ (density * slope_r) / widths[..., None],
            np.arange(heights.size),
        )
        weight = self._held.copy()
        given = (local @ weight[self._cell_dofs][..., None])[..., 0]
        self._factors.update(self._pattern.matrix(local))
        weight[self._free] = -self._factors.solve(self._pattern.vector(given))
        of_cells = weight[self._cell_dofs]
        columns = np.repeat(widths, d.grid.z.size - 1, axis=0)
        return np.stack([of_cells @ slope_r.T / columns, of_cells @ slope_z.T / heights])


def _rigid(grid: Grid) -> Floats:
    """1 for cells that move, 0 for those at rest, nan in the air between, (n_e,)."""
    state = np.full(grid.labels.shape, np.nan)
    for index, region in enumerate(grid.regions):
        state[grid.labels == index] = 1.0 if region.moves else 0.0
    return state.ravel()


def eggshell_force(field: MagneticField, weight: Floats) -> float:
    """Force on the moving regions along +z (N)."""
    return -float(np.sum(_stress(field, weight)))


def stress_size(field: MagneticField, weight: Floats) -> float:
    """Integral of the size of the stress whose integral is the force (N): what may cancel."""
    return float(np.sum(np.abs(_stress(field, weight))))


def _stress(field: MagneticField, weight: Floats) -> Floats:
    """Contribution of each quadrature point to minus the force (N)."""
    b_r, b_z = np.moveaxis(field.flux_density, -1, 0)
    # T = (B Bᵀ − B²/2) / µ0; ∇g vanishes in every part, so T is needed in air only
    slope_r, slope_z = weight
    along = b_r * b_z * slope_r + 0.5 * (b_z**2 - b_r**2) * slope_z
    return np.asarray(along * field.discretisation.volumes / MU0)


def virtual_work_force(field: MagneticField) -> float:
    """Force on the moving regions along +z (N), ∂W'/∂(displacement) at fixed currents.

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
