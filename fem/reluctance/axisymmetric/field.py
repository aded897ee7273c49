"""Nonlinear magnetostatics with rotational symmetry, in the unknown u = A_φ / r.

Reads like the derivation.  With B = curl(A_φ e_φ),

    B_r = −r ∂u/∂z,    B_z = 2u + r ∂u/∂r,

u is smooth and free at the axis, so there is neither a singularity nor a condition
there.  The field minimises

    Π(u) = ∫ w(|B|) dV − Σ_k i_k λ_k(u),    λ_k = (N_k / S_k) ∫_coil r u dV,

with w = ∫ H dB, convex because H(B) increases; at the minimum −Π is the coenergy.
Newton's method with the exact second derivative, damped so that Π falls.  No device,
no forces.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from fem.reluctance.axisymmetric.space import Discretisation, gathered
from fem.solvers.linear_solver import Factor, SolverError, factorise
from geometry.arrays import Floats, Sparse
from geometry.device.steel_law import MU0

#: Newton stops when the decrement left after a step, relative to the energy, is below this:
#: the energy is then right to its square, everything else to about the number itself.
TOLERANCE = 1e-8
#: Rounding may keep the decrement above the tolerance; a standstill below this is accepted.
_STANDSTILL = 1e-6
_MOST_ITERATIONS = 100
#: Armijo's condition: the least part of the predicted decrease that a step must bring.
_ARMIJO = 1e-4
_SMALLEST_STEP = 2.0**-40


@dataclass(frozen=True, eq=False)
class MagneticField:
    """A converged field.

    Parameters
    ----------
    discretisation, currents
        What was solved; currents (n_coils,) in A.
    potential : (n_dofs,) float
        Coefficients of u = A_φ / r (T).
    tangent : (n_dofs, n_coils) float
        Derivative of `potential` by each current (T/A).
    iterations : int
        Newton steps taken.
    decrement : float
        Newton decrement left: distance to the exact minimum in the energy norm, relative.
    """

    discretisation: Discretisation
    currents: Floats
    potential: Floats
    tangent: Floats
    iterations: int
    decrement: float

    @cached_property
    def flux_density(self) -> tuple[Floats, Floats]:
        """B_r and B_z (T) at the quadrature points, each (n_e, n_q)."""
        return _flux_density(self.discretisation, self.potential)

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
        return float(np.sum(energy_density(d, np.hypot(*self.flux_density)) * d.volumes))

    @property
    def coenergy(self) -> float:
        """Coenergy Σ i λ − W (J)."""
        return float(self.currents @ self.flux_linkage) - self.energy

    @property
    def incremental_inductance(self) -> Floats:
        """∂λ_j/∂i_k, (n_coils, n_coils) in H."""
        return np.asarray(self.discretisation.linkage @ self.tangent)

    def predicted(self, currents: Floats) -> Floats:
        """Return the potential at other currents to first order, to start Newton from."""
        return np.asarray(self.potential + self.tangent @ (np.asarray(currents) - self.currents))


def solve_field(
    discretisation: Discretisation,
    currents: Floats,
    start: Floats | None = None,
    inverse: Inverse | None = None,
) -> MagneticField:
    """Find the field of given currents.

    Parameters
    ----------
    discretisation : Discretisation
        Functions and materials.
    currents : (n_coils,) float
        Current of each region with turns (A), in the order of the regions.
    start : (n_dofs,) float, optional
        Potential to start from; zero by default.
    inverse : Inverse, optional
        The one of an earlier solution on this grid, so that its ordering is kept.

    Raises
    ------
    SolverError
        If Newton's method does not get below its tolerance.
    """
    d = discretisation
    currents = np.asarray(currents, dtype=float)
    source = currents @ d.linkage
    u = np.zeros(d.size) if start is None or not currents.any() else start.copy()
    field = _flux_density(d, u)
    total, size = _functional(d, field, float(source @ u))
    forces, matrix = _derivatives(d, field)
    before = np.inf
    inverse = inverse or Inverse()
    for iteration in range(_MOST_ITERATIONS):
        inverse.update(d, matrix, iteration)
        step = inverse(source - forces)
        descent = float((forces - source) @ step)
        u, field, total, size = _line_search(d, u, step, source, total, descent)
        forces, matrix = _derivatives(d, field)
        # measured after the step, with the matrix from before it: the same to first order
        rest = source - forces
        decrement = math.sqrt(abs(float(rest @ inverse(rest))) / size) if size else 0.0
        if decrement <= TOLERANCE or 0.5 * before < decrement <= _STANDSTILL:
            # likewise the tangent, corrected once by the matrix from after the step
            tangent = inverse(d.linkage.T)
            tangent += inverse(d.linkage.T - _product(d, matrix, tangent))
            return MagneticField(d, currents, u, tangent, iteration + 1, decrement)
        before = decrement
    raise SolverError(_failure(d, _MOST_ITERATIONS, f"the decrement stays at {before:.1e}"))


class Inverse:
    """K⁻¹ on the free unknowns, 0 on the held ones; K changes, its sparsity pattern does not.

    One for all currents and displacements of a grid finds the ordering once.
    """

    def __init__(self) -> None:
        self._factor: Factor | None = None

    def update(self, d: Discretisation, matrix: Sparse, iteration: int) -> None:
        """Take the matrix K over the free unknowns of Newton step `iteration`."""
        if not np.all(matrix.diagonal() > 0.0):
            raise SolverError(_failure(d, iteration, "the system is not definite"))
        self._free = d.free
        if self._factor is None:
            self._factor = factorise(matrix, definite=True)
        else:
            self._factor.refactorise(matrix)

    def __call__(self, right: Floats) -> Floats:
        """Return K⁻¹ right for right of shape (n_dofs,) or (n_dofs, k)."""
        assert self._factor is not None
        found = np.zeros_like(right)
        found[self._free] = self._factor.solve(right[self._free])
        return found


def _product(d: Discretisation, matrix: Sparse, vectors: Floats) -> Floats:
    """Return K times vectors (n_dofs, k), 0 on the held unknowns."""
    found = np.zeros_like(vectors)
    found[d.free] = matrix @ vectors[d.free]
    return found


def _failure(d: Discretisation, iterations: int | None, what: str) -> str:
    when = "" if iterations is None else f"after {iterations} Newton steps "
    return (
        f"the magnetic field did not converge: {when}{what} "
        f"(order {d.order}, {d.free.size} unknowns); use a finer grid or a smoother curve"
    )


def _line_search(
    d: Discretisation,
    u: Floats,
    step: Floats,
    source: Floats,
    total: float,
    descent: float,
) -> tuple[Floats, tuple[Floats, Floats], float, float]:
    """Halve the step until Π falls enough; return u, B, Π and the size of its terms there."""
    if not descent <= 0.0:
        raise SolverError(_failure(d, None, "the system is not definite"))
    part = 1.0
    while True:
        trial = u + part * step
        field = _flux_density(d, trial)
        new, size = _functional(d, field, float(source @ trial))
        # near the minimum the decrease drowns in the rounding of the two large terms
        rounding = 1e-13 * size
        if new <= total + _ARMIJO * part * descent + rounding:
            return trial, field, new, size
        part *= 0.5
        if part < _SMALLEST_STEP:
            raise SolverError(_failure(d, None, "no step of Newton's lowers the energy"))


def _flux_density(d: Discretisation, u: Floats) -> tuple[Floats, Floats]:
    local = u[d.cell_dofs][:, :, None]
    return (d.curl_r @ local)[..., 0], (d.curl_z @ local)[..., 0]


def _functional(
    d: Discretisation, field: tuple[Floats, Floats], linked: float
) -> tuple[float, float]:
    """Return Π and the size of its larger term (J)."""
    energy = float(np.sum(energy_density(d, np.hypot(*field)) * d.volumes))
    return energy - linked, max(energy, abs(linked))


def _derivatives(d: Discretisation, field: tuple[Floats, Floats]) -> tuple[Floats, Sparse]:
    """Return the gradient (n_dofs,) of ∫ w dV and its second derivative over the free unknowns.

    ∂H/∂B = ν 1 + (dH/dB − ν) b bᵀ with ν = H/|B| and b the direction of B.
    """
    b_r, b_z = field
    magnitude = np.hypot(b_r, b_z)
    nu, slope = _reluctivities(d, magnitude)
    safe = np.where(magnitude > 0.0, magnitude, 1.0)
    e_r, e_z = b_r / safe, b_z / safe
    extra = (slope - nu) * d.volumes
    even = nu * d.volumes
    curls = np.concatenate([d.curl_r, d.curl_z], axis=1)
    h = np.concatenate([even * b_r, even * b_z], axis=1)
    gradient = gathered(d.cell_dofs, (h[:, None, :] @ curls)[:, 0, :], d.size)
    rr, rz, zz = (even + extra * e_r**2, extra * e_r * e_z, even + extra * e_z**2)
    weighted = np.concatenate([
        rr[..., None] * d.curl_r + rz[..., None] * d.curl_z,
        rz[..., None] * d.curl_r + zz[..., None] * d.curl_z,
    ], axis=1)  # fmt: skip
    return gradient, d.pattern.matrix(np.matmul(curls.transpose(0, 2, 1), weighted))


def _reluctivities(d: Discretisation, magnitude: Floats) -> tuple[Floats, Floats]:
    """Return H/B and dH/dB (m/H) at the quadrature points."""
    nu = np.full_like(magnitude, 1.0 / MU0)
    slope = nu.copy()
    for index, region in enumerate(d.grid.regions):
        if region.curve is not None:
            cells = d.cell_labels == index
            nu[cells] = region.curve.reluctivity(magnitude[cells])
            slope[cells] = region.curve.slope(magnitude[cells])
    return nu, slope


def reluctivity(d: Discretisation, magnitude: Floats) -> Floats:
    """Return H/B (m/H) at the quadrature points for |B| of shape (n_e, n_q)."""
    return _reluctivities(d, magnitude)[0]


def energy_density(d: Discretisation, magnitude: Floats) -> Floats:
    """Return ∫ H dB (J/m³) at the quadrature points for |B| of shape (n_e, n_q)."""
    density = magnitude**2 / (2.0 * MU0)
    for index, region in enumerate(d.grid.regions):
        if region.curve is not None:
            cells = d.cell_labels == index
            density[cells] = region.curve.energy_density(magnitude[cells])
    return density


def truncation_error(solution: MagneticField) -> float:
    """Return the coenergy (J) lost by closing the open space at the outer radius.

    A dipole m in the middle of a sphere of radius R that no flux leaves feels the uniform
    field −µ0 m / (2π R³) of the sphere's currents, so µ0 m² / (4π R³) is missing (from
    the dipole field, J. D. Jackson, Classical Electrodynamics, 3rd ed., section 5.6).
    The cylinder here encloses that sphere, so the bound is on the safe side.
    """
    d = solution.discretisation
    _, b_z = solution.flux_density
    nu = reluctivity(d, np.hypot(*solution.flux_density))
    moment = float(np.sum((1.0 / MU0 - nu) * b_z * d.volumes))
    coils = [region for region in d.grid.regions if region.turns]
    for current, coil in zip(solution.currents, coils, strict=True):
        inner, outer = coil.radii
        mean_square = (inner**2 + inner * outer + outer**2) / 3.0
        moment += float(current) * coil.turns * math.pi * mean_square
    return MU0 * moment**2 / (4.0 * math.pi * float(d.grid.r[-1]) ** 3)
