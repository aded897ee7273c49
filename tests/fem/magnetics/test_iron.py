"""Fields in the materials: what each is the derivative of, in every cell by its own curve."""

import numpy as np
import pytest

from tactgen.fem.magnetics import axisymmetric_space as iron
from tactgen.geometry.device.magnetisation import MU0, TEAM20, linear

#: Cells by material; the others are vacuum.
MATERIALS = [(np.array([1, 4]), TEAM20), (np.array([3]), linear(700.0))]
CHANCE = np.random.default_rng(5)


def fields(axes):
    """Return B (T) from next to nothing to beyond the table, in six cells of eight points."""
    directions = CHANCE.normal(size=(6, 8, axes))
    directions /= iron.size_of(directions)[..., None]
    return directions * np.geomspace(1e-9, 3.0, 8)[:, None]


def derivative(of, at):
    """Return (..., k, k) by central differences: 1e-4 of a size is 1e-8 off, where it is smooth."""
    step = 1e-4 * iron.size_of(at)[..., None]
    sides = [
        (of(at + step * axis) - of(at - step * axis)) / (2.0 * step)
        for axis in np.eye(at.shape[-1])
    ]
    return np.stack(sides, axis=-1)


@pytest.mark.parametrize("axes", [2, 3])
def test_the_field_strength_changes_with_the_flux_density_by_the_tensor(axes):
    """Along the field and across it, in iron and beside it."""
    b = fields(axes)
    found = iron.reluctivity_tensor(MATERIALS, b)
    expected = derivative(lambda at: iron.field_from_flux(MATERIALS, at), b)
    scale = np.abs(expected).max(axis=(-1, -2), keepdims=True)
    assert np.abs((found - expected) / scale).max() < 1e-4
    vacuum = np.broadcast_to(np.eye(axes) / MU0, (3, 8, axes, axes))
    np.testing.assert_allclose(found[[0, 2, 5]], vacuum, rtol=1e-15)


def test_each_is_the_others_inverse():
    """B and H, dH/dB and dB/dH, and energies that add up to B·H."""
    b = fields(3)
    h = iron.field_from_flux(MATERIALS, b)
    np.testing.assert_allclose(iron.flux_from_field(MATERIALS, h), b, rtol=1e-12, atol=1e-15)
    both = iron.energy_density(MATERIALS, b) + iron.coenergy_density(MATERIALS, h)
    np.testing.assert_allclose(both, (b * h).sum(axis=-1), rtol=1e-12)
    product = iron.permeability_tensor(MATERIALS, h) @ iron.reluctivity_tensor(MATERIALS, b)
    np.testing.assert_allclose(product, np.broadcast_to(np.eye(3), product.shape), atol=1e-10)


def test_without_a_field_iron_has_no_direction():
    """The tensor of no field is that of the curve's beginning, without dividing by it."""
    found = iron.reluctivity_tensor(MATERIALS, np.zeros((6, 1, 3)))
    np.testing.assert_allclose(found[1, 0], TEAM20.slope(np.zeros(1)) * np.eye(3), rtol=1e-12)
