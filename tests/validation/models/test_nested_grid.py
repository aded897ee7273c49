"""Interpolation on nested grids: exact for polynomials, honest for what is not smooth."""

import numpy as np
import pytest

from tactgen.validation.models.reluctance.family.nested_grid import chebyshev, nested_table

RNG = np.random.default_rng(5)


def tabled(function, axes=1, error=1e-3, wanted=0.1, most=200):
    asked = []

    def solve(place):
        asked.append(tuple(place))
        return {"f": (float(function(*place)), error)}

    return nested_table(solve, axes, wanted=wanted, most=most), asked


def test_points_are_nested_with_both_ends_and_the_middle():
    for power in (1, 2, 3, 4):
        points = chebyshev(power)
        assert points.size == 2**power + 1
        assert (points[0], points[points.size // 2], points[-1]) == (-1.0, 0.0, 1.0)
        assert (np.diff(points) > 0.0).all()
        assert np.array_equal(chebyshev(power + 1)[::2], points)


def test_polynomials_of_two_numbers_are_exact():
    """Degree 2 and 2 is known to the grid before the first: nothing is refined."""
    table, asked = tabled(lambda x, y: 1.0 + x - 2.0 * y**2 + x**2 * y, axes=2)
    places = RNG.uniform(-1.0, 1.0, (50, 2))
    x, y = places.T
    found = table.value("f", places)
    assert found == pytest.approx(1.0 + x - 2.0 * y**2 + x**2 * y, abs=1e-14)
    assert len(asked) == len(set(asked)) == 25
    assert table.bar("f", places) == pytest.approx(1e-3, rel=1e-9)


def test_only_the_axis_that_needs_it_is_refined():
    table, _ = tabled(lambda x, y: np.exp(3.0 * x) + y, axes=2)
    assert table.powers[0] > table.powers[1] == 2
    places = RNG.uniform(-1.0, 1.0, (50, 2))
    off = np.abs(table.value("f", places) - np.exp(3.0 * places[:, 0]) - places[:, 1])
    assert off.max() <= 1e-4


@pytest.mark.parametrize(
    "function",
    [
        lambda x: np.abs(x - 0.3) * (x - 0.3),  # a kink of the slope, as magnetisation curves have
        lambda x: 1.0 / (1.0 + 25.0 * x**2),
        lambda x: np.sin(5.0 * x),
    ],
)
@pytest.mark.parametrize("most", [5, 9, 17, 33])
def test_bars_hold_what_the_interpolation_misses(function, most):
    """Stopped anywhere, with solved points that have no error of their own."""
    table, asked = tabled(function, error=1e-6, most=most)
    assert len(asked) <= most
    places = np.linspace(-1.0, 1.0, 401)[:, None]
    off = np.abs(table.value("f", places) - function(places[:, 0]))
    if most > 5:  # three points may agree with two more by chance
        assert (off <= table.bar("f", places)).all()


def test_a_bar_is_the_larger_of_its_neighbours():
    def solve(place):
        return {"f": (0.0, 1.0 + float(place[0] > 0.5))}

    table = nested_table(solve, 1, wanted=0.1, most=5)
    bars = table.bar("f", np.array([[-1.0], [-0.1], [0.1], [0.6], [1.0]]))
    assert bars.tolist() == [1.0, 1.0, 2.0, 2.0, 2.0]
