"""Graded lines, labels and motion of the axisymmetric grid."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tactgen.geometry.device.magnetisation import linear
from tactgen.geometry.reluctance.section_grid import Region, graded_grid, graded_lines

IRON = linear(1000.0)
POLE = Region("pole", (0.0, 1.0), (0.1, 2.0), IRON, moves=True)
YOKE = Region("yoke", (0.0, 2.0), (-2.0, 0.0), IRON)
COIL = Region("coil", (1.2, 1.5), (0.3, 0.9), turns=10.0)
PARTS = (POLE, YOKE, COIL)


def raised(displacement):
    return tuple(part.displaced(displacement) for part in PARTS)


@given(
    st.lists(st.floats(1e-6, 10.0), min_size=1, max_size=8),
    st.floats(1e-3, 1.0),
    st.floats(0.1, 2.0),
)
def test_lines_meet_marks_and_sizes(steps, size, growth):
    """Every mark is a line, lines increase, no cell is much larger than asked for."""
    marks = np.concatenate([[0.0], np.cumsum(steps)])
    lines = graded_lines(marks, np.full(marks.size, size), growth)
    assert np.all(np.diff(lines) > 0.0)
    assert np.all(np.isin(marks, lines))
    middle = 0.5 * (lines[1:] + lines[:-1])
    wanted = size + growth * np.min(np.abs(middle[:, None] - marks), axis=1)
    # rounding 1.3 cells to 1 gives 1.3 times; growth across a wide cell the rest
    assert np.all(np.diff(lines) <= (1.3 + growth) * wanted)


def test_labels_fill_the_sections():
    """The cells of a region have its section; a later region covers an earlier one."""
    grid = graded_grid((*PARTS, Region("hole", (0.0, 0.5), (-1.0, -0.5))), 20.0)
    area = np.outer(np.diff(grid.r), np.diff(grid.z))
    found = [area[grid.labels == index].sum() for index in range(4)]
    assert found == pytest.approx([POLE.section, YOKE.section - 0.25, COIL.section, 0.25])


def test_lines_follow_sizes_both_ways():
    """A thicker yoke, a wider pole, a longer coil: their lines go along, every label stays."""
    grid = graded_grid(PARTS, 20.0)
    pole, yoke, coil = PARTS
    other = (
        replace(pole, radii=(0.0, 1.1)),
        replace(yoke, heights=(-2.4, 0.0)),
        replace(coil, heights=(0.3, 1.1)),
    )
    found = grid.fitted(other)
    assert np.array_equal(grid.labels, found.labels)
    assert {0.0, 1.1, 1.2, 1.5, 2.0, 20.0} <= set(found.r)
    assert {-20.0, -2.4, 0.0, 0.1, 0.3, 1.1, 2.0, 20.0} <= set(found.z)
    # the lines in between keep their shares of the interval
    share = (grid.r[grid.r < 1.0] / 1.0, found.r[found.r < 1.1] / 1.1)
    assert share[0] == pytest.approx(share[1], abs=1e-12)


def test_edges_that_meet_keep_a_sliver():
    """A pole as wide as the coil's bore: still the same cells, next to nothing between them."""
    grid = graded_grid(PARTS, 20.0)
    wide = (replace(POLE, radii=(0.0, 1.2)), YOKE, COIL)
    found = grid.fitted(wide)
    assert found.r.size == grid.r.size
    between = (found.r[1:] > 1.2) & (found.r[:-1] < 1.5)
    assert 0.0 < np.diff(found.r).min() < 1e-9
    assert np.diff(found.r)[between].sum() == pytest.approx(0.3, abs=1e-9)


def test_what_one_grid_cannot_fit():
    """A line on two edges that part, an edge past another, other regions; the pole cannot go
    through the yoke, nor its face past the coil's lower end."""
    assert graded_grid(PARTS, 20.0).fitted(raised(-0.09)) is not None
    for displacement in (-0.11, 0.21, 5.0):
        assert graded_grid(PARTS, 20.0).fitted(raised(displacement)) is None
    grid = graded_grid((*PARTS, Region("ring", (1.2, 1.3), (1.0, 1.5), IRON)), 20.0)
    ring = grid.regions[3]
    assert grid.fitted((*PARTS, replace(ring, radii=(1.25, 1.3)))) is None
    assert grid.fitted((*PARTS, replace(ring, heights=(0.8, 1.5)))) is None
    assert grid.fitted(PARTS) is None


def test_iron_alone_sets_the_velocity_of_virtual_work():
    """Between iron edges the velocity is linear, whatever winding lies there."""
    grid = graded_grid(PARTS, 20.0)
    expected = np.interp(grid.z, [-20.0, -2.0, 0.0, 0.1, 2.0, 20.0], [0, 0, 0, 1, 1, 0])
    assert grid.iron_velocity == pytest.approx(expected, abs=1e-12)


def test_level_edges_of_moving_and_fixed_parts_are_refused():
    """One line cannot follow two parts."""
    with pytest.raises(ValueError, match="level"):
        graded_grid((POLE, Region("ring", (3.0, 4.0), (0.1, 1.0), IRON)), 20.0)
