"""The order of elimination, which eats a chain of bricks from both ends, changes no answer."""

import numpy as np

from tactgen.fem.piezo.bricks import assemble_bricks
from tactgen.fem.solvers.linear_solver import factorise
from tactgen.geometry.bimorph.bricks import LEVELS, bimorph_bricks
from tactgen.geometry.device.parameters import Bimorph, Device


def test_no_answer_depends_on_it():
    """With and without the order: the same solution up to the matrix's own rounding."""
    device = Device(bimorph=Bimorph(bare_below=1e-3, glue_thickness=20e-6))
    system = assemble_bricks(device, bimorph_bricks(device, LEVELS[0]), lossy=False)
    ordered, searched = system.held_factor, factorise(system.stiffness.inner)
    potentials = (system.mass.inner.diagonal() == 0.0).sum()
    assert ordered.negative_pivots == searched.negative_pivots == potentials
    load = system.tip[:-3, 0]
    a, b = ordered.solve(load), searched.solve(load)
    # seven digits are lost on a balanced piezoelectric matrix
    assert np.abs(a - b).max() < 1e-7 * np.abs(a).max()
