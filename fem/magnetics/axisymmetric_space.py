"""Shape functions on an axisymmetric grid, tabulated for the unknown u = A_φ / r.

Functions and their curls at the quadrature points, flux linkages, where the cells'
matrices go.  scikit-fem gives functions and numbering; its hierarchical functions of
order p − 1 are among those of order p.  No material, no solution.
"""

from __future__ import annotations

import logging
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from tactgen.fem.elements.pattern import Pattern
from tactgen.geometry.arrays import Floats, Ints
from tactgen.geometry.device.magnetisation import MU0, MagnetisationCurve
from tactgen.geometry.reluctance.section_grid import Grid

#: Cells (n,) and their curve, for each region that is not vacuum.
Iron = Sequence[tuple[Ints, MagnetisationCurve]]


def size_of(vectors: Floats) -> Floats:
    """Sizes (...) of vectors (..., k) of few components, in a tenth of norm's time."""
    return np.asarray(np.sqrt(sum(part * part for part in np.moveaxis(vectors, -1, 0))))


def energy_density(iron: Iron, flux_density: Floats) -> Floats:
    """∫ H·dB (n_cells, n_points) in J/m³ from B (n_cells, n_points, 3) in T."""
    b = size_of(flux_density)
    density = 0.5 * b**2 / MU0
    for cells, curve in iron:
        density[cells] = curve.energy_density(b[cells])
    return np.asarray(density)


def coenergy_density(iron: Iron, field_strength: Floats) -> Floats:
    """∫ B·dH (n_cells, n_points) in J/m³ from H (n_cells, n_points, 3) in A/m."""
    h = size_of(field_strength)
    density = 0.5 * MU0 * h**2
    for cells, curve in iron:
        density[cells] = curve.coenergy_density(curve.flux_density_at(h[cells]))
    return np.asarray(density)


def field_from_flux(iron: Iron, flux_density: Floats) -> Floats:
    """H (n_cells, n_points, 3) in A/m from B in T."""
    field = flux_density / MU0
    for cells, curve in iron:
        b = size_of(flux_density[cells])
        field[cells] = curve.reluctivity(b)[..., None] * flux_density[cells]
    return field


def flux_from_field(iron: Iron, field_strength: Floats) -> Floats:
    """B (n_cells, n_points, 3) in T from H in A/m."""
    flux = MU0 * field_strength
    for cells, curve in iron:
        b = curve.flux_density_at(size_of(field_strength[cells]))
        flux[cells] = field_strength[cells] / curve.reluctivity(b)[..., None]
    return flux


def reluctivity_tensor(iron: Iron, flux_density: Floats) -> Floats:
    """DH/dB (n_cells, n_points, 3, 3), or 2, 2, in m/H."""
    axes = flux_density.shape[-1]
    tensor = np.zeros((*flux_density.shape, axes))
    tensor[...] = np.eye(axes) / MU0
    for cells, curve in iron:
        b = size_of(flux_density[cells])
        tensor[cells] = _isotropic(flux_density[cells], curve.slope(b), curve.reluctivity(b))
    return tensor


def permeability_tensor(iron: Iron, field_strength: Floats) -> Floats:
    """DB/dH (n_cells, n_points, 3, 3) in H/m."""
    tensor = np.zeros((*field_strength.shape, 3))
    tensor[...] = MU0 * np.eye(3)
    for cells, curve in iron:
        b = curve.flux_density_at(size_of(field_strength[cells]))
        tensor[cells] = _isotropic(
            field_strength[cells], 1.0 / curve.slope(b), 1.0 / curve.reluctivity(b)
        )
    return tensor


def share_beyond_table(iron: Iron, flux_density: Floats, volumes: Floats) -> float:
    """Share of the iron's volume beyond the end of a curve that ends early, from B in T.

    B is (n_cells, n_points, 3) or 2, volumes (n_cells, n_points) in m³.
    """
    beyond = total = 0.0
    for cells, curve in iron:
        beyond += curve.volume_beyond(size_of(flux_density[cells]), volumes[cells])
        total += float(volumes[cells].sum())
    return beyond / total


def _isotropic(vector: Floats, along: Floats, across: Floats) -> Floats:
    """Tensor (..., k, k) that is `along` in the vector's direction, else `across`."""
    size = size_of(vector)[..., None]
    unit = vector / np.where(size > 0.0, size, 1.0)
    outer = unit[..., :, None] * unit[..., None, :]
    return np.asarray(
        across[..., None, None] * np.eye(vector.shape[-1])
        + (along - across)[..., None, None] * outer
    )


