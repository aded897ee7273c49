"""Manufactured solutions of the piezoelectric solid.

Smooth displacement and potential on a cube, with their own values on all walls, at rest or at one
frequency with losses; and the resonance of a plate, whose exact frequency is known.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cache, reduce
from typing import Any, Literal

import numpy as np
from scipy import sparse

from tactgen.fem.elements.line_basis import gauss_values
from tactgen.fem.magnetics.axisymmetric_field import solve_field
from tactgen.fem.magnetics.axisymmetric_space import discretise
from tactgen.fem.magnetics.problem_3d import MagneticSolid, ScalarPotential, VectorPotential, sample
from tactgen.fem.piezo.system import Material, volts_per_unit
from tactgen.fem.piezo.tetrahedra import SkfemBody
from tactgen.fem.solvers.linear_solver import factorise
from tactgen.geometry.arrays import Bools, Floats, Sparse
from tactgen.geometry.bimorph.bricks import Axis
from tactgen.geometry.device.ceramic_library import LIBRARY
from tactgen.geometry.device.magnetisation import TEAM20, MagnetisationCurve
from tactgen.geometry.meshing.mesh import Mesh, unique_edges
from tactgen.geometry.meshing.structured_tets import box_tetrahedra
from tactgen.geometry.reluctance.section_grid import Grid, Region
from tactgen.validation.evidence.boxes import block, even, lowest_frequencies
from tactgen.validation.evidence.cases.resonators import poled

Cells = Literal["straight", "curved", "hexahedra"]

#: Edge of the cube (m), and how far a vertex is moved: by a map as a share of it, or at random as
#: one of a cell's edge.
EDGE = 1e-3
_BENT, _SHAKEN = 0.02, 0.1


def cube(cells: Cells, divisions: int, across: int | None = None) -> Mesh:
    """Cube of 1 mm: shaken straight tetrahedra, curved ones, or rectangular hexahedra.

    The curved ones follow a smooth map of the cube onto itself, all edges with their middles.
    With `across` it is a column along x, so many of these cells wide.
    """
    counts = np.array([divisions, across or divisions, across or divisions])
    sizes = EDGE * counts / divisions
    planes = [np.linspace(0.0, size, n + 1) for size, n in zip(sizes, counts, strict=True)]
    if cells == "hexahedra":
        return hexahedra(planes)
    x, y, z = planes
    mesh = box_tetrahedra(x, y, z, np.zeros(counts, dtype=int), ("all",))
    if cells == "curved":
        return _curved(mesh, sizes)
    share = mesh.points / sizes
    inner = np.all((share > 1e-6) & (share < 1.0 - 1e-6), axis=1)
    moved = np.random.default_rng(1).uniform(-1.0, 1.0, share.shape)
    points = mesh.points + _SHAKEN * EDGE / divisions * moved * inner[:, None]
    return replace(mesh, points=points)


def _curved(mesh: Mesh, sizes: Floats) -> Mesh:
    edges, of_cell = unique_edges(mesh.cells)
    points = np.vstack([mesh.points, mesh.points[edges].mean(axis=1)])
    share = np.pi * points / sizes
    points = points + _BENT * sizes * np.sin(share) * np.cos(np.roll(share, 1, axis=1))
    cells = np.hstack([mesh.cells, len(mesh.points) + of_cell])
    return replace(mesh, points=points, cells=cells, kind="tetra10")


def hexahedra(planes: Sequence[Floats]) -> Mesh:
    """Rectangular hexahedra between planes (m) along x, y and z."""
    nodes = [p.size for p in planes]
    points = np.stack(np.meshgrid(*planes, indexing="ij"), axis=-1).reshape(-1, 3)
    low = np.arange(len(points)).reshape(nodes)[:-1, :-1, :-1].ravel()[:, None]
    along, sideways = nodes[1] * nodes[2], nodes[2]
    square = np.array([0, along, along + sideways, sideways])
    cells = low + np.concatenate([square, square + 1])
    return Mesh(points, cells, "hexahedron", np.zeros(len(cells), dtype=int), ("all",), {})


_AMPLITUDE = np.array([1.0, -0.7, 0.4, 0.8])
_WAVES = np.array([[1.1, 0.7, 0.9], [0.8, -1.2, 0.6], [-0.5, 0.9, 1.0], [0.9, 1.0, -0.8]]) / EDGE
_PHASE = np.array([0.3, 1.1, -0.4, 0.8])
#: Frequency (Hz) of the driven solution: inertia is a quarter of stiffness there.
FREQUENCY = 0.5e6


def ceramic(*, lossy: bool) -> Material:
    """Cube's material."""
    return poled(LIBRARY["PZT-5H"], lossy=lossy)


