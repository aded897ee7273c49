"""Nonlinear magnetostatics with rotational symmetry, in the unknown u = A_φ / r.

Reads like the derivation.  With B = curl(A_φ e_φ),

    B_r = −r ∂u/∂z,    B_z = 2u + r ∂u/∂r,

u is smooth and free at the axis, so there is neither a singularity nor a condition
there.  The field minimises

    Π(u) = ∫ w(|B|) dV − Σ_k i_k λ_k(u),    λ_k = (N_k / S_k) ∫_coil r u dV,

with w = ∫ H dB, convex because H(B) increases; at the minimum −Π is the coenergy.  No
device, no forces.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise

import numpy as np

from tactgen.fem.magnetics.axisymmetric_space import (
    Discretisation,
    energy_density,
    field_from_flux,
    reluctivity_tensor,
)
from tactgen.fem.solvers.newton import TOLERANCE, Factors, minimise
from tactgen.geometry.arrays import Floats, Sparse
from tactgen.geometry.device.magnetisation import MU0


@dataclass(frozen=True)
class MagneticField:
    """A converged field."""

    discretisation: Discretisation
    currents: Floats  #: (n_coils,) A
    potential: Floats  #: (n_dofs,) Coefficients of u = A_φ / r (T)
    tangent: Floats  #: (n_dofs, n_coils) Derivative of `potential` by each current (T/A)
    iterations: int  #: Newton steps taken

    @cached_property
    def flux_density(self) -> Floats:
        """B_r and B_z (T) at the quadrature points, (n_e, n_q, 2)."""
        d = self.discretisation
        return d.flux_density(self.potential[d.cell_dofs])

    @cached_property
    def field_strength(self) -> Floats:
        """H_r and H_z (A/m) at the quadrature points, (n_e, n_q, 2)."""
        return field_from_flux(self.discretisation.iron, self.flux_density)

    @property
    def flux_function(self) -> Floats:
        """Flux function r A_φ (Wb) where lines cross, (nr + 1, nz + 1): contours are flux lines.

        2π times it is the flux through the circle.  Hierarchical functions other than the
        corners' vanish there.
        """
        d, grid = self.discretisation, self.discretisation.grid
        corners = self.potential[d.cell_dofs[:, :4]].reshape(grid.r.size - 1, -1, 4)
        u = np.empty((grid.r.size, grid.z.size))
        # scikit-fem counts the corners from the lower inner one, up along z first
        u[:-1, :-1], u[:-1, 1:] = corners[..., 0], corners[..., 1]
        u[1:, 1:], u[1:, :-1] = corners[..., 2], corners[..., 3]
        return grid.r[:, None] ** 2 * u

    @property
    def flux_linkage(self) -> Floats:
        """Flux linkage of each coil, (n_coils,) in Wb."""
        return np.asarray(self.discretisation.linkage @ self.potential)

    @property
    def energy(self) -> float:
        """Field energy ∫ w dV (J)."""
        d = self.discretisation
        return float(np.sum(energy_density(d.iron, self.flux_density) * d.volumes))

    @property
    def coenergy(self) -> float:
        """Coenergy Σ i λ − W (J)."""
        return float(self.currents @ self.flux_linkage) - self.energy

    @property
    def incremental_inductance(self) -> Floats:
        """∂λ_j/∂i_k, (n_coils, n_coils) in H."""
        return np.asarray(self.discretisation.linkage @ self.tangent)

    def predicted(self, currents: Floats) -> Floats:
        """Potential at other currents to first order, to start Newton from."""
        return np.asarray(self.potential + self.tangent @ (np.asarray(currents) - self.currents))


def solve_field(
    discretisation: Discretisation,
    currents: Floats,
    start: Floats | None = None,
    factors: Factors | None = None,
    tolerance: float = TOLERANCE,
) -> MagneticField:
    """Field of given currents (n_coils,) in A, one for each region with turns, in their order.

    `start` (n_dofs,) is a potential to start from, zero by default.  `factors` are those of an
    earlier solution on this grid, so that their ordering is kept, and they themselves where the
    field differs little; `tolerance` is as of :func:`fem.solvers.newton.minimise`.

    Raises SolverError if Newton's method does not arrive.
    """
    d = discretisation
    currents = np.asarray(currents, dtype=float)
    factors = factors or Factors()
    energy = _Energy(d, currents @ d.linkage)
    rest = np.zeros(d.size)
    first = rest if start is None or not currents.any() else start
    found = minimise(energy, first[d.free], factors, tolerance)
    slope = factors.solve_near(energy.hessian(found.x), d.linkage[:, d.free].T)
    potential, tangent = np.zeros(d.size), np.zeros((d.size, currents.size))
    potential[d.free], tangent[d.free] = found.x, slope
    return MagneticField(d, currents, potential, tangent, found.steps)


class _Energy:
    """Π(u) over the free unknowns; the last value is cached."""

    def __init__(self, d: Discretisation, source: Floats) -> None:
        self._d, self._source = d, source[d.free]
        # the cells of iron, numbered among themselves
        ends = np.cumsum([0, *(cells.size for cells, _ in d.iron)])
        self._iron = [
            (np.arange(*between), curve)
            for between, (_, curve) in zip(pairwise(ends), d.iron, strict=True)
        ]
        self._at: Floats = np.zeros(0)
        self._flux: Floats = np.zeros(0)
        self._energy = 0.0

    def _flux_density(self, x: Floats) -> Floats:
        if self._at is not x:
            self._at, self._flux = x, self._d.flux_density(self._d.pattern.local(x))
            density = energy_density(self._d.iron, self._flux)
            self._energy = float(np.sum(density * self._d.volumes))
        return self._flux

    def _stored(self, x: Floats) -> float:
        self._flux_density(x)
        return self._energy

    def value(self, x: Floats) -> float:
        return self._stored(x) - float(self._source @ x)

    def scale(self, x: Floats) -> float:
        return max(self._stored(x), abs(float(self._source @ x)))

    def gradient(self, x: Floats) -> Floats:
        d = self._d
        field = field_from_flux(d.iron, self._flux_density(x))
        return d.pattern.vector(d.functional(field)) - self._source

    def hessian(self, x: Floats) -> Sparse:
        d, cells = self._d, self._d.iron_cells
        tensor = reluctivity_tensor(self._iron, self._flux_density(x)[cells])
        local = d.matrices(tensor, cells)
        return d.pattern.of_entries(d.vacuum_entries + d.iron_pattern.entries(local))


def truncation_error(solution: MagneticField) -> float:
    """Coenergy (J) lost by closing the open space at the outer radius.

    A dipole m in the middle of a sphere of radius R that no flux leaves feels the uniform
    field −µ0 m / (2π R³) of the sphere's currents, so µ0 m² / (4π R³) is missing (from
    the dipole field, J. D. Jackson, Classical Electrodynamics, 3rd ed., section 5.6).
    The cylinder here encloses that sphere, so the bound is on the safe side.
    """
    d = solution.discretisation
    magnetisation = solution.flux_density / MU0 - solution.field_strength
    moment = float(np.sum(magnetisation[..., 1] * d.volumes))
    coils = [region for region in d.grid.regions if region.turns]
    for current, coil in zip(solution.currents, coils, strict=True):
        inner, outer = coil.radii
        mean_square = (inner**2 + inner * outer + outer**2) / 3.0
        moment += float(current) * coil.turns * math.pi * mean_square
    return MU0 * moment**2 / (4.0 * math.pi * float(d.grid.r[-1]) ** 3)
