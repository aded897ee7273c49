"""Goal-oriented error estimate of tetrahedra, and its share by element.

A goal is a product of two solutions of one symmetric system: tip motion per voltage is the
response to U tested with the response to F_tip, compliance and capacitance are each response
tested with itself, a natural frequency its mode with itself.  Its error is then a(e_i, e_j)
of the two solutions' errors, so no further dual problem is solved; what each solution misses
is estimated by :mod:`fem.piezo.tetrahedra_error`.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from tactgen.fem.elements.skfem_mesh import SLOPES, tet_rule, to_skfem
from tactgen.fem.piezo.symmetry import SIGNS
from tactgen.fem.piezo.system import Material, SolidSystem, materials
from tactgen.fem.solvers.linear_solver import refined_solution
from tactgen.geometry.arrays import Floats, Ints, Sparse
from tactgen.geometry.device.parameters import Device
from tactgen.geometry.meshing.mesh import Mesh, find_rows
from tactgen.geometry.meshing.structured_tets import MIRRORS, mirror_axes

#: Elements worked on at a time: bounds the memory.
_CHUNK = 4000


@dataclass(frozen=True)
class CubicEstimator:
    """Residuals against the missing cubics, and the parts of the solutions found from them."""

    #: (n_functions, 4, n_fields) r(v) and e, the potential in the system's own unit.  e holds zero
    #: where the solution is prescribed
    residual: Floats
    missing: Floats
    functions_of_cell: Ints  #: (10, n_cells) The functions that live on each cell of the mesh

    def shares(self, i: int, j: int) -> Floats:
        """Contributions (n_cells,) to r_i(e_j), each function's spread evenly."""
        each = np.einsum("wp,wp->w", self.residual[:, :, i], self.missing[:, :, j])
        cells = np.bincount(self.functions_of_cell.ravel(), minlength=each.size)
        return np.asarray((each / np.maximum(cells, 1))[self.functions_of_cell].sum(axis=0))


def cubic_surplus(
    device: Device, mesh: Mesh, system: SolidSystem, fields: Floats, inertia: Floats, force: Floats
) -> CubicEstimator:
    """Hierarchical error estimate with cubic functions.

    `system` is lossless, assembled of this device on this mesh of tetrahedra, whole or a quarter.
    `fields` (n, n_fields) are solutions y of it, in its own unknowns.  Each has Ω² in `inertia`
    (n_fields,) in rad²/s² (its load is Ω² times its mass, 0 at rest) and in `force` (n_fields,) the
    lateral force on the tip (N), spread evenly over the tip face.
    """
    domain = to_skfem(mesh)
    n_edges = domain.edges.shape[1]
    unit = system.volts_per_unit
    scale = np.array([1.0, 1.0, 1.0, 1.0 / unit])
    nodal = (system.expand @ fields).reshape(4, -1, fields.shape[1]) * scale[:, None, None]
    nodal = nodal[:, : domain.p.shape[1] + n_edges]  # of a whole body, those of its quarter
    # of a quarter the integrals count four times, but that of the force, spread over all
    copies = 2.0 ** len(mirror_axes(mesh))
    shape = (n_edges + domain.facets.shape[1], 4)
    residual, diagonal = np.zeros((*shape, fields.shape[1])), np.zeros((*shape, 4))
    functions = np.concatenate([domain.t2e, n_edges + domain.t2f])
    known = materials(device, mesh.regions, device.piezo.ceramic(), lossy=False)
    for region, material in known.items():
        cells, tensor = domain.subdomains[region], material.flux_tensor(unit).real
        for start in range(0, cells.size, _CHUNK):
            some = cells[start : start + _CHUNK]
            r, d = _on_cells(domain, some, tensor, material, nodal, inertia)
            np.add.at(residual, functions[:, some], copies * r)
            np.add.at(diagonal, functions[:, some], copies * d)
    tip = domain.boundaries["tip"]
    a, b, c = (domain.p[:, domain.facets[k, tip]].T for k in range(3))
    area = np.linalg.norm(np.cross(b - a, c - a), axis=1)
    # the integral of the face function is 1/60 of the triangle's area
    residual[n_edges + tip, 0] += (area / area.sum() / 60.0)[:, None] * force
    _prescribe(residual, diagonal, slice(0, 3), _on_faces(domain, ["base"]))
    electrodes = _on_faces(domain, [name for name in mesh.faces if name.startswith("electrode")])
    without_field = np.flatnonzero(diagonal[:, 3, 3] == 0.0)
    _prescribe(residual, diagonal, slice(3, 4), np.union1d(electrodes, without_field))
    for axis, name in enumerate(MIRRORS):
        if name in mesh.faces:
            odd = np.array(SIGNS[system.motion][axis]) < 0
            for p in np.flatnonzero(odd):
                _prescribe(residual, diagonal, slice(p, p + 1), _on_faces(domain, [name]))
    return CubicEstimator(residual, np.linalg.solve(diagonal, residual), functions)


