"""The field at chosen points, as a Hall probe would read it.

On a straight cell curl A is linear, and so is grad φ; the values at the quadrature points
determine it.  On curved cells, and where T0 bends within a cell, the linear fit in
reference coordinates is an approximation of the same order as the field itself.
"""

from __future__ import annotations

import numpy as np

from fem.reluctance.three_d.problem import MagneticField
from geometry.arrays import Floats
from geometry.errors import InputError


def flux_density_at(field: MagneticField, points: Floats) -> Floats:
    """Return B (n, 3) in T at points (n, 3) in m.

    On a face between cells either cell's value may be taken; across iron's surface the
    two differ.

    Raises
    ------
    InputError
        If a point is outside the mesh.
    """
    solid = field.solid
    points = np.asarray(points, dtype=float)
    try:
        cells = solid.domain.element_finder(mapping=solid.mapping)(*points.T)
    except ValueError:
        raise InputError(
            "a point to probe is outside the mesh; "
            f"stay between {_corner(solid.domain.p.min(axis=1))} "
            f"and {_corner(solid.domain.p.max(axis=1))} m"
        ) from None
    local = solid.mapping.invF(points.T[:, :, None], tind=cells)[:, :, 0]
    fit = np.linalg.pinv(_linear(solid.reference_points))
    coefficients = np.einsum("kq,cqa->cka", fit, field.flux_density[cells])
    return np.asarray(np.einsum("ck,cka->ca", _linear(local), coefficients))


def _linear(points: Floats) -> Floats:
    """Return 1, ξ, η, ζ (n, 4) at reference points (3, n)."""
    return np.concatenate([np.ones((1, points.shape[1])), points]).T


def _corner(point: Floats) -> str:
    return "(" + ", ".join(f"{value:g}" for value in point) + ")"