@dataclass(frozen=True)
class Space:
    """A discretised body: its matrices, and its functions at points inside."""

    stiffness: Sparse  # (4 n, 4 n) over (u_x, u_y, u_z, φ / unit) node by node
    mass: Sparse
    nodes: Floats  # (n, 3) where each function's node is (m)
    walls: Bools  # (n,) which nodes are on the boundary
    points: Floats  # (3, n_points) of a quadrature rule
    weights: Floats
    values: Sparse  # (n_points, n) of the functions there
    slopes: tuple[Sparse, ...]  # the same along x, y and z


def manufactured_errors(space: Space, material: Material, unit: float, frequency: float) -> Floats:
    """Errors of gradients and of values, relative, in the mean square.

    y_q = a_q sin(k_q · x + c_q) in (u, φ / unit).  Its load is −div of the flux C grad y less
    the inertia: (Σ_q C_paqb k_qa k_qb − Ω² ρ_p) y in row p.
    """
    omega2 = (2.0 * np.pi * frequency) ** 2
    load_of = np.einsum("paqb,qa,qb->pq", material.flux_tensor(unit), _WAVES, _WAVES)
    load_of = load_of - omega2 * material.density * np.diag([1.0, 1.0, 1.0, 0.0])
    angle = _WAVES @ space.points + _PHASE[:, None]
    value = _AMPLITUDE[:, None] * np.sin(angle)
    slope = (_AMPLITUDE[:, None] * np.cos(angle))[:, None] * _WAVES[:, :, None]
    load = (space.values.T @ (space.weights * (load_of @ value)).T).ravel()
    found = (_AMPLITUDE * np.sin(space.nodes @ _WAVES.T + _PHASE)).ravel().astype(load.dtype)
    given = np.repeat(space.walls, 4)
    dynamic = (space.stiffness - omega2 * space.mass).tocsr()
    right = (load - dynamic[:, given] @ found[given])[~given]
    found[~given] = factorise(dynamic[~given][:, ~given].tocsr()).solve(right)
    by_component = found.reshape(-1, 4).T
    off = (space.values @ by_component.T).T - value
    bent = np.stack([(along @ by_component.T).T for along in space.slopes], axis=1) - slope
    return np.array(
        [
            np.sqrt((np.abs(wrong) ** 2 @ space.weights).sum() / (right**2 @ space.weights).sum())
            for wrong, right in ((bent, slope), (off, value))
        ]
    )


