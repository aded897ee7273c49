"""What all line plots share: marks without a number are drawn, and cost no artists of their own."""

import numpy as np
import pytest

from tactgen.validation.show.figures import lay_out, panels, plain_numbers


def test_marks_between_numbers_are_lines_of_the_grid():
    """At each mark inside the range, across for the x axis and along for the y axis.

    Also on a logarithmic scale that is shared; where no grid is drawn there is none.
    """
    figure, axes = panels(4.0, 3.0, nrows=3, sharex=True)
    for axis in axes:
        axis.plot([2.0, 300.0], [1.0, 2.0])
        axis.set(xscale="log", xlim=(2.0, 300.0), title="one")
    axes[1].set(yscale="log", ylim=(2.0, 50.0))
    axes[2].grid(visible=False, which="both")
    lay_out(figure)
    wanted = [m * d for d in (1.0, 10.0, 100.0) for m in range(2, 10) if 2.0 < m * d < 300.0]
    for axis in axes[:2]:
        across, *along = axis.collections
        segments = across.get_segments()
        np.testing.assert_allclose(sorted(s[0, 0] for s in segments), wanted, rtol=1e-12)
        assert all(s[0, 0] == s[1, 0] and (s[0, 1], s[1, 1]) == (0.0, 1.0) for s in segments)
        assert not axis.xaxis.get_minorticklocs().size
    (along,) = along
    assert all(a[1] == b[1] and (a[0], b[0]) == (0.0, 1.0) for a, b in along.get_segments())
    assert not axes[2].collections


@pytest.mark.parametrize(
    ("ends", "scale", "numbers"),
    [
        ((1.0, 20.0), "log", ["1", "2", "5", "10", "20"]),
        ((1.0, 100.0), "log", ["1", "10", "100"]),
        ((1.0, 30.0), "log", ["1", "10"]),
        ((0.0, 2000.0), "linear", ["0", "1000", "2000"]),
    ],
)
def test_numbers_are_plain(ends, scale, numbers):
    """At 1, 2 and 5 where little over a decade is shown, at decades beyond; else as usual."""
    _, axis = panels(4.0, 3.0)
    for side, set_scale in ((axis.xaxis, axis.set_xscale), (axis.yaxis, axis.set_yscale)):
        set_scale(scale)
        side.set_view_interval(*ends, ignore=True)
        if scale == "linear":
            side.set_ticks([0.0, 1000.0, 2000.0])
    plain_numbers(axis.xaxis, axis.yaxis)
    for side in (axis.xaxis, axis.yaxis):
        low, high = ends
        shown = [v for v in side.get_majorticklocs() if low <= v <= high]
        assert side.get_major_formatter().format_ticks(shown) == numbers
        if scale == "log":
            assert set(side.get_minor_formatter().format_ticks(side.get_minorticklocs())) <= {""}
