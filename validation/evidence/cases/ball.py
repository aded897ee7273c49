"""A ball of saturating steel in a uniform field: B inside is uniform whatever the law.

What is uniform inside leaves a dipole outside, as of a linear ball: with q = (R/R₀)³,

    H₀ = (B/µ0 + 2 H(B))/3 − (B/µ0 − H(B)) q/3,

where φ = −H₀ z is held on a concentric sphere of radius R₀ (J. A. Stratton, Electromagnetic
Theory, 1941, section 4.18, with that outer condition).
"""

from __future__ import annotations

import itertools
from functools import partial

import numpy as np

from tactgen.fem.magnetics.problem_3d import (
    MagneticSolid,
    SampledSolid,
    ScalarPotential,
    VectorPotential,
    sample,
)
from tactgen.geometry.arrays import Floats, Ints
from tactgen.geometry.device.magnetisation import MU0, TEAM20, MagnetisationCurve, linear
from tactgen.geometry.meshing.mesh import Mesh, unique_edges
from tactgen.validation.evidence.case import Check, case
from tactgen.validation.evidence.mesh_levels import counted, intervals

RADIUS, OUTER, CORE = 1.0, 3.0, 0.4


def sphere_mesh(n: int, *, curved: bool, shells: Floats | None = None) -> Mesh:
    """Mesh with `n` intervals along each edge of the core and of the ball's shell.

    Regions ball, air and far, the outermost layer of cells; faces x_low, y_low, z_low, outer.
    `shells` are the radii of the layers around the ball, from RADIUS; to OUTER by default.
    """
    if shells is None:
        shells = np.asarray(np.geomspace(RADIUS, OUTER, 2 * n + 1))
    q, hexes = _cube_octant(n, shells)
    tets, q = _split(hexes, q)
    depth = np.max(q[tets].mean(axis=1), axis=1)
    beyond = q[tets].max(axis=2).min(axis=1) > shells[-2] * (1.0 - 1e-9)
    faces = np.concatenate([tets[:, f] for f in itertools.combinations(range(4), 3)])
    on = {
        name: faces[np.all(np.abs(q[faces, axis]) < 1e-12, axis=1)]
        for axis, name in enumerate(("x_low", "y_low", "z_low"))
    }
    on["outer"] = faces[np.all(np.abs(q[faces].max(axis=2) / shells[-1] - 1.0) < 1e-12, axis=1)]
    points, cells = _mapped(q), tets
    if curved:
        edges, of_cell = unique_edges(tets)
        cells = np.hstack([tets, len(q) + of_cell])
        points = np.concatenate([points, _mapped(q[edges].mean(axis=1))])
    return Mesh(
        points=points,
        cells=cells,
        kind="tetra10" if curved else "tetra",
        region_of_cell=(depth > RADIUS).astype(int) + beyond,
        regions=("ball", "air", "far"),
        faces=on,
    )


def _mapped(q: Floats) -> Floats:
    """Move straight from the core's surface to the ball's along each ray; spheres beyond."""
    s = q.max(axis=1)
    away = s > CORE
    ray = q[away] / s[away, None]
    unit = ray / np.linalg.norm(ray, axis=1, keepdims=True)
    t = np.clip((s[away] - CORE) / (RADIUS - CORE), 0.0, 1.0)[:, None]
    p = q.copy()
    p[away] = (1.0 - t) * CORE * ray + t * np.maximum(s[away, None], RADIUS) * unit
    return p


def _cube_octant(n: int, shells: Floats) -> tuple[Floats, Ints]:
    """Points and hexahedra of an inner cube and of three blocks around it, merged."""
    across = np.tan(0.25 * np.pi * np.linspace(0.0, 1.0, n + 1))
    layers = np.concatenate([np.linspace(CORE, RADIUS, n + 1), shells[1:]])
    blocks = [np.stack(np.meshgrid(*[CORE * across] * 3, indexing="ij"), axis=-1)]
    s, a, b = np.meshgrid(layers, across, across, indexing="ij")
    blocks += [np.roll(np.stack([s, s * a, s * b], axis=-1), k, axis=-1) for k in range(3)]
    points, hexes, start = [], [], 0
    for grid in blocks:
        index: Ints = start + np.arange(grid[..., 0].size).reshape(grid.shape[:3])
        corners = [
            index[
                i : index.shape[0] - 1 + i, j : index.shape[1] - 1 + j, k : index.shape[2] - 1 + k
            ]
            for i, j, k in itertools.product((0, 1), repeat=3)
        ]
        hexes.append(np.stack([c.ravel() for c in corners], axis=1))
        points.append(grid.reshape(-1, 3))
        start += index.size
    _, first, same = np.unique(
        np.round(np.concatenate(points), 9), axis=0, return_index=True, return_inverse=True
    )
    return np.concatenate(points)[first], same.reshape(-1)[np.concatenate(hexes)]