@dataclass(frozen=True)
class ReferenceCell:
    """Shape functions on a cell of width and height 1, the same for all cells of a grid."""

    #: (n_q,) Quadrature points along r and z, from 0 to 1, and their weights, which sum to 1
    across: Floats
    levels: Floats
    weights: Floats
    #: (n_q, n_b) Functions and their slopes along both sides
    shape: Floats
    slope_r: Floats
    slope_z: Floats

    @cached_property
    def values(self) -> Floats:
        """Functions, then their slopes along both sides, (n_b, 3 n_q)."""
        return np.concatenate([self.shape, self.slope_r, self.slope_z]).T.copy()

    @cached_property
    def products(self) -> Floats:
        """Products of two of these for the six pairs of kinds, symmetric, (6 n_q, n_b²)."""
        u, r, z = self.shape, self.slope_r, self.slope_z
        pairs = ((u, u), (u, r), (r, r), (z, z), (u, z), (r, z))
        half = np.concatenate([np.einsum("qi,qj->qij", *pair) for pair in pairs])
        both = 0.5 * (half + half.transpose(0, 2, 1))
        return np.asarray(both.reshape(both.shape[0], -1))

    def of_functions(self, chosen: Sequence[int]) -> ReferenceCell:
        """Restriction to some of the functions."""
        tables = (table[:, chosen] for table in (self.shape, self.slope_r, self.slope_z))
        return ReferenceCell(self.across, self.levels, self.weights, *tables)


