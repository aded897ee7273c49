"""The residual, its derivatives, and Newton's method for systems as small."""

import itertools

import numpy as np
import pytest

from tactgen.tmm.harmonic_balance.balance import (
    TOLERANCE,
    LawPoint,
    NoConvergence,
    Orbit,
    Oscillator,
    balance,
    complex_spectrum,
    converge,
    real_vector,
)
from tactgen.tmm.harmonic_balance.continuation import steady_orbit
from tactgen.tmm.harmonic_balance.steady import Resolution, at_fixed_drive

M, C, K = np.diag([1.0, 0.3]), np.array([[0.3, 0.1], [0.1, 0.2]]), np.array([[2.0, -1], [-1, 3.0]])


def linear(omega):
    """Two masses, the drive pushing at the first."""
    w = omega[:, None, None]
    d = K - w**2 * M + 1j * w * C
    return np.concatenate([d, np.broadcast_to([[-1.0], [0.2]], (omega.size, 2, 1))], axis=2)


def law(q, v):
    """A smooth law of motions and rates, all of which couple."""
    x, y, u = q[:, 0], q[:, 1], v[:, 1]
    effort = np.stack([x**3 + 0.5 * x * y, 0.3 * u * x**2 + 0.25 * x**2], axis=1)
    zero = np.zeros_like(x)
    by_motion = np.stack(
        [np.stack([3 * x**2 + 0.5 * y, 0.5 * x], 1),
         np.stack([0.6 * u * x + 0.5 * x, zero], 1)], axis=1,
    )  # fmt: skip
    by_rate = np.stack([np.stack([zero, zero], 1), np.stack([zero, 0.3 * x**2], 1)], axis=1)
    return LawPoint(effort, by_motion, by_rate)


OSCILLATOR = Oscillator(linear, law, np.array([0.1, -0.2]), np.ones(2))


def an_orbit(harmonics=6, seed=3):
    rng = np.random.default_rng(seed)
    size = (harmonics + 1, 2)
    spectrum = rng.normal(size=size) + 1j * rng.normal(size=size)
    spectrum[0] = spectrum[0].real
    return Orbit(1.3, 0.7, spectrum / (1.0 + np.arange(harmonics + 1))[:, None] ** 2)


def test_derivatives_are_exact():
    """By all unknowns and both parameters, against central differences of the residual."""
    orbit, step = an_orbit(), 1e-5
    found = balance(OSCILLATOR, orbit)
    x = real_vector(orbit.spectrum)

    def residual(x, omega=orbit.omega, level=orbit.level):
        return balance(OSCILLATOR, Orbit(omega, level, complex_spectrum(x, 2))).residual

    by_x = [(residual(x + step * e) - residual(x - step * e)) / (2 * step) for e in np.eye(x.size)]
    assert found.jacobian == pytest.approx(np.array(by_x).T, abs=1e-8)
    up, down = (residual(x, omega=orbit.omega + s) for s in (step, -step))
    assert found.by_omega == pytest.approx((up - down) / (2 * step), abs=1e-8)
    up, down = (residual(x, level=orbit.level + s) for s in (step, -step))
    assert found.by_level == pytest.approx((up - down) / (2 * step), abs=1e-8)


def test_a_linear_law_is_answered_by_the_linear_system():
    """One Newton step, no harmonic but the drive's, the constant effort at rest."""
    spring = np.array([[0.5, 0.1], [0.1, 0.2]])
    damper = np.array([[0.2, 0.0], [0.0, 0.1]])

    def linear_law(q, v):
        tangents = (np.broadcast_to(a, (q.shape[0], 2, 2)) for a in (spring, damper))
        return LawPoint(q @ spring.T + v @ damper.T, *tangents)

    oscillator = Oscillator(linear, linear_law, OSCILLATOR.static, np.ones(2))
    orbit = steady_orbit(oscillator, 1.7, 3.0)
    d = linear(np.array([1.7]))[0]
    dynamic = d[:, :2] + spring + 1.7j * damper
    assert orbit.spectrum[1] == pytest.approx(np.linalg.solve(dynamic, -3.0 * d[:, 2]), rel=1e-12)
    assert orbit.spectrum[0] == pytest.approx(np.linalg.solve(K + spring, oscillator.static))
    assert np.abs(orbit.spectrum[2:]).max() < 1e-14


def test_as_many_harmonics_as_asked_for():
    """A smaller share left out takes more harmonics, and the answer changes by no more than it."""
    rough, fine = (
        steady_orbit(OSCILLATOR, 0.9, 1.5, resolution=Resolution(missing=m, least=3))
        for m in (1e-3, 1e-10)
    )
    assert rough.harmonics < fine.harmonics
    assert np.abs(rough.spectrum[1] - fine.spectrum[1]).max() < 1e-3
    again = at_fixed_drive(OSCILLATOR, fine.with_harmonics(fine.harmonics + 10))
    assert again.spectrum[1] == pytest.approx(fine.spectrum[1], rel=1e-9)


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
