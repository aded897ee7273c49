"""What quadratic tetrahedra miss: their residual against the cubics that they lack.

A quadratic solution x of a(x, v) = f(v) leaves a residual r(v) = f(v) − a(x, v).  Tested with
the cubic functions that quadratics lack (one on each edge, one on each face), and each of
these functions taken alone, it gives the missing part e of the solution: one 4 x 4 system per
function, over (u_x, u_y, u_z, φ).  The hierarchical estimator of Bank and Smith (SIAM J.
Numer. Anal. 30, 1993); jumps of the stress between materials need no special care, since the
residual knows nothing of smoothness.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from tactgen.fem.bimorph.symmetry import SIGNS
from tactgen.fem.bimorph.system import Material, SolidSystem, materials
from tactgen.fem.elements.skfem_mesh import to_skfem
from tactgen.fem.elements.tet_quadrature import tet_rule
from tactgen.geometry.arrays import Floats, Ints
from tactgen.geometry.device.parameters import Device
from tactgen.geometry.meshing.mesh import Mesh
from tactgen.geometry.meshing.mirror import MIRRORS, is_quarter

#: Elements worked on at a time: bounds the memory.
_CHUNK = 4000

#: Gradients of the barycentric coordinates on the reference tetrahedron.
_SLOPES = np.array([[-1.0, -1.0, -1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]])


@dataclass(frozen=True)
class CubicSurplus:
    """Residuals against the missing cubics, and the parts of the solutions found from them.

    Attributes
    ----------
    residual, missing : (n_functions, 4, n_fields) array
        r(v) and e, the potential in the system's own unit.  e holds zero where the solution
        is prescribed.
    functions_of_cell : (10, n_cells) int array
        The functions that live on each cell of the mesh.
    """

    residual: Floats
    missing: Floats
    functions_of_cell: Ints

    def shares(self, i: int, j: int) -> Floats:
        """Return the contributions (n_cells,) to r_i(e_j), each function's spread evenly."""
        each = np.einsum("wp,wp->w", self.residual[:, :, i], self.missing[:, :, j])
        cells = np.bincount(self.functions_of_cell.ravel(), minlength=each.size)
        return np.asarray((each / np.maximum(cells, 1))[self.functions_of_cell].sum(axis=0))


def cubic_surplus(
    device: Device, mesh: Mesh, system: SolidSystem, fields: Floats, inertia: Floats, force: Floats
) -> CubicSurplus:
    """Return what the fields lack.

    Parameters
    ----------
    device : Device
        Materials and poling, as the system was assembled with.
    mesh : Mesh
        Tetrahedra, as the system was assembled on: whole, or a quarter.
    system : SolidSystem
        Lossless.
    fields : (n, n_fields) array
        Solutions y of the system, in its own unknowns.
    inertia : (n_fields,) array
        Ω² (rad²/s²) of each: its load is Ω² times its mass, 0 at rest.
    force : (n_fields,) array
        Lateral force on the tip (N) of each, spread evenly over the tip face.
    """
    domain = to_skfem(mesh)
    n_edges = domain.edges.shape[1]
    unit = system.volts_per_unit
    scale = np.array([1.0, 1.0, 1.0, 1.0 / unit])
    nodal = (system.expand @ fields).reshape(4, -1, fields.shape[1]) * scale[:, None, None]
    nodal = nodal[:, : domain.p.shape[1] + n_edges]  # of a whole body, those of its quarter
    # of a quarter the integrals count four times, but that of the force, spread over all
    copies = 4.0 if is_quarter(mesh) else 1.0
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
    return CubicSurplus(residual, np.linalg.solve(diagonal, residual), functions)


def _on_cells(
    domain: Any, cells: Ints, tensor: Floats, material: Material, nodal: Floats, inertia: Floats
) -> tuple[Floats, Floats]:
    """Return residuals (10, n_cells, 4, n_fields) and diagonal blocks (10, n_cells, 4, 4)."""
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
    """Return values (10, n) and reference gradients (10, 3, n) of edge and face functions."""
    b = np.stack([1.0 - at.sum(axis=0), *at])
    values, by_coordinate = [], []
    for i, j in edges:
        values.append(b[i] * b[j] * (b[i] - b[j]))
        by_coordinate.append({i: 2.0 * b[i] * b[j] - b[j] ** 2, j: b[i] ** 2 - 2.0 * b[i] * b[j]})
    for i, j, k in facets:
        values.append(b[i] * b[j] * b[k])
        by_coordinate.append({i: b[j] * b[k], j: b[i] * b[k], k: b[i] * b[j]})
    slopes = [sum(np.outer(_SLOPES[i], d) for i, d in each.items()) for each in by_coordinate]
    return np.array(values), np.array(slopes)


def _on_faces(domain: Any, names: list[str]) -> Ints:
    """Return the functions on the edges and faces of named boundaries."""
    facets = np.unique(np.concatenate([domain.boundaries[name] for name in names]))
    corners = np.sort(domain.facets[:, facets], axis=0)
    pairs = np.hstack([corners[[0, 1]], corners[[1, 2]], corners[[0, 2]]])
    ends = np.sort(domain.edges, axis=0)
    stride = int(ends.max()) + 1
    keys = ends[0] * stride + ends[1]
    order = np.argsort(keys)
    edges = order[np.searchsorted(keys, pairs[0] * stride + pairs[1], sorter=order)]
    return np.concatenate([np.unique(edges), ends.shape[1] + facets])


def _prescribe(residual: Floats, diagonal: Floats, parts: slice, functions: Ints) -> None:
    """Make the given components of functions zero: nothing is missing where all is given."""
    residual[functions, parts] = 0.0
    diagonal[functions, parts, :] = diagonal[functions, :, parts] = 0.0
    for p in range(4)[parts]:
        diagonal[functions, p, p] = 1.0
