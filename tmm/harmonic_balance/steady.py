"""One orbit at a stated frequency and drive, from a guess that is near; and the state of rest."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tactgen.geometry.arrays import Floats
from tactgen.tmm.harmonic_balance.balance import (
    balance,
    complex_spectrum,
    missing_motion,
    real_vector,
)
from tactgen.tmm.harmonic_balance.newton import NoConvergence, converge
from tactgen.tmm.harmonic_balance.oscillator import Orbit, Oscillator

_STEPS = 40


@dataclass(frozen=True)
class Resolution:
    """How many harmonics are taken.

    Attributes
    ----------
    missing : float
        Share of the motion that the harmonics left out may have.
    least, most : int
        Fewest and most harmonics.
    """

    missing: float = 1e-4
    least: int = 5
    most: int = 80

    def more(self, harmonics: int) -> int:
        """Return the next larger number of harmonics."""
        return min(self.most, harmonics + max(2, harmonics // 2))


def unknown_scale(oscillator: Oscillator, harmonics: int) -> Floats:
    """Return the size (m,) of each real unknown."""
    return np.tile(oscillator.scales, 2 * harmonics + 1)


def equilibrium(oscillator: Oscillator) -> Orbit:
    """Return the state of rest under the static efforts alone, as an orbit at 0 rad/s.

    Raises
    ------
    NoConvergence
        If none is found from the scales of the motions.
    """
    k = oscillator.size
    at_rest = oscillator.linear(np.zeros(1))[0, :, :k].real

    def evaluate(q: Floats) -> tuple[Floats, Floats]:
        law = oscillator.law(q[None], np.zeros((1, k)))
        return at_rest @ q + law.effort[0] - oscillator.static, at_rest + law.by_motion[0]

    try:
        found, _, _ = converge(evaluate, np.zeros(k), oscillator.scales, _STEPS)
    except NoConvergence as error:
        raise NoConvergence(f"no state of rest was found: {error}") from None
    return Orbit(0.0, 0.0, found[None] + 0j)


def at_fixed_drive(oscillator: Oscillator, guess: Orbit) -> Orbit:
    """Return the orbit near a guess with the guess's harmonics, frequency and drive."""

    def evaluate(x: Floats) -> tuple[Floats, Floats]:
        spectrum = complex_spectrum(x, oscillator.size)
        found = balance(oscillator, Orbit(guess.omega, guess.level, spectrum))
        return found.residual, found.jacobian

    scale = unknown_scale(oscillator, guess.harmonics)
    x, _, _ = converge(evaluate, real_vector(guess.spectrum), scale, _STEPS)
    return Orbit(guess.omega, guess.level, complex_spectrum(x, oscillator.size))


def resolved(oscillator: Oscillator, guess: Orbit, resolution: Resolution) -> Orbit:
    """Return the orbit near a guess with as many harmonics as it needs.

    Raises
    ------
    NoConvergence
        If none is found.
    """
    found = at_fixed_drive(oscillator, guess.with_harmonics(max(guess.harmonics, resolution.least)))
    while missing_motion(oscillator, found) > resolution.missing:
        if found.harmonics >= resolution.most:
            break
        more = resolution.more(found.harmonics)
        found = at_fixed_drive(oscillator, found.with_harmonics(more))
    return found