def _on_cells(
    domain: Any, cells: Ints, tensor: Floats, material: Material, nodal: Floats, inertia: Floats
) -> tuple[Floats, Floats]:
    """Residuals (10, n_cells, 4, n_fields) and diagonal blocks (10, n_cells, 4, 4)."""
    from skfem import Basis, ElementTetP2

    at, weights = tet_rule()
    basis = Basis(domain, ElementTetP2(), quadrature=(at, weights), elements=cells)
    values, slopes = _cubics(at, domain.refdom.edges, domain.refdom.facets)
    corners = domain.t[:, cells]
    ends = np.array(domain.refdom.edges)
    # an edge's function is odd along it: the same way round in all its elements
    sign = np.ones((10, cells.size))
    sign[:6] = np.where(corners[ends[:, 0]] < corners[ends[:, 1]], 1.0, -1.0)
    inverse = basis.mapping.invDF(at, tind=cells)
    slopes = np.einsum("wbn,batn,wt->watn", slopes, inverse, sign, optimize=True)
    gram = np.einsum("watn,wbtn,tn->wtab", slopes, slopes, basis.dx, optimize=True)
    blocks = np.einsum("paqb,wtab->wtpq", tensor, gram, optimize=True)
    # (component, local, cell, field) and (local, axis, cell, point)
    local = nodal[:, basis.element_dofs]
    own = np.stack([field.grad for (field,) in basis.basis])
    gradient = np.einsum("pltk,latn->patnk", local, own, optimize=True)
    flux = np.einsum("paqb,qbtnk,tn->patnk", tensor, gradient, basis.dx, optimize=True)
    residuals = -np.einsum("patnk,watn->wtpk", flux, slopes, optimize=True)
    shapes = np.stack([np.asarray(field)[0] for (field,) in basis.basis])
    moments = np.einsum("wn,ln,tn,wt->wlt", values, shapes, basis.dx, sign, optimize=True)
    load = np.einsum("wlt,pltk->wtpk", material.density * moments, local[:3], optimize=True)
    residuals[:, :, :3] += load * inertia
    return np.asarray(residuals), blocks


def _cubics(at: Floats, edges: Any, facets: Any) -> tuple[Floats, Floats]:
    """Values (10, n) and reference gradients (10, 3, n) of edge and face functions."""
    b = np.stack([1.0 - at.sum(axis=0), *at])
    values, by_coordinate = [], []
    for i, j in edges:
        values.append(b[i] * b[j] * (b[i] - b[j]))
        by_coordinate.append({i: 2.0 * b[i] * b[j] - b[j] ** 2, j: b[i] ** 2 - 2.0 * b[i] * b[j]})
    for i, j, k in facets:
        values.append(b[i] * b[j] * b[k])
        by_coordinate.append({i: b[j] * b[k], j: b[i] * b[k], k: b[i] * b[j]})
    slopes = [sum(np.outer(SLOPES[i], d) for i, d in each.items()) for each in by_coordinate]
    return np.array(values), np.array(slopes)


def _on_faces(domain: Any, names: list[str]) -> Ints:
    """Functions on the edges and faces of named boundaries."""
    facets = np.unique(np.concatenate([domain.boundaries[name] for name in names]))
    corners = np.sort(domain.facets[:, facets], axis=0)
    pairs = np.hstack([corners[[0, 1]], corners[[1, 2]], corners[[0, 2]]])
    edges = find_rows(pairs.T, np.sort(domain.edges, axis=0).T)
    return np.concatenate([np.unique(edges), domain.edges.shape[1] + facets])


def _prescribe(residual: Floats, diagonal: Floats, parts: slice, functions: Ints) -> None:
    """Make the given components of functions zero: nothing is missing where all is given."""
    residual[functions, parts] = 0.0
    diagonal[functions, parts, :] = diagonal[functions, :, parts] = 0.0
    for p in range(4)[parts]:
        diagonal[functions, p, p] = 1.0


#: Error over what cubics find of it.  At edges where the field is singular, and in layers as
#: thick as their elements, one degree more removes about half of the error.  Measured on job
#: J1: 1.1 to 2.2 on uniform, graded and adapted meshes of 6 000 to 150 000 unknowns, against
#: four codes' consensus and fine hexahedra (a test checks coarse ones).
#: At the sharp corners of the rod's slot it is about 3 on coarse meshes, by extrapolation, so
#: error bars are not taken from the estimate alone but from two meshes and the estimated gain.
SATURATION = 2.0
#: Share of a vector that must be new for it to extend a basis.
_NEW = 1e-8

#: Bending modes whose frequencies are goals.
_MODES = 2

#: Blocks of the Krylov space in which these modes are found.
_BLOCKS = 6


@dataclass(frozen=True)
class GoalError:
    """A goal on a mesh."""

    value: float  #: The goal's value, SI
    error: float  #: Estimated relative error, signed: value x (1 + error) is nearer to the truth
    #: (n_cells,) Relative contributions of the elements, not negative; they add up to the size of
    #: `error` or, where signs differ, to more
    shares: Floats


