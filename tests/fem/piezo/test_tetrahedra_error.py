"""Goal-oriented error estimates on tetrahedra: how near they come to the true error."""

from dataclasses import replace

import numpy as np
import pytest

from tactgen.fem.piezo.modes import natural_modes
from tactgen.fem.piezo.ports import static_multiport
from tactgen.fem.piezo.solid import assemble
from tactgen.fem.piezo.tetrahedra_error import goal_errors
from tactgen.geometry.bimorph.boundary_conditions import Ends
from tactgen.geometry.bimorph.bricks import LEVELS, bimorph_bricks
from tactgen.geometry.meshing.structured_tets import box_tetrahedra, graded_planes
from tactgen.geometry.meshing.tetwild.conform import TET_FACES
from tactgen.validation.scene.load import load_scene

DEVICE = load_scene("j1")[0].device


def kuhn_bimorph(device, size, growth=0.5):
    """The bimorph in tetrahedra of six to a box: no mesher, so the same mesh every time."""
    b = device.bimorph
    half, outer = b.shim_thickness / 2, b.thickness / 2
    x = np.array([-outer, -half, half, outer])
    y = graded_planes([(-b.width / 2, size), (b.width / 2, size)], growth)
    z = graded_planes([(0.0, size), (b.length, 2 * size)], growth)
    region = np.broadcast_to(np.array([1, 2, 0])[:, None, None], (3, y.size - 1, z.size - 1))
    mesh = box_tetrahedra(x, y, z, region, ("piezo_top", "piezo_bottom", "shim"))
    every = np.unique(np.sort(mesh.cells[:, TET_FACES].reshape(-1, 3), axis=1), axis=0)

    def across(position):
        return every[(np.abs(mesh.points[every, 0] - position) < 1e-9).all(axis=1)]

    faces = {
        "base": mesh.faces["z_low"],
        "tip": mesh.faces["z_high"],
        "electrode_top_outer": across(outer),
        "electrode_top_inner": across(half),
        "electrode_bottom_inner": across(-half),
        "electrode_bottom_outer": across(-outer),
    }
    return replace(mesh, faces=faces)


def goals_of(system):
    """The goals from ports and modes, without the estimator's own solutions."""
    d = static_multiport(system).stiffness[0].real
    compliance = np.linalg.inv(d[2:4, 2:4])
    follows = -compliance @ d[2:4, 4]
    modes = natural_modes(system, Ends(), 6)
    bending = [m.frequency for m in modes if m.kind == "bending_x"]
    return {
        "tip_displacement": follows[0],
        "tip_compliance": compliance[0, 0],
        "capacitance": d[4, 4] + d[4, 2:4] @ follows,
        "bending_1": bending[0],
        "bending_2": bending[1],
    }


#: What four public codes agree on to 1e-5, frequencies to 3e-5.
CONSENSUS = {"tip_displacement": -6.7582e-7, "bending_1": 1065.96, "bending_2": 6642.85}


@pytest.fixture(scope="module", params=[0.5e-3, 0.3e-3], ids=["coarse", "finer"])
def case(request):
    mesh = kuhn_bimorph(DEVICE, request.param)
    system = assemble(DEVICE, mesh, lossy=False)
    return mesh, system, goal_errors(DEVICE, mesh, system)


def test_goals_are_those_of_ports_and_modes(case):
    """The estimator's solutions are the system's: goals agree with D(0) and Lanczos."""
    _, system, goals = case
    for name, value in goals_of(system).items():
        # D(0) loses about seven digits in inverting the tip's compliance
        assert goals[name].value == pytest.approx(value, rel=1e-6), name


def assert_effective(goals, truth):
    """Effectivity between 0.7 and 2, sign included, goal by goal.

    The estimate is a saturation factor of 2 times what cubics find; what it stands for ranges
    from 1.1 to 2.2 on this job, and these meshes of one element per layer are coarser.
    """
    for name, value in truth.items():
        goal = goals[name]
        error = value / goal.value - 1.0
        assert 0.7 < goal.error / error < 2.0, (name, goal.error, error)


def test_estimates_are_near_the_errors_against_four_codes(case):
    """Tip displacement and bending frequencies of job J1."""
    assert_effective(case[2], CONSENSUS)


@pytest.mark.heavy
def test_estimates_are_near_the_errors_against_bricks(case):
    """All goals, against bricks of high order whose error is a tenth of these errors or less."""
    system = assemble(DEVICE, bimorph_bricks(DEVICE, LEVELS[3]), lossy=False)
    assert_effective(case[2], goals_of(system))


def test_shares_bound_the_error_and_blame_the_root(case):
    """Shares are not negative and add up to the error at least; a clamp's corner is the worst."""
    mesh, _, goals = case
    for goal in goals.values():
        assert goal.shares.min() >= 0.0
        assert goal.shares.sum() >= abs(goal.error) * (1.0 - 1e-12)
    at_root = (mesh.points[mesh.cells, 2] < 1e-9).any(axis=1)
    shares = goals["tip_compliance"].shares
    assert at_root[shares.argmax()]