@dataclass(frozen=True)
class Discretisation:
    """Shape functions of one order on one grid, as tables at the quadrature points.

    Shapes: n_e cells (r slow, z fast), n_q points per cell, n_b functions per cell.
    """

    grid: Grid
    order: int
    reference: ReferenceCell
    cell_dofs: Ints  #: (n_e, n_b) Unknown of each function
    volumes: Floats  #: (n_e, n_q) 2π r × quadrature weight (m³)
    radii: Floats  #: (n_e, n_q) Distance of the points from the axis (m)
    loads: Floats  #: (n_coils, n_e, n_b) Flux linkage of each function of each cell
    free: Ints  #: (n_free,) Unknowns not held at 0 by the boundary
    pattern: Pattern  #: Where the cells' matrices go

    @property
    def size(self) -> int:
        """Number of unknowns, held ones included."""
        return int(self.cell_dofs.max()) + 1

    @cached_property
    def cell_labels(self) -> Ints:
        """Region of each cell (n_e,), −1 for air."""
        return self.grid.labels.ravel()

    @cached_property
    def iron(self) -> Iron:
        """Cells and curve of each region that is not vacuum."""
        curves = [(i, region.curve) for i, region in enumerate(self.grid.regions)]
        return [(np.flatnonzero(self.cell_labels == i), c) for i, c in curves if c is not None]

    @cached_property
    def iron_cells(self) -> Ints:
        """All cells of iron, in the order of `iron`."""
        return np.concatenate([np.zeros(0, dtype=int), *(cells for cells, _ in self.iron)])

    @cached_property
    def vacuum_entries(self) -> Floats:
        """Constant Hessian entries of cells without iron."""
        empty = np.setdiff1d(np.arange(self.cell_dofs.shape[0]), self.iron_cells)
        reference, widths = self.reference, np.diff(self.grid.r)[:, None]
        radii = self.grid.r[:-1, None] + widths * reference.across
        volumes = (2.0 * np.pi / MU0 * widths * radii * reference.weights)[..., None]
        curl_z = 2.0 * reference.shape + (radii / widths)[..., None] * reference.slope_r
        curl_r = radii[..., None] * reference.slope_z
        local = self.of_columns(
            curl_r.transpose(0, 2, 1) @ (volumes * curl_r),
            curl_z.transpose(0, 2, 1) @ (volumes * curl_z),
            empty,
        )
        return self.pattern.part(empty).entries(local)

    def of_columns(self, over: Floats, times: Floats, cells: Ints) -> Floats:
        """Matrices of some cells, over / height + times × height of those of their columns.

        What is the same over a column of cells but for their heights is integrated once a column.
        """
        columns, heights = cells // (self.grid.z.size - 1), self.heights[cells, None, None]
        return over[columns] / heights + times[columns] * heights

    @cached_property
    def iron_pattern(self) -> Pattern:
        """Where the matrices of the cells of iron go."""
        return self.pattern.part(self.iron_cells)

    @cached_property
    def linkage(self) -> Floats:
        """Flux linkage of each unknown, (n_coils, n_dofs)."""
        return np.array([gathered(self.cell_dofs, load, self.size) for load in self.loads])

    @cached_property
    def heights(self) -> Floats:
        """Height of each cell (n_e,) in m."""
        return np.tile(np.diff(self.grid.z), self.grid.r.size - 1)

    @property
    def elevations(self) -> Floats:
        """Height z of the quadrature points (n_e, n_q) in m."""
        low = np.tile(self.grid.z[:-1], self.grid.r.size - 1)
        return low[:, None] + self.heights[:, None] * self.reference.levels

    @cached_property
    def _over_sides(self) -> tuple[Floats, Floats]:
        """Radii over width and over height of their cells, (n_e, n_q) each."""
        widths = np.repeat(np.diff(self.grid.r), self.grid.z.size - 1)
        return self.radii / widths[:, None], self.radii / self.heights[:, None]

    def flux_density(self, local: Floats) -> Floats:
        """B (n_e, n_q, 2) from the cells' unknowns (n_e, n_b)."""
        u, slope_r, slope_z = np.split(local @ self.reference.values, 3, axis=1)
        over_width, over_height = self._over_sides
        return np.stack([-over_height * slope_z, 2.0 * u + over_width * slope_r], axis=-1)

    def functional(self, field: Floats) -> Floats:
        """∫ H·B_i dV (n_e, n_b) of each cell and function, field (n_e, n_q, 2)."""
        over_width, over_height = self._over_sides
        along, across = field[..., 1] * self.volumes, field[..., 0] * self.volumes
        parts = [2.0 * along, over_width * along, -over_height * across]
        return np.asarray(np.concatenate(parts, axis=1) @ self.reference.values.T)

    def matrices(self, tensor: Floats, cells: Ints) -> Floats:
        """∫ B_i·tensor B_j dV (n, n_b²) of some cells, tensor (n, n_q, 2, 2) symmetric."""
        width, height = (over[cells] for over in self._over_sides)
        weighted = tensor * self.volumes[cells][..., None, None]
        rr, rz, zz = weighted[..., 0, 0], weighted[..., 0, 1], weighted[..., 1, 1]
        parts = [4.0 * zz, 4.0 * width * zz, width**2 * zz, height**2 * rr, -4.0 * height * rz,
                 -2.0 * width * height * rz]  # fmt: skip
        return np.asarray(np.concatenate(parts, axis=1) @ self.reference.products)

    def on(self, grid: Grid) -> Discretisation:
        """The same space on a grid with moved lines."""
        return replace(self, grid=grid, **_tables(grid, self.reference))


def _tables(grid: Grid, reference: ReferenceCell) -> dict[str, Any]:
    """Geometry-dependent part of a discretisation."""
    widths, heights = np.diff(grid.r), np.diff(grid.z)
    radii = grid.r[:-1, None] + widths[:, None] * reference.across
    section = widths[:, None] * heights
    labels = grid.labels.ravel()
    # of each column of cells, which differ in their heights only
    volumes = 2.0 * np.pi * radii * reference.weights
    linked = (volumes * radii) @ reference.shape
    of_cells = (section[..., None] * linked[:, None]).reshape(labels.size, -1)
    loads = [
        np.where((labels == index)[:, None], region.turns / region.section * of_cells, 0.0)
        for index, region in enumerate(grid.regions)
        if region.turns
    ]
    n_q, n_b = reference.shape.shape
    return {
        "volumes": (section[..., None] * volumes[:, None]).reshape(-1, n_q),
        "radii": np.repeat(radii, heights.size, axis=0),
        "loads": np.array(loads).reshape(-1, labels.size, n_b),
    }


