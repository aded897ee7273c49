"""Nine actuators with one driven: action is reaction, and far apart the middle one is alone."""

import numpy as np
import pytest

from tactgen.fem.magnetics import array_3d as nine
from tactgen.fem.magnetics.array_3d import (
    array_forces,
    motion_weights,
    nine_forces,
    nine_solids,
    vertical_forces,
)
from tactgen.fem.magnetics.axisymmetric import solve_point
from tactgen.fem.magnetics.problem_3d import ScalarPotential
from tactgen.geometry.device.parameters import Device
from tactgen.geometry.reluctance.sector_tets import PLACES, Cell

DEVICE, GAP, PITCH, CURRENT = Device(), 0.2e-3, 2.4e-3, 0.05
ALONE = {"middle": CURRENT}


def test_one_driven_unit_lifts_its_neighbours():
    """All forces balance, to the hundredth or two that a coarse mesh leaves; its rod is pulled by
    more than its own sleeve, and what the others lack of it is on their rods, upwards.

    At 2 mA, where Newton's method has little to do.
    """
    weak = {"middle": 2e-3}
    (solid,) = nine_solids(DEVICE, [weak], GAP, PITCH, Cell(refinement=0.4, layers=1))
    force = vertical_forces(ScalarPotential(solid), motion_weights(solid))
    assert abs(sum(force.values())) < 0.03 * force["middle"]
    assert force["middle"] > -1.05 * force["sleeve_middle"] > 0.0
    assert -0.2 * force["middle"] < force["beside"] < -0.05 * force["middle"]
    assert abs(force["diagonal"]) < 0.2 * abs(force["beside"])


def test_pulls_are_each_units_own_and_all_are_in_the_balance(monkeypatch):
    """One middle unit, four beside it, four on the diagonals; forces on sleeves count as well."""
    forces = {"middle": 8.0, "beside": -4.0, "diagonal": 1.0, "sleeve_middle": -7.0}
    monkeypatch.setattr(nine, "motion_weights", lambda _: {})
    monkeypatch.setattr(nine, "VectorPotential", lambda solid: solid)
    monkeypatch.setattr(nine, "ScalarPotential", lambda solid: -solid)
    monkeypatch.setattr(
        nine, "vertical_forces", lambda by, _: {name: by * force for name, force in forces.items()}
    )
    monkeypatch.setattr(nine, "nine_solids", lambda *_: [2.0, 3.0])
    found = nine_forces(DEVICE, [ALONE, ALONE], GAP, PITCH)
    assert [f.middle for f in found] == [(16.0, -16.0), (24.0, -24.0)]
    assert [f.beside for f in found] == [(-2.0, 2.0), (-3.0, 3.0)]
    assert [f.diagonal for f in found] == [(0.5, -0.5), (0.75, -0.75)]
    assert [f.unbalanced for f in found] == [(-4.0, 4.0), (-6.0, 6.0)]


def test_each_winding_is_at_its_units_place():
    """With its current; the source of one is asked for where a point lies as seen from it."""
    points = np.array([[1.0, 2.0, 3.0], [-4.0, 0.5, 0.1]])
    source = nine._placed(lambda at: at**2, {"middle": 2.0, "beside": 3.0}, 0.5)
    expected = 2.0 * points**2 + 3.0 * (points - [*(0.5 * np.array(PLACES["beside"])), 0.0]) ** 2
    np.testing.assert_allclose(source(points), expected, rtol=1e-14)


@pytest.mark.heavy
def test_far_apart_the_middle_one_is_alone():
    """Pitch 20 mm: both potentials enclose the axisymmetric field's pull, and no other is moved."""
    alone = solve_point(DEVICE, CURRENT, GAP).force
    (found,) = nine_forces(DEVICE, [ALONE], GAP, 20e-3)
    assert min(found.middle) < alone < max(found.middle)
    for pair in (found.beside, found.diagonal):
        assert max(map(abs, pair)) < 1e-3 * alone


@pytest.mark.heavy
def test_all_driven_alike_the_middle_one_is_nearly_in_an_endless_array():
    """What eight of all neighbours press into the gap: to a twentieth."""
    all_driven = dict.fromkeys(("middle", "beside", "diagonal"), CURRENT)
    (found,) = nine_forces(DEVICE, [all_driven], GAP, PITCH)
    endless = array_forces(DEVICE, CURRENT, GAP, PITCH)
    assert sum(found.middle) == pytest.approx(sum(endless.same), rel=0.05)


@pytest.mark.heavy
def test_a_finer_mesh_lies_within_the_bar():
    """Of the driven and of the undriven rod, by the scalar and the vector potential's means."""
    usual, fine = (
        nine_forces(DEVICE, [ALONE], GAP, PITCH, cell)[0] for cell in (None, Cell(0.7, 2))
    )
    unbalanced = 0.5 * abs(sum(usual.unbalanced))
    for name, share in (("middle", 1), ("beside", 4)):
        (a, b), better = getattr(usual, name), 0.5 * sum(getattr(fine, name))
        assert abs(0.5 * (a + b) - better) < max(0.5 * abs(a - b), unbalanced / share), name
