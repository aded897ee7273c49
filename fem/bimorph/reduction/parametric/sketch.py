"""Random shapes that measure a residual: their products with it have its norm for a mean square.

The norm that bounds errors is that of the undivided body's compliance, rᵀ X⁻¹ r.  With A its
stiffness at held potential, D its permittivity, B what couples them, and K = [A, Bᵀ; B, −D], X⁻¹
has the diagonal blocks of K⁻¹, the second with its sign changed: X is A + Bᵀ D⁻¹ B beside
D + B A⁻¹ Bᵀ.  With z = K⁻¹ f of random loads f of covariance A beside D, E (zᵀ r)² = rᵀ X⁻¹ r: one
solution with the factor that answers with.  f is Bᵀ √C ξ of strains and fields, ξ independent
normal numbers.  Of k such shapes the mean of (zᵀ r)² is within √(2/k) of the norm (one standard
deviation), whatever r is; zᵀ of a sum of terms is a sum of small vectors, so a residual's norm
costs no large vector (O. Balabanov, A. Nouy, Randomized linear algebra for model reduction,
part I, 2019).
"""

from __future__ import annotations

import numpy as np

from tactgen.fem.bimorph.reduction.parametric.products import Shapes
from tactgen.fem.elements.line_basis import gauss_values
from tactgen.fem.piezo.system import VOIGT, Material
from tactgen.geometry.arrays import Floats
from tactgen.geometry.bimorph.bricks import Axis, Bricks

#: Number of random shapes: the mean square is right to a fifth.
SKETCHES = 48


def random_loads(bricks: Bricks, known: dict[str, Material], unit: float) -> Shapes:
    """Return loads of covariance A beside D: random stresses and fluxes in every point."""
    rng = np.random.default_rng(1)
    shape = bricks.shape
    moved = np.zeros((3, *shape, SKETCHES))
    charged = np.zeros((*shape, SKETCHES))
    for slab in bricks.slabs:
        tables = [_table(bricks.x, *slab.x), _table(bricks.y), _table(bricks.z, *slab.z)]
        points = [table.shape[1] for table in tables]
        material = known[slab.region]
        stress = np.tensordot(
            np.linalg.cholesky(material.c), rng.standard_normal((6, *points, SKETCHES)), 1
        )
        for p in range(3):
            for a in range(3):
                moved[p] += _integrated(tables, a, stress[VOIGT[p, a]])
        if material.piezo is not None:
            flux = unit * np.tensordot(
                np.linalg.cholesky(material.piezo.eps),
                rng.standard_normal((3, *points, SKETCHES)),
                1,
            )
            for a in range(3):
                charged += _integrated(tables, a, flux[a])
    return Shapes(2.0 * moved, 2.0 * charged)  # the root of four quarters


def _integrated(tables: list[Floats], axis: int, values: Floats) -> Floats:
    """Return Σ √w ∂_axis N values over the points (nx, ny, nz, k)."""
    for n, table in enumerate(tables):
        values = np.moveaxis(np.tensordot(table[int(n == axis)], values, (0, n)), 0, n)
    return values


def _table(axis: Axis, first: int = 0, last: int | None = None) -> Floats:
    """Return √w N and √w N' at Gauss points of some intervals (2, points, nodes)."""
    p = axis.degree
    weights, (values, slopes) = gauss_values(p)
    chosen = range(first, axis.intervals if last is None else last)
    table = np.zeros((2, len(chosen) * (p + 1), axis.nodes.size))
    for row, interval in enumerate(chosen):
        half = 0.5 * float(axis.breaks[interval + 1] - axis.breaks[interval])
        at = slice(row * (p + 1), (row + 1) * (p + 1))
        nodes = slice(interval * p, (interval + 1) * p + 1)
        table[0, at, nodes] = np.sqrt(weights * half)[:, None] * values
        table[1, at, nodes] = np.sqrt(weights * half)[:, None] * slopes / half
    return table
