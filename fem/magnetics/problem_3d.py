"""Magnetostatic problem on tetrahedra, by vector or scalar potential.

    curl H = J,   div B = 0,   B and H parallel and tied by each region's curve.

The current enters by a source field T0 with curl T0 = J and nothing else asked of it, so
that H − T0 is a gradient and ∫ T0·curl v is a right side that any edge element can match
exactly.  The outer boundary and symmetry planes are of two kinds:

    flux-parallel (the rule)   B·n = 0
    flux-normal (by name)      (H − T0)×n = 0
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from tactgen.fem.elements.pattern import FieldKernel, Pattern
from tactgen.fem.elements.skfem_mesh import ElementTetEdge2, tet_rule, to_skfem
from tactgen.fem.magnetics.axisymmetric_space import (
    Iron,
    coenergy_density,
    energy_density,
    field_from_flux,
    flux_from_field,
    permeability_tensor,
    reluctivity_tensor,
)
from tactgen.fem.solvers.newton import Factors, minimise
from tactgen.geometry.arrays import Floats, Ints, Sparse
from tactgen.geometry.device.magnetisation import MU0, MagnetisationCurve
from tactgen.geometry.errors import InputError
from tactgen.geometry.meshing.mesh import TET_EDGES, Mesh

#: T0 (..., 3) in A/m at points (..., 3) in m, for one ampere-turn.
SourceField = Callable[[Floats], Floats]


@dataclass(frozen=True)
class MagneticSolid:
    """Magnetic problem of a solid model.

    Raises InputError if the mesh is not made of tetrahedra or lacks a region or face that is named.
    """

    mesh: Mesh  #: Tetrahedra, straight or curved
    #: Curve of each iron region; regions not named have the permeability of vacuum
    materials: Mapping[str, MagnetisationCurve]
    source: SourceField  #: T0 for one ampere-turn
    #: Named faces of the mesh where (H − T0)×n = 0; B·n = 0 on the rest of the boundary
    flux_normal: tuple[str, ...] = ()
    #: How many times the mesh fits into the device; energies, flux and forces are those of the
    #: whole device
    copies: int = 1

    def __post_init__(self) -> None:
        if self.mesh.kind == "hexahedron":
            raise InputError("mesh.kind = hexahedron has no edge elements here; use tetrahedra")
        for field, named, known in (
            ("materials", tuple(self.materials), self.mesh.regions),
            ("flux_normal", self.flux_normal, tuple(self.mesh.faces)),
        ):
            unknown = [name for name in named if name not in known]
            if unknown:
                raise InputError(
                    f"{field} names '{unknown[0]}', which the mesh does not have; "
                    f"use some of {', '.join(known)}"
                )


@dataclass(frozen=True)
class SampledSolid:
    """The problem at its quadrature points."""

    problem: MagneticSolid  #: What is sampled
    domain: Any  #: Corners of its cells are in increasing order
    mapping: Any  #: From the reference cell
    reference_points: Floats  #: (3, n_points) Quadrature points on the reference cell
    points: Floats  #: (n_cells, n_points, 3) The same in the device (m)
    weights: Floats  #: (n_cells, n_points) Their volumes (m³)
    source: Floats  #: (n_cells, n_points, 3) T0 for one ampere-turn (A/m)

    @cached_property
    def jacobians(self) -> Floats:
        """Derivatives (n_cells, n_points or 1, 3, 3) of the mapping; 1 where cells are straight."""
        straight = self.problem.mesh.kind == "tetra"
        points = self.reference_points[:, :1] if straight else self.reference_points
        return np.asarray(self.mapping.DF(points).transpose(2, 3, 0, 1))

    @cached_property
    def iron(self) -> Iron:
        """Cells and curve of each region that is not vacuum."""
        mesh = self.problem.mesh
        return [(mesh.cells_of(name), curve) for name, curve in self.problem.materials.items()]

    def integral(self, density: Floats) -> float:
        """∫ density dV over the whole device, density (n_cells, n_points)."""
        return float(self.problem.copies * np.sum(self.weights * density))


def sample(problem: MagneticSolid) -> SampledSolid:
    """Place the quadrature points and evaluate the source there."""
    domain = to_skfem(with_sorted_corners(problem.mesh))
    mapping = domain.mapping()
    # degree 2 would do for linear fields on straight cells; the rest is for the bend of the
    # steel's curve inside a cell, for curved cells and for the source
    reference, weights = tet_rule()
    points = np.ascontiguousarray(mapping.F(reference).transpose(1, 2, 0))
    return SampledSolid(
        problem=problem,
        domain=domain,
        mapping=mapping,
        reference_points=reference,
        points=points,
        weights=np.abs(mapping.detDF(reference)) * weights,
        source=problem.source(points),
    )


def with_sorted_corners(mesh: Mesh) -> Mesh:
    """Mesh with each cell's corners in increasing order, which may turn it inside out.

    Edge elements then need no signs.
    """
    order = np.argsort(mesh.cells[:, :4], axis=1)
    cells = np.take_along_axis(mesh.cells[:, :4], order, axis=1)
    if mesh.kind == "tetra10":
        edge_between = np.zeros((4, 4), dtype=int)
        for edge, (a, b) in enumerate(TET_EDGES):
            edge_between[a, b] = edge_between[b, a] = edge
        moved = edge_between[order[:, TET_EDGES[:, 0]], order[:, TET_EDGES[:, 1]]]
        cells = np.hstack([cells, np.take_along_axis(mesh.cells[:, 4:], moved, axis=1)])
    return replace(mesh, cells=cells)


@dataclass(frozen=True)
class MagneticField:
    """A solution at the quadrature points."""

    solid: SampledSolid  #: Where it lives
    current: float  #: Ampere-turns
    potential: Floats  #: (n_unknowns,) Free unknowns, from which the next current may start
    #: (n_cells, n_points, 3) B (T) and H (A/m)
    flux_density: Floats
    field_strength: Floats
    iterations: int  #: Newton steps taken

    @property
    def energy(self) -> float:
        """∫∫ H·dB dV (J)."""
        return self.solid.integral(energy_density(self.solid.iron, self.flux_density))

    @property
    def coenergy(self) -> float:
        """∫∫ B·dH dV (J): too small by the vector, too large by the scalar potential."""
        h_dot_b = np.einsum("cqa,cqa->cq", self.field_strength, self.flux_density)
        return self.solid.integral(h_dot_b) - self.energy

    @property
    def flux_linkage(self) -> float:
        """Flux linkage per turn (Wb), ∫ T0·B dV for one ampere-turn."""
        linked = np.einsum("cqa,cqa->cq", self.solid.source, self.flux_density)
        return self.solid.integral(linked)

    def flux_density_at(self, points: Floats) -> Floats:
        """B (n, 3) in T at points (n, 3) in m within the mesh.

        On a straight cell curl A is linear, and so is grad φ: the values at its quadrature points
        determine them.  On curved cells, and where T0 bends within a cell, the linear fit in
        reference coordinates is an approximation of the same order as the field itself.
        """
        solid = self.solid
        cells = solid.domain.element_finder(mapping=solid.mapping)(*points.T)
        local = solid.mapping.invF(points.T[:, :, None], tind=cells)[:, :, 0]
        fit = np.linalg.pinv(_linear(solid.reference_points))
        coefficients = np.einsum("kq,cqa->cka", fit, self.flux_density[cells])
        return np.asarray(np.einsum("ck,cka->ca", _linear(local), coefficients))


def _linear(points: Floats) -> Floats:
    """1, x, y, z (n, 4) at points (3, n)."""
    return np.concatenate([np.ones((1, points.shape[1])), points]).T


#: ε times the square of the mesh's diagonal.  What a Newton step misses because of the added
#: term is about this times a relative permeability; far smaller values cost digits in the
#: factors.
_GAUGE = 1e-4


class VectorPotential:
    """The problem assembled for A; solve as many currents as wanted."""

    def __init__(self, solid: SampledSolid) -> None:
        from skfem import Dofs

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

        `start` is a solution by this potential to start from, on the same mesh or one deformed.

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


class ScalarPotential:
    """The problem assembled for φ; solve as many currents as wanted."""

    def __init__(self, solid: SampledSolid) -> None:
        from skfem import Dofs, ElementTetP2

        self._solid = solid
        dofs = Dofs(solid.domain, ElementTetP2())
        self._gradient = gradient_kernel(solid, dofs.element_dofs.T, _free_nodes(solid, dofs))
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
    """Kernel of the gradients of quadratic nodal functions, over some cells (n,) or all.

    `dofs` (n_cells, 10) are the unknowns of all cells, `free` (n_free,) those that are solved for;
    the others are 0.
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


def _free_nodes(solid: SampledSolid, dofs: Any) -> Ints:
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