def discretise(
    grid: Grid, order: int, closed: tuple[str, ...] = ("outer", "bottom", "top")
) -> Discretisation:
    """Put shape functions of an order, at least 1, in each direction on a grid.

    The flux does not cross the sides that are closed (A_φ = 0), of ``outer``, ``bottom`` and
    ``top``; on the others the tangential H is zero.
    """
    from skfem import Basis, ElementQuadP, MeshQuad

    # scikit-fem recommends its nodal elements for low orders; those are not nested
    logging.getLogger(ElementQuadP.__module__).setLevel(logging.ERROR)
    mesh = MeshQuad.init_tensor(grid.r, grid.z)
    # the tables are made from one cell: all cells have its functions, stretched; the degree of
    # r³ × (order p)² along r for linear material
    degree = 2 * order + 3
    basis = Basis(mesh, ElementQuadP(order), intorder=degree, elements=np.array([0]))
    reference = _reference_cell(basis)
    corner = mesh.p[:, mesh.t].min(axis=1)
    order_of_cells = np.lexsort((corner[1], corner[0]))  # by r, then z
    cell_dofs = basis.dofs.element_dofs.T[order_of_cells].astype(np.int64)
    free = np.setdiff1d(np.arange(basis.N), _held(basis, grid, closed))
    return Discretisation(
        grid=grid,
        order=order,
        reference=reference,
        cell_dofs=cell_dofs,
        free=free,
        pattern=Pattern(cell_dofs, free),
        **_tables(grid, reference),
    )


def _reference_cell(basis: Any) -> ReferenceCell:
    """Functions of a basis with one cell, as of a cell of size 1."""
    corners = basis.mesh.p[:, basis.mesh.t[:, 0]]
    low, size = corners.min(axis=1), np.ptp(corners, axis=1)
    places = (np.asarray(basis.global_coordinates())[:, 0] - low[:, None]) / size[:, None]
    shape, slope_r, slope_z = (
        np.stack([np.broadcast_to(read(b[0]), basis.dx.shape)[0] for b in basis.basis], axis=-1)
        for read in (np.asarray, lambda f: size[0] * f.grad[0], lambda f: size[1] * f.grad[1])
    )
    weights = basis.dx[0] / np.prod(size)
    return ReferenceCell(places[0], places[1], weights, shape, slope_r, slope_z)


def _held(basis: Any, grid: Grid, closed: tuple[str, ...]) -> Ints:
    sides = {"outer": (0, grid.r[-1]), "bottom": (1, grid.z[0]), "top": (1, grid.z[-1])}
    held = [
        basis.get_dofs(
            basis.mesh.facets_satisfying(
                lambda x, axis=axis, at=at: x[axis] == at, boundaries_only=True
            )
        ).all()
        for axis, at in (sides[side] for side in closed)
    ]
    return np.unique(np.concatenate([np.zeros(0, dtype=np.int64), *held]))


def gathered(cell_dofs: Ints, values: Floats, size: int) -> Floats:
    """Sum (size,) of the cells' vectors (n_e, n_b)."""
    summed = np.bincount(cell_dofs.ravel(), values.ravel(), minlength=size)
    return np.asarray(summed, dtype=float)


def lowered(fine: Discretisation) -> tuple[Discretisation, Ints]:
    """Functions one order lower, and which unknowns of `fine` theirs are.

    The tables are parts of the finer ones, at the same quadrature points.
    """
    local, cell_dofs, kept = functions_of_order(fine, fine.order - 1)
    free = np.flatnonzero(np.isin(kept, fine.free))
    coarse = replace(
        fine,
        order=fine.order - 1,
        reference=fine.reference.of_functions(local),
        cell_dofs=cell_dofs,
        loads=fine.loads[..., local],
        free=free,
        pattern=Pattern(cell_dofs, free),
    )
    return coarse, kept


def functions_of_order(fine: Discretisation, order: int) -> tuple[list[int], Ints, Ints]:
    """Cell functions of one order, their unknowns, and those in `fine`."""
    place = {mode: i for i, mode in enumerate(_modes(fine.order))}
    local = [place[mode] for mode in _modes(order)]
    kept, cell_dofs = np.unique(fine.cell_dofs[:, local], return_inverse=True)
    return local, cell_dofs.reshape(-1, len(local)), kept


def _modes(order: int) -> list[tuple[int, ...]]:
    """Mode numbers of a cell's functions, in scikit-fem's order."""
    inner = range(2, order + 1)
    corners = [(corner,) for corner in range(4)]
    sides = [(side, degree) for side in range(4) for degree in inner]
    return [*corners, *sides, *((0, a, b) for a in inner for b in inner)]
