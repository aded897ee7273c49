"""Oscillators whose free or forced motion is known from elsewhere, as harmonic balance takes them.

One mass each, m ẍ + c ẋ + k x + f(x) = P cos Ωt, in whatever consistent units the source has.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache

import numpy as np

from tactgen.geometry.arrays import Complex, Floats
from tactgen.tmm.harmonic_balance.balance import LawPoint, Orbit, Oscillator
from tactgen.tmm.harmonic_balance.continuation import Branch, folds, follow, peaks, steady_orbit
from tactgen.tmm.harmonic_balance.steady import Resolution, free_oscillation

#: Harmonics are added until those left out would move less than this share.
EXACT = Resolution(missing=1e-11, least=7, most=60)


def one_mass(
    law: Callable[[Floats], tuple[Floats, Floats]],
    *,
    mass: float = 1.0,
    damping: float = 0.0,
    stiffness: float = 0.0,
    force: float = 1.0,
) -> Oscillator:
    """Mass on a linear spring and damper and a law; a drive of 1 is the given force.

    The law is from motions (n,) to force and stiffness (n,).
    """

    def linear(omega: Floats) -> Complex:
        d = stiffness - mass * omega**2 + 1j * omega * damping
        return np.stack([d, np.full_like(d, -force)], axis=-1)[:, None, :]

    def of(motion: Floats, _: Floats) -> LawPoint:
        effort, slope = law(motion[:, 0])
        none = np.zeros((motion.shape[0], 1, 1))
        return LawPoint(effort[:, None], slope[:, None, None], none)

    return Oscillator(linear, of, np.zeros(1), np.ones(1))


def cubic(coefficient: float) -> Callable[[Floats], tuple[Floats, Floats]]:
    """Law f = g x³."""
    return lambda x: (coefficient * x**3, 3.0 * coefficient * x**2)


def one_sided(stiffness: float) -> Callable[[Floats], tuple[Floats, Floats]]:
    """Law of a spring that touches at x > 0 only."""
    return lambda x: (stiffness * np.maximum(x, 0.0), np.where(x > 0.0, stiffness, 0.0))


def free_on_cubic(stiffness: float, coefficient: float, mass: float, amplitude: float) -> Orbit:
    """Free oscillation on k x + g x³ by harmonic balance."""
    scaled = one_mass(cubic(coefficient), mass=mass, stiffness=stiffness)
    # one harmonic's answer to begin with
    omega = np.sqrt((stiffness + 0.75 * coefficient * amplitude**2) / mass)
    guess = Orbit(float(omega), 0.0, np.array([[0.0], [amplitude]]) + 0j)
    return free_oscillation(scaled, amplitude, guess, resolution=EXACT)


def period_of_vm156() -> float:
    """Period (s) of the mass on a hardening spring of Ansys verification case VM156."""
    return 2.0 * np.pi / free_on_cubic(2.0, 4.0, 2588e-6, 1.0).omega


def free_on_one_sided(ratio: float, harmonics: int) -> Orbit:
    """Free oscillation on a spring of 1 that is 1 + `ratio` on one side.

    The ratio is approached in steps, each from the answer before.
    """
    steps = max(1, int(np.ceil(4.0 * np.log10(max(ratio / 1e-2, 1.0)))))
    found = Orbit(1.0, 0.0, np.array([[0.0], [-1.0]]) + 0j)
    for value in np.geomspace(min(ratio, 1e-2), ratio, steps + 1):
        system = one_mass(one_sided(float(value)), stiffness=1.0)
        resolution = Resolution(missing=1e-4, least=10, most=harmonics)
        found = free_oscillation(system, -1.0, found, resolution=resolution)
    return found


def driven_duffing() -> Oscillator:
    """Ẍ + 0.05 ẋ + x + 0.1 x³ = 0.18 cos Ωt, example 01 of the program NLvib."""
    return one_mass(cubic(0.1), damping=0.05, stiffness=1.0, force=0.18)


@cache
def driven_duffing_branch() -> Branch:
    """Its response from Ω = 0.5 to 1.6."""
    oscillator = driven_duffing()
    start = steady_orbit(oscillator, 0.5, 1.0, resolution=EXACT)
    return follow(oscillator, start, "omega", 0.5, 1.6, resolution=EXACT)


def driven_vm86() -> Orbit:
    """0.5 ẍ + 6 ẋ + 200 x = 10 cos 20t, Ansys verification case VM86."""
    plain = one_mass(cubic(0.0), mass=0.5, damping=6.0, stiffness=200.0, force=10.0)
    return steady_orbit(plain, 20.0, 1.0, resolution=EXACT)


def fundamental(orbit: Orbit) -> complex:
    """First harmonic of the first coordinate."""
    return complex(orbit.spectrum[1, 0])


@cache
def driven_duffing_peak() -> Orbit:
    """Where its first harmonic is largest."""
    return peaks(driven_duffing(), driven_duffing_branch(), fundamental)[0].orbit


@cache
def driven_duffing_folds() -> tuple[Orbit, ...]:
    """Where its response turns back, in the order in which it is met."""
    return tuple(at.orbit for at in folds(driven_duffing(), driven_duffing_branch()))
