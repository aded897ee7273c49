"""Magnetic field by the scalar potential: H = T0 − grad φ with quadratic nodal elements.

Weak form, for all ψ:   ∫ B(T0 − grad φ)·grad ψ dV = 0,
which is where the co-energy ∫ w'(T0 − grad φ) dV is least (w' = ∫ B·dH).

The discrete H has the right curl and the discrete co-energy is too large: with the vector
potential, whose co-energy is too small, the exact one is enclosed.

T0 should vanish in iron, or be there the gradient of what the elements can represent:
where the two nearly cancel, T0's interpolation error would be the field.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from tactgen.fem.elements.pattern import FieldKernel, Pattern
from tactgen.fem.magnetics.iron import coenergy_density, flux_from_field, permeability_tensor
from tactgen.fem.magnetics.problem_3d import MagneticField, SampledSolid
from tactgen.fem.solvers.newton import Factors, minimise
from tactgen.geometry.arrays import Floats, Ints, Sparse


class ScalarPotential:
    """The problem assembled for φ; solve as many currents as wanted."""

    def __init__(self, solid: SampledSolid) -> None:
        from skfem import Dofs, ElementTetP2

        self._solid = solid
        dofs = Dofs(solid.domain, ElementTetP2())
        self._gradient = gradient_kernel(solid, dofs.element_dofs.T, _free(solid, dofs))
        self._factors = Factors()  # currents share an ordering

    @property
    def size(self) -> int:
        """Number of unknowns."""
        return self._gradient.size

    def solve(self, current: float, start: MagneticField | None = None) -> MagneticField:
        """Field at `current` ampere-turns; as :meth:`VectorPotential.solve`."""
        energy = _ScalarEnergy(self._solid, self._gradient, current)
        # H = T0 − grad φ keeps its shape from current to current only if φ grows with T0
        first = (
            energy.unsaturated(self._factors)
            if start is None or start.current == 0.0
            else start.potential * (current / start.current)
        )
        found = minimise(energy, first, self._factors)
        h = energy.field(found.x)
        return MagneticField(
            solid=self._solid,
            current=current,
            potential=found.x,
            flux_density=flux_from_field(self._solid.iron, h),
            field_strength=h,
            iterations=found.steps,
        )


def gradient_kernel(
    solid: SampledSolid, dofs: Ints, free: Ints, cells: Ints | slice = slice(None)
) -> FieldKernel:
    """Kernel of the gradients of quadratic nodal functions.

    Parameters
    ----------
    solid : SampledSolid
        The problem.
    dofs : (n_cells, 10) int
        Unknowns of all its cells.
    free : (n_free,) int
        Those that are solved for; the others are 0.
    cells : (n,) int, optional
        The cells over which to integrate, all by default.
    """
    from skfem import ElementTetP2

    element = ElementTetP2()
    local = [element.lbasis(solid.reference_points, i)[1] for i in range(10)]
    inverse = np.linalg.inv(solid.jacobians[cells])
    return FieldKernel(
        np.array(local),
        np.swapaxes(inverse, -1, -2),
        solid.weights[cells],
        Pattern(np.ascontiguousarray(dofs[cells]), free),
    )


def _free(solid: SampledSolid, dofs: Any) -> Ints:
    """All unknowns but those of flux-normal walls, or but one if there is no such wall."""
    normal = solid.problem.flux_normal
    if not normal:
        return np.arange(1, dofs.N)
    walls = np.concatenate([solid.domain.boundaries[name] for name in normal])
    return np.setdiff1d(np.arange(dofs.N), dofs.get_facet_dofs(walls).flatten())


class _ScalarEnergy:
    """∫ w'(T0 − grad φ) dV."""

    def __init__(self, solid: SampledSolid, gradient: FieldKernel, current: float) -> None:
        self._solid, self._gradient = solid, gradient
        self._source = current * solid.source

    def field(self, x: Floats) -> Floats:
        """H (n_cells, n_points, 3) in A/m."""
        return self._source - self._gradient.field(x)

    def value(self, x: Floats) -> float:
        density = coenergy_density(self._solid.iron, self.field(x))
        return float(np.sum(self._solid.weights * density))

    scale = value

    def gradient(self, x: Floats) -> Floats:
        return -self._gradient.functional(flux_from_field(self._solid.iron, self.field(x)))

    def hessian(self, x: Floats) -> Sparse:
        return self._gradient.matrix(permeability_tensor(self._solid.iron, self.field(x)))

    def unsaturated(self, factors: Factors) -> Floats:
        """Potential of the same iron with its initial permeability throughout.

        From φ = 0 the iron would see T0 alone and seem saturated where it is not.
        """
        tensor = permeability_tensor(self._solid.iron, np.zeros_like(self._source))
        driven = np.einsum("cqab,cqb->cqa", tensor, self._source)
        factors.update(self._gradient.matrix(tensor))
        return factors.solve(self._gradient.functional(driven))
