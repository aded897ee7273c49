"""The order of elimination eats a chain of bricks from both ends, and changes no answer."""

import numpy as np
import pytest

from tactgen.fem.piezo.bricks import assemble_bricks, elimination_order
from tactgen.fem.solvers.linear_solver import factorise
from tactgen.geometry.bimorph.bricks import LEVELS, bimorph_bricks
from tactgen.geometry.device.parameters import Bimorph, Device

BIMORPHS = ({}, {"bare_below": 1e-3, "glue_thickness": 20e-6})


@pytest.mark.parametrize("variant", BIMORPHS)
def test_planes_follow_what_they_separate(variant):
    """Every node has a place; inner nodes of the two bricks beside a plane come before it."""
    bricks = bimorph_bricks(Device(bimorph=Bimorph(**variant)), LEVELS[1])
    place = elimination_order(bricks)
    assert np.array_equal(np.sort(place), np.arange(place.size))
    place, degree = place.reshape(bricks.shape), bricks.z.degree
    for plane in range(degree, bricks.shape[2] - 1, degree):
        around = place[:, :, [plane - 1, plane + 1]]
        assert around.max() < place[:, :, plane].min()


@pytest.mark.parametrize("variant", BIMORPHS)
def test_no_answer_depends_on_it(variant):
    """With and without the order: the same solution up to the matrix's own rounding."""
    device = Device(bimorph=Bimorph(**variant))
    system = assemble_bricks(device, bimorph_bricks(device, LEVELS[0]), lossy=False)
    ordered, searched = system.held_factor, factorise(system.stiffness.inner)
    assert ordered.negative_pivots == searched.negative_pivots == system.potentials
    load = system.tip[:-3, 0]
    a, b = ordered.solve(load), searched.solve(load)
    # seven digits are lost on a balanced piezoelectric matrix
    assert np.abs(a - b).max() < 1e-7 * np.abs(a).max()