def cells_space(mesh: Mesh, material: Material) -> tuple[Space, float]:
    """Space of tetrahedra or hexahedra by scikit-fem, and the potential's unit (V)."""
    known = {mesh.regions[0]: material}
    unit = volts_per_unit(known)
    body = SkfemBody(replace(mesh, faces={}), known, unit)
    basis: Any = body.basis
    walls = np.zeros(basis.N, dtype=bool)
    walls[basis.get_dofs().flatten()] = True
    functions, count = [function for (function,) in basis.basis], basis.dx.size
    columns = np.repeat(basis.element_dofs, basis.dx.shape[1], axis=1)
    places = np.broadcast_to(np.arange(count), columns.shape).ravel(), columns.ravel()

    def matrix(of: list[Floats]) -> Sparse:
        values = np.stack([np.broadcast_to(f, basis.dx.shape) for f in of])
        return sparse.csr_matrix((values.ravel(), places), shape=(count, basis.N))

    space = Space(
        *body.matrices, basis.doflocs.T, walls,
        np.asarray(basis.global_coordinates()).reshape(3, -1), basis.dx.ravel(),
        matrix(functions), tuple(matrix([f.grad[axis] for f in functions]) for axis in range(3)),
    )  # fmt: skip
    return space, unit


def bricks_space(degree: int, intervals: int, material: Material) -> tuple[Space, float]:
    """Space of bricks of one degree along all axes, and the potential's unit (V)."""
    axis = even(EDGE, intervals, degree)
    box = block((axis,) * 3, material)
    points, weights, value, slope = _line(axis)
    kinds = (value,) * 3, (slope, value, value), (value, slope, value), (value, value, slope)
    values, *slopes = (sparse.csr_matrix(reduce(sparse.kron, kind)) for kind in kinds)
    nodes = np.stack([c.ravel() for c in box.grid], axis=-1)
    space = Space(
        *box.matrices, nodes, ((nodes == 0.0) | (nodes == EDGE)).any(axis=1),
        np.stack(np.meshgrid(points, points, points, indexing="ij")).reshape(3, -1),
        reduce(np.kron, (weights,) * 3), values, tuple(slopes),
    )  # fmt: skip
    return space, box.unit


def _line(axis: Axis) -> tuple[Floats, Floats, Floats, Floats]:
    """Gauss points and weights of an axis, and values and slopes (points, nodes) of each."""
    p, lengths = axis.degree, np.diff(axis.breaks)
    weights, local = gauss_values(p)
    reference, _ = np.polynomial.legendre.leggauss(p + 1)
    points = axis.breaks[:-1, None] + 0.5 * lengths[:, None] * (reference + 1.0)
    both = np.zeros((2, axis.intervals, p + 1, axis.nodes.size))
    for i, length in enumerate(lengths):
        both[:, i, :, axis.nodes_of(i, i + 1)] = (
            local * np.array([1.0, 2.0 / length])[:, None, None]
        )
    return (
        points.ravel(), (0.5 * lengths[:, None] * weights).ravel(),
        *both.reshape(2, -1, axis.nodes.size),
    )  # fmt: skip


@cache
def solid_error(kind: Cells | int, driven: bool, divisions: int) -> Floats:
    """Errors of gradients and values on a cube of cells, or of bricks of a degree.

    At rest; `driven` at a frequency, with losses.
    """
    material = ceramic(lossy=driven)
    if isinstance(kind, int):
        space, unit = bricks_space(kind, divisions, material)
    else:
        space, unit = cells_space(cube(kind, divisions), material)
    return manufactured_errors(space, material, unit, FREQUENCY if driven else 0.0)


#: Series resonance (Hz) of a PZT-5A plate of two edges, by IEEE Std 176: half that of case TE.
_PLATE = 0.5 * 1934044.1700592


@cache
def plate_error(cells: Cells, divisions: int) -> float:
    """Relative error of a plate's thickness resonance, a piece of its upper half.

    Its motion along the normal and the potential are odd about the middle.  A column does, but
    curved cells must become straight as they become smaller, along all axes.
    """
    mesh = cube(cells, divisions, None if cells == "curved" else 2)
    space, _ = cells_space(mesh, poled(LIBRARY["PZT-5A"]))
    low, high = (np.abs(space.nodes[:, 0] - at) < 1e-9 * EDGE for at in (0.0, EDGE))
    still = np.zeros_like(low)
    free = np.stack([~low, still, still, ~low & ~high], axis=-1).ravel()
    stiffness, mass = (m[free][:, free].tocsr() for m in (space.stiffness, space.mass))
    return abs(float(lowest_frequencies(stiffness, mass, 1)[0]) / _PLATE - 1.0)


