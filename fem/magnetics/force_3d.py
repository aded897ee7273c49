"""Force on a body in a static magnetic field, by stress.

Let g be 1 on the body and 0 on everything else that is iron or carries current, and
harmonic in the air between, the shell.  Maxwell's stress T = µ0 (H Hᵀ − H²/2) is free
of divergence there, so

    F = ∮ T·n dS = −∫ T·grad g dV                                    (eggshell)

over any surface in the shell: an average over all of them.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from tactgen.fem.magnetics.problem_3d import (
    MagneticField,
    SampledSolid,
    gradient_kernel,
    with_sorted_corners,
)
from tactgen.fem.solvers.linear_solver import factorise
from tactgen.geometry.arrays import Floats, Ints
from tactgen.geometry.device.magnetisation import MU0
from tactgen.geometry.errors import InputError
from tactgen.geometry.meshing.mesh import Mesh

#: Sine of the largest angle between a direction and a face that counts as parallel.
_PARALLEL = 1e-9


@dataclass(frozen=True)
class MotionWeight:
    """Virtual displacement of each point for a unit motion of the body."""

    nodal: Floats  #: (n_points,) At the points of the mesh
    gradient: Floats  #: (n_cells, n_points, 3) Gradient (1/m) at the quadrature points
    touched: Floats  #: (n_faces, 3) Unit normals of the outer faces on which the weight is not zero


def harmonic_weight(
    solid: SampledSolid, body: tuple[str, ...], shell: tuple[str, ...]
) -> MotionWeight:
    """Weight that is 1 on `body`, harmonic in `shell` and 0 elsewhere.

    The body's regions move as one, windings among them.  Those of the shell, around it, have
    neither iron nor current; they may touch the outer boundary at symmetry planes along which the
    body moves, and nowhere else.

    Raises InputError if the mesh lacks a region, or iron is in the shell.
    """
    from skfem import Dofs, ElementTetP2

    mesh = solid.problem.mesh
    _check(solid, body, shell)
    numbering = Dofs(solid.domain, ElementTetP2())
    in_shell = np.concatenate([mesh.cells_of(name) for name in shell])
    in_body = np.concatenate([mesh.cells_of(name) for name in body])
    outside = np.setdiff1d(np.arange(mesh.cells.shape[0]), np.concatenate([in_shell, in_body]))
    dofs = numbering.element_dofs.T
    value = np.zeros(numbering.N)
    value[dofs[in_body]] = 1.0
    free = np.setdiff1d(dofs[in_shell], dofs[np.concatenate([in_body, outside])])

    # elsewhere the weight is constant
    known = np.unique(dofs[in_shell])
    gradients = gradient_kernel(solid, dofs, known, in_shell)
    gradient = np.zeros((*solid.weights.shape, 3))
    identity = np.broadcast_to(np.eye(3), (*gradient[in_shell].shape, 3))
    matrix, place = gradients.matrix(identity), np.searchsorted(known, free)
    right = -(matrix @ value[known])[place]
    value[free] = factorise(matrix[place][:, place], definite=True).solve(right)
    gradient[in_shell] = gradients.field(value[known])
    return MotionWeight(
        nodal=_at_mesh_points(mesh, value, dofs),
        gradient=gradient,
        touched=_touched(solid, numbering, value),
    )


def _check(solid: SampledSolid, body: tuple[str, ...], shell: tuple[str, ...]) -> None:
    mesh = solid.problem.mesh
    for name in (*body, *shell):
        if name not in mesh.regions:
            raise InputError(
                f"the mesh has no region '{name}' to take a force from; "
                f"use some of {', '.join(mesh.regions)}"
            )
    for name in shell:
        if name in solid.problem.materials:
            raise InputError(f"shell names '{name}', which is iron; use regions of air")


def _at_mesh_points(mesh: Mesh, value: Floats, dofs: Ints) -> Floats:
    """Quadratic nodal values at the mesh's points, straight cells having corners only."""
    cells = with_sorted_corners(mesh).cells
    nodal = np.zeros(mesh.points.shape[0])
    # corners first, then edges in the order that VTK's mid-edge nodes have too
    nodal[cells] = value[dofs[:, : cells.shape[1]]]
    return nodal


def _touched(solid: SampledSolid, numbering: Any, value: Floats) -> Floats:
    """Unit normals (n, 3) of the outer faces where the quadratic `value` is not zero."""
    domain = solid.domain
    faces = domain.boundary_facets()
    corners = domain.facets[:, faces]
    vertices, edges = numbering.nodal_dofs[0], numbering.edge_dofs[0]
    nodes = np.concatenate([vertices[corners], edges[domain.f2e[:, faces]]])
    a, b, c = domain.p[:, corners[:, np.any(value[nodes] != 0.0, axis=0)]].transpose(1, 2, 0)
    normal = np.cross(b - a, c - a)
    return np.asarray(normal / np.linalg.norm(normal, axis=1, keepdims=True))


def eggshell_force(field: MagneticField, weight: MotionWeight, direction: Floats) -> float:
    """Force (N) on the body along the unit vector `direction` (3,).

    Raises InputError if the shell touches an outer face that is not parallel to the direction:
    stress on that face would be missed.
    """
    h, slope = field.field_strength, weight.gradient
    along = np.asarray(direction, dtype=float)
    if np.any(np.abs(weight.touched @ along) > _PARALLEL):
        raise InputError(
            "the shell touches an outer face of the mesh that is not parallel to the force; "
            "leave a layer of other air in front of that face"
        )
    stress = (h @ along) * np.einsum("cqa,cqa->cq", h, slope)
    stress -= 0.5 * np.einsum("cqa,cqa->cq", h, h) * (slope @ along)
    return -MU0 * field.solid.integral(stress)
