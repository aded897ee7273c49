"""Newton's method on convex energies: quadratic speed, steps held back, giving up."""

import numpy as np
import pytest
from scipy import sparse

from tactgen.fem.solvers.linear_solver import SolverError
from tactgen.fem.solvers.newton import _SLOPE_LEFT, Factors, _stepped, minimise


class Saturating:
    """Σ a_i log cosh(x_i) − b_i x_i: slope a tanh(x), so plain Newton overshoots for ever."""

    def __init__(self, a, b):
        self.a, self.b = a, b
        self.hessians = 0

    def value(self, x):
        return self.scale(x) - float(self.b @ x)

    def scale(self, x):
        return float(np.sum(self.a * (np.logaddexp(x, -x) - np.log(2.0)))) + 1e-30

    def gradient(self, x):
        return self.a * np.tanh(x) - self.b

    def hessian(self, x):
        self.hessians += 1
        return sparse.csr_matrix(np.diag(self.a / np.cosh(np.clip(x, -300.0, 300.0)) ** 2))


@pytest.mark.parametrize("start", [0.0, 3.0, -6.0])
def test_arrives_from_where_plain_newton_diverges(start):
    """From x = 3 a full Newton step lands near −50, the next beyond 1e40; this one arrives."""
    a, b = np.array([1.0, 5.0]), np.array([0.5, -2.0])
    found = minimise(Saturating(a, b), np.full(2, start))
    np.testing.assert_allclose(found.x, np.arctanh(b / a), rtol=1e-9)
    assert found.steps <= 20


@pytest.mark.parametrize("start", [0.1, 3.0])
@pytest.mark.parametrize("reach", [0.2, 1.0, 50.0])
def test_a_step_is_whole_or_ends_where_the_slope_is_small(start, reach):
    """Never longer than the direction, and never at a larger energy."""
    energy = Saturating(np.array([1.0]), np.array([0.5]))
    x = np.array([start])
    gradient = energy.gradient(x)
    direction = -reach * gradient / energy.hessian(x).diagonal()
    slope = float(gradient @ direction)
    asked = []
    energy.gradient = lambda x: asked.append(x) or Saturating.gradient(energy, x)
    there, found, whole = _stepped(energy, x, direction, slope)
    length = float((there - x)[0] / direction[0])
    assert 0.0 < length < 1.0 + 1e-12
    assert whole is (length > 1.0 - 1e-12)
    assert whole is (len(asked) == 1)
    assert energy.value(there) <= energy.value(x)
    assert found == energy.gradient(there)
    left = float(found @ direction)
    assert abs(left) <= _SLOPE_LEFT * abs(slope) or (length > 1.0 - 1e-12 and left < 0.0)


def test_an_energy_in_other_units_takes_the_same_steps():
    """Fields hold microjoules: nothing is small or large by itself."""
    a, b = np.array([1.0, 5.0]), np.array([0.5, -2.0])
    plain, small = (minimise(Saturating(u * a, u * b), np.full(2, 3.0)) for u in (1.0, 2.0**-30))
    np.testing.assert_allclose(small.x, plain.x, rtol=1e-12)
    assert small.steps == plain.steps


@pytest.mark.parametrize(("grown", "whole"), [(5e-13, True), (2e-12, False)])
def test_an_energy_may_grow_by_its_rounding(grown, whole):
    """Just beyond the minimum, where the slope is small: by 1e-12 of the field's energy."""
    energy = Saturating(np.array([1.0]), np.array([0.0]))
    x, direction = np.array([2.0]), np.array([-2.01])
    slope = float(energy.gradient(x) @ direction)
    start = energy.value(x)
    energy.value = lambda at: start * (1.0 + (grown if at[0] < 0.0 else 0.0))
    there, _, is_whole = _stepped(energy, x, direction, slope)
    assert is_whole is whole
    assert bool(there[0] < 0.0) is whole


def test_nothing_to_do_takes_no_step():
    """At rest already: no factorisation."""
    energy = Saturating(np.ones(3), np.zeros(3))
    assert minimise(energy, np.zeros(3)).steps == 0
    assert energy.hessians == 0


def test_too_many_steps_are_given_up(monkeypatch):
    """The message says how far it got and what to look at."""
    monkeypatch.setattr("tactgen.fem.solvers.newton._MAX_STEPS", 2)
    with pytest.raises(SolverError, match=r"in 2 Newton steps.*check the magnetisation"):
        minimise(Saturating(np.ones(1), np.array([0.99])), np.array([-5.0]))


def test_factors_of_a_field_nearby_are_enough():
    """No Hessian of its own, and the same minimum; from far away they are not tried."""
    a, b = np.array([1.0, 5.0]), np.array([0.5, -2.0])
    factors = Factors()
    near = minimise(Saturating(a, b), np.zeros(2), factors)
    for share, hessians in ((1.001, 0), (1.5, 1)):
        energy = Saturating(a, share * b)
        found = minimise(energy, near.x, factors)
        np.testing.assert_allclose(found.x, np.arctanh(share * b / a), rtol=1e-9)
        assert min(energy.hessians, 1) == min(found.steps, 1) == hessians


@pytest.mark.parametrize(("away", "kept"), [(0.01, True), (30.0, False)])
def test_solutions_by_factors_of_a_matrix_nearby(away, kept):
    """Corrected until right; far away the matrix itself is factorised."""
    n = 40
    rng = np.random.default_rng(0)
    one = sparse.diags_array(
        [-np.ones(n - 1), 2.5 * np.ones(n), -np.ones(n - 1)], offsets=[-1, 0, 1]
    )
    other = (one + sparse.diags_array(away * rng.uniform(0.0, 1.0, n))).tocsr()
    factors = Factors()
    factors.update(one.tocsr())
    right = rng.normal(size=(n, 2))
    exact = np.linalg.solve(other.toarray(), right)
    np.testing.assert_allclose(factors.solve_near(other, right), exact, atol=1e-5)
    assert np.allclose(factors.solve(one @ right), right) is kept
