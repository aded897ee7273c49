"""A static magnetic field problem on tetrahedra, and what both potentials share of it.

    curl H = J,   div B = 0,   B and H parallel and tied by each region's curve.

The current enters by a source field T0 with curl T0 = J and nothing else asked of it, so
that H − T0 is a gradient and ∫ T0·curl v is a right side that any edge element can match
exactly.  The outer boundary and symmetry planes are of two kinds:

    flux-parallel (the rule)   B·n = 0
    flux-normal (by name)      (H − T0)×n = 0

Only what is known beforehand is here: quadrature points, T0 at them, materials.  The
potentials are in :mod:`fem.magnetics.vector_potential` and
:mod:`fem.magnetics.scalar_potential`.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from tactgen.fem.elements.skfem_mesh import tet_rule, to_skfem
from tactgen.fem.magnetics.iron import Iron, energy_density
from tactgen.geometry.arrays import Floats
from tactgen.geometry.device.steel_law import MagnetisationCurve
from tactgen.geometry.errors import InputError
from tactgen.geometry.meshing.mesh import TET_EDGES, Mesh

#: T0 (..., 3) in A/m at points (..., 3) in m, for one ampere-turn.
SourceField = Callable[[Floats], Floats]


@dataclass(frozen=True)
class MagneticSolid:
    """What is to be solved.

    Attributes
    ----------
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
        derivative = self.mapping.DF(self._few_points)
        return np.asarray(derivative.transpose(2, 3, 0, 1))

    @property
    def _few_points(self) -> Floats:
        straight = self.problem.mesh.kind == "tetra"
        return self.reference_points[:, :1] if straight else self.reference_points

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