def goal_errors(device: Device, mesh: Mesh, system: SolidSystem) -> dict[str, GoalError]:
    """Goals and their estimated errors, base clamped, of a lossless system assembled on a mesh.

    They are ``tip_displacement`` (m/V), ``tip_compliance`` (m/N), ``capacitance`` (F), tip free,
    and the first ``bending_1`` … in Hz, electrodes short-circuited.
    """
    voltage, force = _static_responses(system)
    shapes, squares = _bending(system, voltage[:-3], force[:-3])
    fields = np.column_stack([voltage, force, np.vstack([shapes, np.zeros((3, squares.size))])])
    still = np.zeros(2)
    surplus = cubic_surplus(
        device,
        mesh,
        system,
        fields,
        inertia=np.concatenate([still, squares]),
        force=np.concatenate([[0.0, 1.0], np.zeros(squares.size)]),
    )
    moved, given = system.tip[:, 0], (system.stiffness @ voltage)[-1]
    found = {
        "tip_displacement": _goal(float(moved @ voltage), surplus.shares(0, 1), 1.0),
        "tip_compliance": _goal(float(moved @ force), surplus.shares(1, 1), 1.0),
        "capacitance": _goal(-float(given), surplus.shares(0, 0), 1.0),
    }
    if found["tip_displacement"].value == 0.0:  # a passive ceramic
        del found["tip_displacement"]
    for k, square in enumerate(squares):
        # modes have unit mass: a(e, e) is the error of Ω², and f goes with its root
        shares = surplus.shares(2 + k, 2 + k) / (2.0 * square)
        frequency = float(np.sqrt(square) / (2.0 * np.pi))
        found[f"bending_{k + 1}"] = _goal(frequency, frequency * shares, -1.0)
    return found


def mode_errors(
    device: Device, mesh: Mesh, system: SolidSystem, squares: Floats, shapes: Floats
) -> Floats:
    """Estimated relative errors (k,) of natural frequencies, each too high by so much.

    As :func:`goal_errors`, of one class of motion: `squares` (k,) are Ω² (rad²/s²), `shapes` (n -
    3, k) modes of unit mass, base clamped, electrodes short-circuited.
    """
    fields = np.vstack([shapes, np.zeros((system.size - len(shapes), squares.size))])
    surplus = cubic_surplus(
        device, mesh, system, fields, inertia=squares, force=np.zeros(squares.size)
    )
    missing = [float(surplus.shares(k, k).sum()) for k in range(squares.size)]
    return SATURATION * np.array(missing) / (2.0 * squares)


def _goal(value: float, shares: Floats, sign: float) -> GoalError:
    relative = SATURATION * shares / value if value else np.zeros_like(shares)
    return GoalError(value, sign * float(relative.sum()), np.abs(relative))


def _static_responses(system: SolidSystem) -> tuple[Floats, Floats]:
    """Y per volt and y per newton of lateral tip force, the base held."""
    loads = np.column_stack([-system.stiffness.border[:, -1], system.tip[:-3, 0]])
    x = refined_solution(system.stiffness.inner, system.held_factor, loads)
    return np.append(x[:, 0], [0.0, 0.0, 1.0]), np.append(x[:, 1], [0.0, 0.0, 0.0])


def _bending(system: SolidSystem, voltage: Floats, force: Floats) -> tuple[Floats, Floats]:
    """Modes (n - 3, k) of unit mass that the tip force moves most, and Ω² (k,).

    Rayleigh and Ritz in the Krylov space of the static responses: the first bending modes
    come out of it far better than the mesh deserves, and nothing is factorised again.
    """
    mass, factor = system.mass.inner, system.held_factor
    basis: Floats = np.zeros((voltage.size, 0))
    block = np.column_stack([voltage, force])
    for _ in range(_BLOCKS):
        basis = _mass_orthonormal(basis, block, mass)
        block = factor.solve(mass @ basis[:, -2:])
    flexible = basis.T @ (mass @ factor.solve(mass @ basis))
    inverses, vectors = np.linalg.eigh(0.5 * (flexible + flexible.T))
    moved = (vectors.T @ (basis.T @ system.tip[:-3, 0])) ** 2 * inverses
    chosen = np.argsort(-moved)[:_MODES]
    chosen = chosen[np.argsort(-inverses[chosen])]
    # one more inverse iteration also gives the potential that belongs to each mode
    shapes = factor.solve(mass @ (basis @ vectors[:, chosen]))
    shapes = shapes / np.sqrt(np.einsum("ij,ij->j", shapes, mass @ shapes))
    return shapes, np.einsum("ij,ij->j", shapes, system.stiffness.inner @ shapes)


def _mass_orthonormal(basis: Floats, block: Floats, mass: Sparse) -> Floats:
    """Extend a mass-orthonormal basis by a block of two vectors."""
    for column in block.T:
        before = np.sqrt(column @ (mass @ column))
        for _ in range(2):  # twice is enough (Kahan, Parlett)
            column = column - basis @ (basis.T @ (mass @ column))
        size = np.sqrt(column @ (mass @ column))
        if size > _NEW * before:  # a voltage that moves nothing adds nothing
            basis = np.column_stack([basis, column / size])
    return basis
