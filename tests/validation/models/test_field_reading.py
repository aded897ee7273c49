"""What is read off a field, held against the laws that it obeys."""

import numpy as np
import pytest

from tactgen.fem.magnetics.axisymmetric import solve_point
from tactgen.geometry.device.parameters import Device
from tactgen.validation.models.reluctance.field_reading import FieldReading

GAP, CURRENT = 0.2e-3, 0.13


@pytest.fixture(scope="module")
def reading():
    return FieldReading(Device(), GAP, solve_point(Device(), CURRENT, GAP).solution)


def test_flux_is_that_of_the_flux_function(reading):
    """B_z summed over quadrature points, and 2π r A_φ where lines cross: one field, two ways."""
    grid = reading.field.discretisation.grid
    for radius in (Device().rod.radius, Device().sleeve.outer_radius):
        at = int(np.argmin(np.abs(grid.r - radius)))
        exact = 2.0 * np.pi * reading.field.flux_function[at]
        found = reading.flux(radius)(grid.z[1:-1])
        # a curve through the points' heights, least right where the shaft's corner meets the flange
        np.testing.assert_allclose(found, exact[1:-1], atol=6e-3 * np.abs(exact).max())


def test_all_that_is_taken_is_what_the_coil_gives(reading):
    """∫H·B dV over everything is current times linkage: Gauss's law and Ampère's, integrated."""
    field = reading.field
    names = {region.name for region in field.discretisation.grid.regions}
    d = field.discretisation
    air = d.cell_labels < 0
    outside = (field.field_strength[air] * field.flux_density[air]).sum(axis=-1)
    together = reading.taken_by(*names) + float((outside * d.volumes[air]).sum())
    assert together == pytest.approx(CURRENT * reading.flux_linkage, rel=1e-6)
    iron = reading.taken_by("rod", "flange", "head", "sleeve")
    assert 0.1 * together < iron < 0.5 * together


def test_mmf_round_the_circuit_is_that_of_the_coil(reading):
    """Gap, sleeve and shaft take nearly all of it; the rest stands at flange and in the head."""
    rod = Device().rod
    sleeve = float(reading.drop_along_sleeve(np.array([-rod.flange_position]))[0])
    shaft = -reading._mean_strength(0.0, rod.radius)
    grid = reading.field.discretisation.grid
    z = 0.5 * (grid.z[1:] + grid.z[:-1])
    beside = (z > -rod.flange_position) & (z < GAP)
    in_shaft = -float(shaft[beside] @ np.diff(grid.z)[beside])
    driven = Device().coil.turns * CURRENT
    assert sleeve > 0.0
    taken = reading.gap_mmf + sleeve + in_shaft
    assert 0.85 * driven < taken < driven
