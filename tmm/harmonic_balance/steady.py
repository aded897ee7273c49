"""One orbit at a stated frequency and drive, from a guess that is near; and the state of rest."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tactgen.geometry.arrays import Complex, Floats
from tactgen.tmm.harmonic_balance.balance import (
    LawHarmonics,
    NoConvergence,
    Orbit,
    Oscillator,
    balance,
    complex_spectrum,
    converge,
    law_harmonics,
    missing_motion,
    real_vector,
)

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


_NEWTON_STEPS = 40


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
    found, _, _ = converge(evaluate, start, scale, _NEWTON_STEPS)
    return orbit(found)


#: Frequencies at which resonances of the system without coupling are looked for, and the first
#: ones at which the determinant is evaluated.
_SCAN, _FIRST = 513, 33
#: Largest turn (rad) between neighbours, and how close to each other they may come (of Ω).
_TURN, _CLOSEST = 0.7, 1e-9


def unstable_exponents(oscillator: Oscillator, orbit: Orbit) -> int | None:
    """Return the number of Floquet exponents with a positive real part; None on the very edge.

    Parameters
    ----------
    oscillator : Oscillator
        With losses; its linear part, with the law's mean tangent, must be stable.
    orbit : Orbit
        A solved orbit.
    """
    law = law_harmonics(oscillator, orbit)
    at = np.union1d(
        np.linspace(0.0, 0.5 * orbit.omega, _FIRST), _near_resonances(oscillator, orbit, law)
    )
    values = _determinants(oscillator, orbit, law, at)
    while True:
        turns = np.angle(values[1:] / values[:-1])
        wide = np.flatnonzero(np.abs(turns) > _TURN)
        if not wide.size:
            break
        if (np.diff(at)[wide] < _CLOSEST * orbit.omega).any():
            return None
        between = 0.5 * (at[wide] + at[wide + 1])
        at = np.insert(at, wide + 1, between)
        values = np.insert(values, wide + 1, _determinants(oscillator, orbit, law, between))
    return round(float(-turns.sum() / np.pi))


def _diagonal(oscillator: Oscillator, orbit: Orbit, law: LawHarmonics, at: Floats) -> Complex:
    """Return the blocks (a, 2 H + 1, k, k) of harmonics −H to H without coupling."""
    h, k = orbit.harmonics, oscillator.size
    omega = at[:, None] + orbit.omega * np.arange(-h, h + 1)
    d = oscillator.linear(np.abs(omega).ravel())[..., :k].reshape(*omega.shape, k, k)
    d = np.where((omega < 0.0)[..., None, None], d.conj(), d)
    mean, damping = law.by_motion[2 * h].real, law.by_rate[2 * h].real
    return np.asarray(d + mean + 1j * omega[..., None, None] * damping)


def _near_resonances(oscillator: Oscillator, orbit: Orbit, law: LawHarmonics) -> Floats:
    """Return frequencies round those at which some harmonic without coupling is least held."""
    scan = np.linspace(0.0, 0.5 * orbit.omega, _SCAN)
    size = np.abs(np.linalg.det(_diagonal(oscillator, orbit, law, scan)))
    least = (size[1:-1] < size[:-2]) & (size[1:-1] < size[2:])
    at = np.flatnonzero(least.any(axis=1)) + 1
    return np.asarray(scan[np.unique(np.concatenate([at - 1, at, at + 1]))])


def _determinants(oscillator: Oscillator, orbit: Orbit, law: LawHarmonics, at: Floats) -> Complex:
    """Return det H(jω), over that without coupling, its magnitude brought near 1, at ω (a,)."""
    h, k = orbit.harmonics, oscillator.size
    diagonal = _diagonal(oscillator, orbit, law, at)
    n = np.arange(2 * h + 1)
    lag = n[:, None] - n + 2 * h
    omega = at[:, None] + orbit.omega * (n - h)
    found = []
    for blocks, of in zip(diagonal, omega, strict=True):
        coupling = law.by_motion[lag] + 1j * of[None, :, None, None] * law.by_rate[lag]
        coupling[n, n] = 0.0
        relative = np.linalg.solve(blocks[:, None], coupling)
        matrix = relative.transpose(0, 2, 1, 3).reshape(n.size * k, n.size * k)
        found.append(np.linalg.slogdet(matrix + np.eye(n.size * k))[0])
    return np.array(found)
