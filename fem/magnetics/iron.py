"""What the materials do at quadrature points: energies, fields and their tensors.

Vectors have two components (r, z) or three.  Everything is µ0 except in the cells of `iron`,
each group of which has its curve.  Iron is isotropic: across the field its tensor is the
secant, along it the tangent.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from tactgen.geometry.arrays import Floats, Ints
from tactgen.geometry.device.steel_law import MU0, MagnetisationCurve

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


def _isotropic(vector: Floats, along: Floats, across: Floats) -> Floats:
    """Tensor (..., k, k) that is `along` in the vector's direction, else `across`."""
    size = size_of(vector)[..., None]
    unit = vector / np.where(size > 0.0, size, 1.0)
    outer = unit[..., :, None] * unit[..., None, :]
    return np.asarray(
        across[..., None, None] * np.eye(vector.shape[-1])
        + (along - across)[..., None, None] * outer
    )
