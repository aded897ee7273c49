"""One cell of an array of normal actuators: its mesh, an actuator alone, dipoles far apart."""

import math

import numpy as np
import pytest

from tactgen.fem.magnetics.array_3d import array_forces
from tactgen.fem.magnetics.axisymmetric import solve_point
from tactgen.fem.magnetics.problem_3d import MagneticSolid, sample
from tactgen.geometry.device.magnetisation import MU0
from tactgen.geometry.device.parameters import Bimorph, Device
from tactgen.geometry.device.parts import closed_form_volumes
from tactgen.geometry.errors import InputError
from tactgen.geometry.reluctance.sector_tets import COPIES, Cell, cell_mesh

DEVICE, GAP = Device(), 0.2e-3
COARSE = Cell(refinement=0.5, layers=2)
#: Sums over a square array of 1/r³ with equal and with alternating signs, in units of the pitch.
EQUAL, ALTERNATING = 9.0336217, -2.6458865


def test_the_cell_is_a_square_with_the_parts_in_it():
    """Its wall is plane; sleeve and coil have their closed volumes, the whole that of a box."""
    mesh = cell_mesh(DEVICE, GAP, 2.4e-3, COARSE)
    wall = mesh.points[np.unique(mesh.faces["mantle"])]
    np.testing.assert_allclose(wall[:, 0], 1.2e-3, rtol=1e-12)
    volumes = sample(MagneticSolid(mesh, {}, np.zeros_like)).weights.sum(axis=1)
    expected = closed_form_volumes(Device(bimorph=Bimorph(tab_length=2e-3)))
    # an arc of 22.5 degrees by a parabola: 4e-5 of the area
    for name in ("sleeve", "coil"):
        found = COPIES * volumes[mesh.cells_of(name)].sum()
        assert found == pytest.approx(expected[name], rel=2e-4)
    height = float(np.ptp(mesh.points[:, 2]))
    assert COPIES * volumes.sum() == pytest.approx(2.4e-3**2 * height, rel=1e-9)


def test_a_pitch_that_does_not_fit_is_refused():
    """With the pitch, the diameter and the remedy."""
    with pytest.raises(InputError, match=r"display.pitch = 2.3 mm .* 2.3 mm; set"):
        cell_mesh(DEVICE, GAP, 2.3e-3, COARSE)


def test_neighbours_change_the_pull_as_their_polarity_says():
    """Opposite neighbours take flux from the working gap, equal ones push it in; by both fields."""
    near = array_forces(DEVICE, 0.05, GAP, 2.4e-3, Cell(refinement=0.5, layers=1))
    for same, alternating in zip(near.same, near.alternating, strict=True):
        assert alternating < 0.7 * same


@pytest.mark.heavy
def test_far_apart_it_is_the_actuator_alone():
    """Pitch 20 mm: the mean of both potentials within half their difference of the axisymmetric
    field's pull, and polarity no longer matters to 1 %."""
    alone = solve_point(DEVICE, 0.05, GAP).force
    far = array_forces(DEVICE, 0.05, GAP, 20e-3, COARSE)
    for pair in (far.same, far.alternating):
        assert min(pair) < alone < max(pair)
    for same, alternating in zip(far.same, far.alternating, strict=True):
        assert alternating == pytest.approx(same, rel=0.01)


@pytest.mark.heavy
@pytest.mark.parametrize("pitch", [30e-3, 60e-3])
def test_far_apart_the_difference_is_that_of_dipoles(pitch):
    """F(same) − F(alternating) = µ0 m ∂m/∂g (S − S') / (4π p³): the axisymmetric field's moment.

    The dipole is within what both potentials give; from 30 mm on, since the actuator is 19 mm long.
    """
    current, step = 0.02, 1e-5
    slope = (moment(current, GAP + step) - moment(current, GAP - step)) / (2.0 * step)
    sums = (EQUAL - ALTERNATING) / (4.0 * math.pi * pitch**3)
    expected = MU0 * moment(current, GAP) * slope * sums
    found = array_forces(DEVICE, current, GAP, pitch, COARSE)
    differences = [a - b for a, b in zip(found.same, found.alternating, strict=True)]
    assert min(differences) < expected < max(differences)


@pytest.mark.heavy
def test_a_finer_cell_lies_within_the_bar():
    """The default's pulls and their difference against a mesh of some five times the cells."""
    usual = array_forces(DEVICE, 0.05, GAP, 2.4e-3)
    fine = array_forces(DEVICE, 0.05, GAP, 2.4e-3, Cell(1.2, 7))
    width = max(abs(a - b) / (a + b) for a, b in (usual.same, usual.alternating))
    for name in ("same", "alternating"):
        value, better = (0.5 * sum(getattr(forces, name)) for forces in (usual, fine))
        assert abs(value - better) < width * value, name


def moment(current, gap):
    """Return the dipole moment (A m²) of coil and iron."""
    solution = solve_point(DEVICE, current, gap).solution
    d = solution.discretisation
    magnetised = solution.flux_density / MU0 - solution.field_strength
    coil = next(region for region in d.grid.regions if region.turns)
    a, b = coil.radii
    turn = math.pi * (a * a + a * b + b * b) / 3.0
    return float(np.sum(magnetised[..., 1] * d.volumes)) + current * coil.turns * turn
