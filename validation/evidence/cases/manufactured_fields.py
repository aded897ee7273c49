"""Manufactured magnetic fields: a smooth field drives itself by its own H, and must come back."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from typing import Literal

import numpy as np

from tactgen.fem.magnetics.axisymmetric_field import solve_field
from tactgen.fem.magnetics.axisymmetric_space import discretise
from tactgen.geometry.arrays import Floats
from tactgen.geometry.device.steel_law import TEAM20, MagnetisationCurve
from tactgen.geometry.reluctance.section_grid import Grid, Region
from tactgen.validation.evidence.cases.manufactured import EDGE, Cells, cube


def cylinder(curve: MagnetisationCurve) -> Region:
    """Domain of the field: a cylinder of radius 1 m, 2 m high."""
    return Region("all", (0.0, 1.0), (-1.0, 1.0), curve)


def rings_error(curve: MagnetisationCurve, order: int, divisions: int) -> float:
    """Relative error of B in the mean square for u = (1 − r²)² cos(πz/2), up to 2 T.

    The source ∫ H(B)·curl v is what a current density curl H does.
    """
    lines = np.linspace(0.0, 1.0, divisions + 1), np.linspace(-1.0, 1.0, 2 * divisions + 1)
    d = discretise(Grid(*lines, (cylinder(curve),)), order)
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
    from tactgen.fem.magnetics.problem_3d import (
        MagneticSolid,
        ScalarPotential,
        VectorPotential,
        sample,
    )

    mesh = cube(cells, divisions)
    solid = sample(MagneticSolid(mesh, {"all": TEAM20}, _source, flux_normal=tuple(mesh.faces)))
    by = VectorPotential(solid) if potential == "A" else ScalarPotential(solid)
    found, exact = by.solve(1.0).flux_density, _flux(solid.points)
    missed = solid.integral(((found - exact) ** 2).sum(axis=-1))
    return float(np.sqrt(missed / solid.integral((exact**2).sum(axis=-1))))
