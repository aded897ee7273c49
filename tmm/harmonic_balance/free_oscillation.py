"""Free oscillation of a lossless system: the backbone on which resonances lie.

Such an oscillation can run backwards, so it consists of cosines and rests at its turning points.
"""

from __future__ import annotations

import numpy as np

from tactgen.geometry.arrays import Floats
from tactgen.tmm.harmonic_balance.balance import balance, missing_motion
from tactgen.tmm.harmonic_balance.newton import NoConvergence, converge
from tactgen.tmm.harmonic_balance.oscillator import Orbit, Oscillator
from tactgen.tmm.harmonic_balance.steady import Resolution

_STEPS = 40


def free_oscillation(
    oscillator: Oscillator,
    turning_point: float,
    guess: Orbit,
    *,
    resolution: Resolution | None = None,
) -> Orbit:
    """Return the free oscillation that passes a turning point.

    Parameters
    ----------
    oscillator : Oscillator
        Without losses: what damps is an error of the answer, not noticed.
    turning_point : float
        Motion of the first coordinate at the instant at which all is at rest.
    guess : Orbit
        Of about that frequency and motion; only real parts are used.

    Raises
    ------
    NoConvergence
        If none is found, or its frequency is not positive.
    """
    resolution = resolution or Resolution()
    orbit = guess.with_harmonics(max(guess.harmonics, resolution.least))
    while True:
        orbit = _solved(oscillator, turning_point, orbit)
        enough = missing_motion(oscillator, orbit) <= resolution.missing
        if enough or orbit.harmonics >= resolution.most:
            return orbit
        orbit = orbit.with_harmonics(resolution.more(orbit.harmonics))


def _solved(oscillator: Oscillator, turning_point: float, guess: Orbit) -> Orbit:
    k, harmonics = oscillator.size, guess.harmonics
    # of the real unknowns (and of the equations) those that are cosines
    harmonic = np.repeat(np.arange(2 * harmonics + 1), k)
    cosines = (harmonic % 2 == 1) | (harmonic == 0)
    at_turn = np.tile(np.eye(k)[0], harmonics + 1)

    def orbit(y: Floats) -> Orbit:
        if y[-1] <= 0.0:
            raise NoConvergence("the frequency of a free oscillation became negative")
        return Orbit(float(y[-1]), 0.0, y[:-1].reshape(harmonics + 1, k) + 0j)

    def evaluate(y: Floats) -> tuple[Floats, Floats]:
        found = balance(oscillator, orbit(y))
        jacobian = np.zeros((y.size, y.size))
        jacobian[:-1, :-1] = found.jacobian[np.ix_(cosines, cosines)]
        jacobian[:-1, -1] = found.by_omega[cosines]
        jacobian[-1, :-1] = at_turn
        return np.append(found.residual[cosines], at_turn @ y[:-1] - turning_point), jacobian

    start = np.append(guess.spectrum.real.ravel(), guess.omega)
    scale = np.append(np.tile(oscillator.scales, harmonics + 1), guess.omega)
    found, _, _ = converge(evaluate, start, scale, _STEPS)
    return orbit(found)
