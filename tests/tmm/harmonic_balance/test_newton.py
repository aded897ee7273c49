"""Newton's method for small systems: steps held back where whole ones lead away, and giving up."""

import itertools

import numpy as np
import pytest

from tactgen.tmm.harmonic_balance.balance import TOLERANCE, NoConvergence, converge


def arctan(slope=1.0):
    """Return a function of two unknowns that saturates, of which one is 1000 times as large."""

    def evaluate(x):
        place = x / np.array([1.0, 1e3])
        jacobian = np.diag(slope / (1.0 + place**2)) / np.array([1.0, 1e3])
        return slope * np.arctan(place), jacobian

    return evaluate


@pytest.mark.parametrize("start", [1.0, 5.0, 20.0])
def test_it_arrives_from_where_whole_steps_diverge(start):
    """Beyond 1.39 plain Newton on arctan runs away; the size of the equations does not matter."""
    scale = np.array([1.0, 1e3])
    counts = []
    for slope in (1.0, 1e-9):
        x, count, jacobian = converge(arctan(slope), start * scale, scale, 30)
        assert np.abs(x / scale).max() < TOLERANCE**2
        assert np.diag(jacobian) * scale == pytest.approx([slope, slope], rel=TOLERANCE)
        counts.append(count)
    assert counts[0] == counts[1]


def test_whole_steps_are_taken_where_they_bring_it_nearer():
    """A quadratic one's errors square: from 1.1 to √1 in four steps, the last one small enough."""
    errors = []

    def evaluate(x):
        errors.append(abs(x[0] - 1.0))
        return x**2 - 1.0, np.diag(2.0 * x)

    converge(evaluate, np.array([1.1]), np.ones(1), 10)
    assert len(errors) == 4
    for before, after in itertools.pairwise(errors):
        assert after == pytest.approx(0.5 * before**2 / (1.0 + before), rel=1e-6, abs=1e-15)


@pytest.mark.parametrize(
    ("evaluate", "most", "words"),
    [
        (lambda x: (x**2 + 1.0, np.diag(2.0 * x)), 50, "no step brought it nearer|in 50 steps"),
        (lambda x: (x + np.nan, np.eye(1)), 50, "no step brought it nearer"),
        (lambda x: (x - x + 1.0, 0.0 * np.eye(1)), 50, "nothing holds a coordinate"),
        (lambda x: (x**3, np.diag(3.0 * x**2)), 5, "did not settle in 5 steps"),
    ],
)
def test_what_does_not_settle_says_why(evaluate, most, words):
    """No zero, no number, no slope, and a zero that is too slow to reach."""
    with pytest.raises(NoConvergence, match=words):
        converge(evaluate, np.array([0.7]), np.ones(1), most)
