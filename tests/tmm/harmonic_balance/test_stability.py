"""Unstable Floquet exponents counted on the axis, against the multipliers of time integration."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from tactgen.tmm.harmonic_balance.balance import LawPoint, Orbit, Oscillator
from tactgen.tmm.harmonic_balance.continuation import follow, steady_orbit
from tactgen.tmm.harmonic_balance.steady import (
    Resolution,
    equilibrium,
    resolved,
    unstable_exponents,
)
from tactgen.validation.evidence.cases import oscillators as cases

FINE = Resolution(missing=1e-7, least=9, most=60)


def multipliers(orbit, mass, damping, stiffness, law):
    """Return the eigenvalues of the monodromy matrix, from the variational equations."""
    k = len(mass)

    def tangent(t):
        waves = np.exp(1j * np.arange(orbit.harmonics + 1) * orbit.omega * t)
        q = (waves @ orbit.spectrum).real
        speed = (1j * np.arange(orbit.harmonics + 1) * orbit.omega * waves) @ orbit.spectrum
        at = law(q[None], speed.real[None])
        return at.by_motion[0], at.by_rate[0]

    def rate(t, y):
        y = y.reshape(2 * k, 2 * k)
        by_motion, by_rate = tangent(t)
        lower = np.linalg.solve(
            mass, -(stiffness + by_motion) @ y[:k] - (damping + by_rate) @ y[k:]
        )
        return np.concatenate([y[k:], lower]).ravel()

    period = 2.0 * np.pi / orbit.omega
    found = solve_ivp(rate, (0.0, period), np.eye(2 * k).ravel(), "DOP853", rtol=1e-9, atol=1e-10)
    return np.linalg.eigvals(found.y[:, -1].reshape(2 * k, 2 * k))


def unstable(found):
    return int((np.abs(found) > 1.0).sum())


def test_between_the_folds_only():
    """The driven Duffing oscillator, once round its folds; both ways of counting at some points."""
    oscillator, orbits = cases.driven_duffing(), cases.driven_duffing_branch().orbits
    upper, lower = (fold.omega for fold in cases.driven_duffing_folds())
    forward = np.diff([o.omega for o in orbits]) > 0.0
    turned = int(np.argmin(forward))
    back = turned + int(np.argmax(forward[turned:]))
    assert lower < orbits[turned - 1].omega <= upper
    for i in (0, turned - 3, turned + 3, back - 2, back + 3):
        orbit = orbits[i]
        expected = unstable(multipliers(orbit, np.eye(1), 0.05 * np.eye(1), np.eye(1),
                                        oscillator.law))  # fmt: skip
        assert unstable_exponents(oscillator, orbit) == expected
        middle = turned < i < back
        assert expected == int(middle)


def swinging(first, second, friction):
    """A driven mass x and two others, y and z, at rest; energy x y z couples all three.

    Dampers of y and z take friction · x².
    """
    mass, damping = np.eye(3), 0.02 * np.eye(3)
    stiffness = np.diag([9.0, first**2, second**2])

    def linear(omega):
        w = omega[:, None, None]
        d = stiffness - w**2 * mass + 1j * w * damping
        pushed = np.broadcast_to([[-1.0], [0.0], [0.0]], (omega.size, 3, 1))
        return np.concatenate([d, pushed], axis=2)

    def law(q, rate):
        x, y, z = q.T
        zero = np.zeros_like(x)
        by_motion = np.stack([[zero, z, y], [z, zero, x], [y, x, zero]]).transpose(2, 0, 1)
        effort = np.stack([y * z, x * z, x * y], axis=1)
        damper = friction * x[:, None] ** 2 * [0.0, 1.0, 1.0]
        by_motion[:, :, 0] += 2.0 * friction * x[:, None] * rate * [0.0, 1.0, 1.0]
        return LawPoint(effort + damper * rate, by_motion, damper[:, :, None] * np.eye(3))

    return Oscillator(linear, law, np.zeros(3), np.ones(3)), mass, damping, stiffness


@pytest.mark.parametrize(
    ("first", "second", "level", "friction", "number", "doubles"),
    [
        (1.0, 1.0, 1.0, 0.0, 2, True), (0.8, 1.2, 1.0, 0.0, 2, False),
        (0.8, 1.2, 0.1, 0.0, 0, False), (0.8, 1.2, 1.0, 8.0, 0, False),
    ],
)  # fmt: skip
def test_instability_with_other_periods(first, second, level, friction, number, doubles):
    """Driven at the sum of two frequencies at rest: both double the period, or beat as a pair.

    With frequencies alike y + z and y - z each double theirs, else a pair leaves the circle, if the
    drive outweighs the damping (Nayfeh and Mook, *Nonlinear Oscillations*, section 6.5), which may
    depend on the motion.
    """
    oscillator, *matrices = swinging(first, second, friction)
    orbit = steady_orbit(oscillator, 2.0, level, resolution=FINE)
    found = multipliers(orbit, *matrices, oscillator.law)
    assert unstable(found) == number
    assert bool((found.real < -1.0).any()) == doubles
    assert unstable_exponents(oscillator, orbit) == number


def test_a_quality_of_ten_thousand_is_not_overlooked():
    """A loop of the determinant is 1e-4 of the range wide: above the backbone stable, below not."""
    sharp = cases.one_mass(cases.cubic(0.1), damping=1e-4, stiffness=1.0, force=0.1)
    amplitude = np.sqrt((1.3**2 - 1.0) / 0.075) + 0.1 / (2.0 * (1.3**2 - 1.0))  # one harmonic
    guess = Orbit(1.3, 1.0, np.array([[0.0], [amplitude]]) + 0j)
    above = resolved(sharp, guess, FINE)
    assert abs(cases.fundamental(above)) == pytest.approx(amplitude, rel=0.03)
    assert unstable_exponents(sharp, above) == 0
    branch = follow(sharp, above, "level", 0.0, 1.0, direction=-1, resolution=FINE)
    below = branch.orbits[-1]
    assert below.level == 1.0
    assert cases.fundamental(below).real < 0.0 < cases.fundamental(above).real
    assert unstable_exponents(sharp, below) == 1


def test_a_lossless_oscillation_is_on_the_edge():
    """Without any loss every exponent is on the axis, and nothing is counted."""
    lossless = cases.one_mass(cases.cubic(1.0), stiffness=1.0)
    orbit = steady_orbit(lossless, 0.3, 0.5, resolution=FINE)
    assert unstable_exponents(lossless, orbit) is None
    assert equilibrium(lossless).spectrum[0, 0] == 0.0