def quarter_wave_error(degree: int, intervals: int) -> float:
    """Leading relative error of a rod's lowest frequency, one end held.

    Half of the eigenvalue's, (p!/(2p)!)² (k h)^(2p)/(2p + 1) with k h = π/(2 n).
    """
    p = degree
    constant = (math.factorial(p) / math.factorial(2 * p)) ** 2 / (2 * p + 1)
    return 0.5 * constant * (math.pi / (2 * intervals)) ** (2 * p)


# --- magnetic fields ---------------------------------------------------------------------------


def rings_error(curve: MagnetisationCurve, order: int, divisions: int) -> float:
    """Relative error of B in the mean square for u = (1 − r²)² cos(πz/2), up to 2 T.

    The source ∫ H(B)·curl v is what a current density curl H does.
    """
    lines = np.linspace(0.0, 1.0, divisions + 1), np.linspace(-1.0, 1.0, 2 * divisions + 1)
    d = discretise(Grid(*lines, (Region("all", (0.0, 1.0), (-1.0, 1.0), curve),)), order)
    r, z = d.radii, d.elevations
    b_r = r * (1.0 - r**2) ** 2 * np.pi / 2.0 * np.sin(np.pi * z / 2.0)
    b_z = (2.0 * (1.0 - r**2) ** 2 - 4.0 * r**2 * (1.0 - r**2)) * np.cos(np.pi * z / 2.0)
    exact = np.stack([b_r, b_z], axis=-1)
    nu = curve.reluctivity(np.hypot(b_r, b_z))
    load = d.functional(nu[..., None] * exact)
    found = solve_field(replace(d, loads=load[None]), np.ones(1)).flux_density
    missed, size = (((of**2).sum(axis=-1) * d.volumes).sum() for of in (found - exact, exact))
    return float(np.sqrt(missed / size))


#: Wave number (1/m), and the size (T) of each of the two waves in a component.
_TURNS, _DENSITY = 2.0 / EDGE, 0.2
#: Size of grad g (A/m): about that of H.
_STRENGTH = 1e2


def _flux(points: Floats) -> Floats:
    """B (..., 3): each component varies along the other two axes, so div B = 0."""
    x, y, z = np.moveaxis(_TURNS * points, -1, 0)
    return _DENSITY * np.stack(
        [np.sin(z) + np.cos(y), np.sin(x) + np.cos(z), np.sin(y) + np.cos(x)], axis=-1
    )


def _source(points: Floats) -> Floats:
    """T0 = H + grad g of that field, g zero on all walls: φ must become g."""
    b = _flux(points)
    h = TEAM20.reluctivity(np.linalg.norm(b, axis=-1))[..., None] * b
    share = np.pi * points / EDGE
    sine, cosine = np.sin(share), np.cos(share)
    others = np.stack([sine[..., 1] * sine[..., 2], sine[..., 0] * sine[..., 2],
                       sine[..., 0] * sine[..., 1]], axis=-1)  # fmt: skip
    return np.asarray(h + _STRENGTH * cosine * others)


@cache
def cube_error(potential: Literal["A", "phi"], cells: Cells, divisions: int) -> float:
    """Relative error of B, in the mean square, in the steel of TEAM problem 20."""
    mesh = cube(cells, divisions)
    solid = sample(MagneticSolid(mesh, {"all": TEAM20}, _source, flux_normal=tuple(mesh.faces)))
    by = VectorPotential(solid) if potential == "A" else ScalarPotential(solid)
    found, exact = by.solve(1.0).flux_density, _flux(solid.points)
    missed = solid.integral(((found - exact) ** 2).sum(axis=-1))
    return float(np.sqrt(missed / solid.integral((exact**2).sum(axis=-1))))