def _split(hexes: Ints, q: Floats) -> tuple[Ints, Floats]:
    """Twelve tetrahedra around each centre, and the points with the centres.

    Faces cut from their lowest vertex match between neighbours.
    """
    centre = len(q) + np.arange(len(hexes))
    q = np.concatenate([q, q[hexes].mean(axis=1)])
    corners = []
    quads = ((0, 1, 3, 2), (4, 5, 7, 6), (0, 1, 5, 4), (2, 3, 7, 6), (0, 2, 6, 4), (1, 3, 7, 5))
    for quad in quads:
        face = hexes[:, list(quad)]
        lowest = np.argmin(face, axis=1)
        face = np.take_along_axis(face, (lowest[:, None] + np.arange(4)) % 4, axis=1)
        corners += [np.column_stack([face[:, pick], centre]) for pick in ([0, 1, 2], [0, 2, 3])]
    tets = np.concatenate(corners)
    p = _mapped(q)[tets]
    wrong = np.linalg.det(p[:, 1:] - p[:, :1]) < 0.0
    tets[wrong] = tets[wrong][:, [1, 0, 2, 3]]
    return tets, q


Potential = type[VectorPotential] | type[ScalarPotential]


def potential_of(name: str) -> Potential:
    """Vector potential for "A", scalar potential for "phi"."""
    return VectorPotential if name == "A" else ScalarPotential


def in_uniform_field(mesh: Mesh, region: str, iron: MagnetisationCurve) -> SampledSolid:
    """An eighth of a body in a field of 1 A/m along z."""
    return sample(MagneticSolid(
        mesh, {region: iron},
        lambda points: np.broadcast_to([0.0, 0.0, 1.0], points.shape),
        flux_normal=("z_low", "outer"), copies=8,
    ))  # fmt: skip


def exact_flux_density(permeability: float) -> float:
    """B in the ball (T) for 1 A/m, φ = −H0 z held at OUTER."""
    shape = (permeability + 2.0) - (permeability - 1.0) * (RADIUS / OUTER) ** 3
    return 3.0 * permeability * MU0 / shape


def _in_ball(
    potential: Potential, solid: SampledSolid, current: float = 1.0
) -> tuple[Floats, Floats]:
    """B (T) at the ball's points, and their share of its volume."""
    solver = potential(solid)
    counted(solver.size)
    cells = solid.problem.mesh.cells_of("ball")
    weights = solid.weights[cells]
    return solver.solve(current).flux_density[cells], weights / weights.sum()


def ball_error(
    potential: Potential, n: int, *, curved: bool = True, permeability: float = 1000.0
) -> tuple[float, float]:
    """Relative error of B in the ball: of its mean and in the mean square."""
    solid = in_uniform_field(sphere_mesh(n, curved=curved), "ball", linear(permeability))
    found, shares = _in_ball(potential, solid)
    exact = exact_flux_density(permeability)
    miss = (found - [0.0, 0.0, exact]) / exact
    mean = float(np.sum(miss[..., 2] * shares))
    return mean, float(np.sqrt(np.sum(np.sum(miss**2, axis=-1) * shares)))


#: Of the field far away (A/m): 2.17 T in the ball, where the steel's µr has fallen to 25.
_FIELD = 600e3


def _exact() -> float:
    """B in the ball (T)."""
    from scipy.optimize import brentq

    share = (RADIUS / OUTER) ** 3 / 3.0

    def missing(b: float) -> float:
        h = float(TEAM20.field_strength(np.array(b)))
        return (b / MU0 + 2.0 * h) / 3.0 - (b / MU0 - h) * share - _FIELD

    return float(brentq(missing, 1e-6, 10.0, xtol=1e-15))


def _mean(potential: Potential) -> float:
    """Mean of B_z in the ball (T), three intervals along an edge."""
    mesh = sphere_mesh(intervals(3, least=1), curved=True)
    return mean_in(potential, in_uniform_field(mesh, "ball", TEAM20), _FIELD)


def mean_in(potential: Potential, solid: SampledSolid, current: float = 1.0) -> float:
    """Mean of B_z (T) in the ball."""
    found, shares = _in_ball(potential, solid, current)
    return float(np.sum(shares * found[..., 2]))


CASE = case(
    "SATBALL", "Ball of saturating steel in a uniform field",
    "Radius 1, the steel of TEAM problem 20, φ = −H₀ z on a concentric sphere of radius 3, H₀ = "
    "600 kA/m: the mean of B in the ball.",
    [
        Check(f"B by the {words} is that of the dipole.", _exact(), "T",
              partial(_mean, potential), heavy=potential is VectorPotential)
        for potential, words in (
            (VectorPotential, "vector potential"), (ScalarPotential, "scalar potential"),
        )
    ],
    model="vector and scalar potential, quadratic tetrahedra, three intervals along an edge, "
    "Newton's method",
    source="J. A. Stratton, Electromagnetic Theory, 1941, section 4.18: what is uniform inside "
    "leaves a dipole outside, whatever the law; here closed by the outer sphere",
    tolerance=1e-3,
    reason="three intervals per edge leave 4e-3 locally, most of which averages out",
)  # fmt: skip
