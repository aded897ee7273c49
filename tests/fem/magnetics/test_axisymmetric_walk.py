"""Fields one after another: as alone, on few grids, and no coarser than asked for."""

import numpy as np
import pytest

from tactgen.fem.magnetics import axisymmetric as walk
from tactgen.fem.magnetics.axisymmetric import (
    FieldContinuation,
    FieldErrors,
    FieldPath,
    solve_point,
)
from tactgen.geometry.device.parameters import Device
from tactgen.geometry.errors import CoarseGridError, InputError

NAMES = tuple(FieldErrors.__dataclass_fields__)


@pytest.fixture
def grids(monkeypatch):
    """Return the finenesses of the grids that are made."""
    made = []

    class Noted(FieldPath):
        def __init__(self, device, gap, *, refinement):
            made.append(refinement)
            super().__init__(device, gap, refinement=refinement, order=3)

    monkeypatch.setattr(walk, "FieldPath", Noted)
    return made


def test_a_walk_over_gap_and_current_says_what_points_alone_do(grids):
    """The narrow gap's grid does not reach back: it has cells for itself."""
    steps = FieldContinuation((0.5,), 0.1)
    for n, (current, gap) in enumerate([(0.13, 0.2e-3), (0.1, 0.18e-3), (0.02, 20e-6)]):
        found = steps.at(Device(), current, gap, np.array([float(n)]))
        alone = solve_point(Device(), current, gap, order=3, refinement=0.5)
        for name in NAMES:
            bar = getattr(found.errors, name) + getattr(alone.errors, name)
            assert abs(getattr(found, name) - getattr(alone, name)) <= bar, (n, name)
    assert 1 <= len(grids) < 3


def test_the_next_begins_on_the_grid_that_was_fine_enough_nearby(grids):
    """The coarse one is tried once, at the first; there it says too little."""
    coarse, fine = (
        solve_point(Device(), 0.13, 0.2e-3, order=3, refinement=each) for each in (0.4, 0.8)
    )
    relative = [each.errors.force / each.force for each in (coarse, fine)]
    assert relative[1] < relative[0]
    steps = FieldContinuation((0.4, 0.8), 0.5 * sum(relative))
    for gap in (0.2e-3, 0.19e-3):
        found = steps.at(Device(), 0.13, gap, np.array([gap / 0.2e-3]))
        assert found.errors.force <= 0.5 * sum(relative) * found.force
    assert grids == [0.4, 0.8]


def test_what_does_not_fit_is_refused(grids):
    with pytest.raises(InputError, match="gap"):
        FieldContinuation((0.5,), 0.1).at(Device(), 0.13, 5e-3, np.zeros(1))


def test_a_grid_too_coarse_for_an_answer_is_left_for_a_finer_one(grids, monkeypatch):
    """At 2 µm the co-energy's bar is 3.0 % on few lines, and 1.4 % on twice as many."""
    monkeypatch.setattr(walk, "_TOO_COARSE", 0.02)
    with pytest.raises(CoarseGridError):
        FieldContinuation((0.1,), 0.5).at(Device(), 0.13, 2e-6, np.zeros(1))
    point = FieldContinuation((0.1, 0.5), 0.5).at(Device(), 0.13, 2e-6, np.zeros(1))
    assert grids == [0.1, 0.1, 0.5]
    assert point.errors.coenergy <= 0.02 * point.coenergy
