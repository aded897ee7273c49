"""Magnetic field by the vector potential: B = curl A with second-order edge elements.

Weak form, for all v:   ∫ H(curl A)·curl v dV = ∫ T0·curl v dV,
which is where ∫ w(curl A) − T0·curl A dV is least (w = ∫ H·dB).

A is fixed up to a gradient only.  The Jacobian is made invertible by adding ν0 ε ∫ A·v; the
residual is left as it is, and both are free of gradients, so the added term does not touch
the solution: it only costs a little of Newton's speed.

The discrete B is solenoidal and the discrete energy too large, so the co-energy is too
small.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from tactgen.fem.elements.pattern import FieldKernel, Pattern
from tactgen.fem.magnetics.iron import energy_density, field_from_flux, reluctivity_tensor
from tactgen.fem.magnetics.problem_3d import MagneticField, SampledSolid
from tactgen.fem.solvers.newton import Factors, minimise
from tactgen.geometry.arrays import Floats, Ints, Sparse
from tactgen.geometry.device.steel_law import MU0

#: ε times the square of the mesh's diagonal.  What a Newton step misses because of the added
#: term is about this times a relative permeability; far smaller values cost digits in the
#: factors.
_GAUGE = 1e-4


class VectorPotential:
    """The problem assembled for A; solve as many currents as wanted."""

    def __init__(self, solid: SampledSolid) -> None:
        from skfem import Dofs

        from tactgen.fem.elements.nedelec import ElementTetEdge2

        self._solid = solid
        element = ElementTetEdge2()
        dofs = Dofs(solid.domain, element)
        pattern = Pattern(np.ascontiguousarray(dofs.element_dofs.T), _free(solid, dofs))
        local = [element.lbasis(solid.reference_points, i) for i in range(14)]
        jacobians = solid.jacobians
        determinants = np.linalg.det(jacobians)[..., None, None]
        self._curl = FieldKernel(
            np.array([curl for _, curl in local]), jacobians / determinants, solid.weights, pattern
        )
        values = FieldKernel(
            np.array([value for value, _ in local]),
            np.swapaxes(np.linalg.inv(jacobians), -1, -2),
            solid.weights,
            pattern,
        )
        identity = np.broadcast_to(np.eye(3), (*solid.weights.shape, 3, 3))
        diagonal = float(np.linalg.norm(np.ptp(solid.problem.mesh.points, axis=0)))
        self._gauge = (_GAUGE / (MU0 * diagonal**2)) * values.matrix(identity)
        self._factors = Factors()  # currents share an ordering

    @property
    def size(self) -> int:
        """Number of unknowns."""
        return self._curl.size

    def solve(self, current: float, start: MagneticField | None = None) -> MagneticField:
        """Field at `current` ampere-turns.

        Parameters
        ----------
        current : float
            Ampere-turns.
        start : MagneticField, optional
            A solution by this potential to start from, on the same mesh or one deformed.

        Raises SolverError if Newton's method does not arrive.
        """
        energy = _VectorEnergy(self._solid, self._curl, self._gauge, current)
        rest = np.zeros(self.size)
        first = rest if start is None or current == 0.0 else start.potential
        found = minimise(energy, first, self._factors)
        b = self._curl.field(found.x)
        return MagneticField(
            solid=self._solid,
            current=current,
            potential=found.x,
            flux_density=b,
            field_strength=field_from_flux(self._solid.iron, b),
            iterations=found.steps,
        )


def _free(solid: SampledSolid, dofs: Any) -> Ints:
    """Unknowns that are not on a wall that the flux cannot cross."""
    domain, normal = solid.domain, solid.problem.flux_normal
    open_walls = [domain.boundaries[name] for name in normal]
    walls = np.setdiff1d(domain.boundary_facets(), np.concatenate([[], *open_walls]).astype(int))
    held = dofs.get_facet_dofs(walls).flatten()
    return np.setdiff1d(np.arange(dofs.N), held)


class _VectorEnergy:
    """∫ w(curl A) − T0·curl A dV."""

    def __init__(
        self, solid: SampledSolid, curl: FieldKernel, gauge: Sparse, current: float
    ) -> None:
        self._solid, self._curl, self._gauge = solid, curl, gauge
        self._source = current * solid.source

    def value(self, x: Floats) -> float:
        flux = self._curl.field(x)
        density = energy_density(self._solid.iron, flux)
        density -= np.einsum("cqa,cqa->cq", self._source, flux)
        return float(np.sum(self._solid.weights * density))

    def scale(self, x: Floats) -> float:
        density = energy_density(self._solid.iron, self._curl.field(x))
        return float(np.sum(self._solid.weights * density))

    def gradient(self, x: Floats) -> Floats:
        h = field_from_flux(self._solid.iron, self._curl.field(x))
        return self._curl.functional(h - self._source)

    def hessian(self, x: Floats) -> Sparse:
        tensor = reluctivity_tensor(self._solid.iron, self._curl.field(x))
        matrix = self._curl.matrix(tensor)
        matrix.data += self._gauge.data  # one pattern, which a sum of matrices would thin out
        return matrix
