"""What all line plots share: marks without a number are drawn, and cost no artists of their own."""

import numpy as np

from tactgen.validation.view.figures import lay_out, panels


def test_marks_between_numbers_are_lines_of_the_grid():
    """On every axis of a shared logarithmic scale, at each mark inside the range."""
    figure, axes = panels(4.0, 3.0, nrows=2, sharex=True)
    for axis in axes:
        axis.plot([2.0, 300.0], [1.0, 2.0])
        axis.set_xscale("log")
        axis.set_xlim(2.0, 300.0)
        axis.set_title("one")
    lay_out(figure)
    wanted = [m * d for d in (1.0, 10.0, 100.0) for m in range(2, 10) if 2.0 < m * d < 300.0]
    for axis in axes:
        (grid,) = axis.collections
        found = sorted(segment[0, 0] for segment in grid.get_segments())
        np.testing.assert_allclose(found, wanted, rtol=1e-12)  # rounding of 10**x
        assert grid.get_alpha() == axis.xaxis.get_gridlines()[0].get_alpha()
        assert not axis.xaxis.get_minorticklocs().size
        assert axis.get_xlim() == (2.0, 300.0)
        assert axis.get_title() == "one"


def test_a_short_scale_keeps_its_marks():
    """Within a decade they have numbers; a scale without logarithms has none to draw."""
    figure, axis = panels(4.0, 3.0)
    axis.plot([2.0, 9.0], [1.0, 2.0])
    axis.set_xscale("log")
    lay_out(figure)
    assert not axis.collections
    assert axis.xaxis.get_minorticklocs().size
