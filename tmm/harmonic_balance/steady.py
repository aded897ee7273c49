"""One orbit at a stated frequency and drive, from a guess that is near; and the state of rest."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import TypeAlias

import numpy as np
from numpy.polynomial.chebyshev import chebvander

from tactgen.geometry.arrays import Complex, Floats
from tactgen.geometry.errors import InputError
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
    """Number of harmonics, and how they are chosen."""

    missing: float = 1e-4  #: Share of the motion that the harmonics left out may have
    #: Fewest and most harmonics
    least: int = 5
    most: int = 80

    def more(self, harmonics: int) -> int:
        """Next larger number of harmonics."""
        return min(self.most, harmonics + max(2, harmonics // 2))


def equilibrium(oscillator: Oscillator) -> Orbit:
    """State of rest under the static efforts alone, as an orbit at 0 rad/s.

    Raises NoConvergence if none is found from the scales of the motions.
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
    """Orbit near a guess with the guess's harmonics, frequency and drive."""

    def evaluate(x: Floats) -> tuple[Floats, Floats]:
        spectrum = complex_spectrum(x, oscillator.size)
        found = balance(oscillator, Orbit(guess.omega, guess.level, spectrum))
        return found.residual, found.jacobian

    scale = np.tile(oscillator.scales, 2 * guess.harmonics + 1)  # of each real unknown
    x, _, _ = converge(evaluate, real_vector(guess.spectrum), scale, _STEPS)
    return Orbit(guess.omega, guess.level, complex_spectrum(x, oscillator.size))


def resolved(oscillator: Oscillator, guess: Orbit, resolution: Resolution) -> Orbit:
    """Orbit near a guess with as many harmonics as it needs.

    Raises NoConvergence if none is found.
    """
    return _resolved(oscillator, partial(at_fixed_drive, oscillator), guess, resolution)


def _resolved(
    oscillator: Oscillator, solve: Callable[[Orbit], Orbit], guess: Orbit, resolution: Resolution
) -> Orbit:
    orbit = guess.with_harmonics(max(guess.harmonics, resolution.least))
    while True:
        orbit = solve(orbit)
        enough = missing_motion(oscillator, orbit) <= resolution.missing
        if enough or orbit.harmonics >= resolution.most:
            return orbit
        orbit = orbit.with_harmonics(resolution.more(orbit.harmonics))


def free_oscillation(
    oscillator: Oscillator, turning_point: float, guess: Orbit, *, resolution: Resolution
) -> Orbit:
    """Free oscillation that passes a turning point, from a guess of about its frequency and motion.

    That point is the motion of the first coordinate at the instant at which all is at rest.  Only
    real parts of the guess are used, and what damps is an error of the answer, not noticed.

    Raises NoConvergence if none is found, or its frequency is not positive.
    """
    return _resolved(oscillator, partial(_free, oscillator, turning_point), guess, resolution)


def _free(oscillator: Oscillator, turning_point: float, guess: Orbit) -> Orbit:
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


#: Frequencies at which resonances of the system without coupling are looked for, and the first
#: ones at which the determinant is evaluated.
_SCAN, _FIRST = 513, 33
#: Largest turn (rad) between neighbours, and how close to each other they may come (of Ω).
_TURN, _CLOSEST = 0.7, 1e-9


def unstable_exponents(oscillator: Oscillator, orbit: Orbit) -> int | None:
    """Number of Floquet exponents with a positive real part; None on the very edge.

    Of a solved orbit with losses; the linear part, with the law's mean tangent, must be stable.
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
    """Blocks (a, 2 H + 1, k, k) of harmonics −H to H without coupling."""
    h, k = orbit.harmonics, oscillator.size
    omega = at[:, None] + orbit.omega * np.arange(-h, h + 1)
    d = oscillator.linear(np.abs(omega).ravel())[..., :k].reshape(*omega.shape, k, k)
    d = np.where((omega < 0.0)[..., None, None], d.conj(), d)
    mean, damping = law.by_motion[2 * h].real, law.by_rate[2 * h].real
    return np.asarray(d + mean + 1j * omega[..., None, None] * damping)


def _near_resonances(oscillator: Oscillator, orbit: Orbit, law: LawHarmonics) -> Floats:
    """Frequencies round those at which some harmonic without coupling is least held."""
    scan = np.linspace(0.0, 0.5 * orbit.omega, _SCAN)
    size = np.abs(np.linalg.det(_diagonal(oscillator, orbit, law, scan)))
    least = (size[1:-1] < size[:-2]) & (size[1:-1] < size[2:])
    at = np.flatnonzero(least.any(axis=1)) + 1
    return np.asarray(scan[np.unique(np.concatenate([at - 1, at, at + 1]))])


def _determinants(oscillator: Oscillator, orbit: Orbit, law: LawHarmonics, at: Floats) -> Complex:
    """Det H(jω), over that without coupling, its magnitude brought near 1, at ω (a,)."""
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


#: From frequencies (n,) to entries (n, e).
Function: TypeAlias = Callable[[Floats], Complex]

#: Degree of the polynomials, the Chebyshev points that they go through, and what makes their
#: Chebyshev coefficients of the values there.
_DEGREE = 24
_NODES = np.cos(np.pi * np.arange(_DEGREE + 1) / _DEGREE)
_COEFFICIENTS = np.linalg.inv(chebvander(_NODES, _DEGREE))
#: Size of the last coefficients over the largest value on the interval, below which a polynomial is
#: the function: what the function's rounding leaves.
_LAST, _TOLERANCE = 4, 1e-12
#: Shortest interval over the frequency at its upper end, and that over the table's.
_SHORTEST = 1e-4
#: Intervals in work at once, beyond which what is left is not smooth: rounding above the tolerance
#: would have all of it divided down to the shortest.
_MOST = 2000
#: Frequencies that are asked of the function itself before a table is worth its making, and how
#: many are read at once.
_FIRST_TABLE, _AT_ONCE = 3000, 1000
#: The table reaches beyond what is asked by this factor.
_BEYOND = 1.3

_ALL = slice(None)


class Tabulated:
    """The function, from its table where that has been made.

    Called with frequencies (n,) in Hz, 0 or above, returns entries (n, e), or some of them.
    """

    def __init__(self, function: Function) -> None:
        self._function = function
        self._asked = 0
        # of the intervals, ascending: upper end, coefficients (degree + 1, e), whether they are it
        self._done: list[tuple[float, Complex, bool]] = []
        self._ends = np.zeros(1)

    def __call__(self, frequencies: Floats, entries: slice = _ALL) -> Complex:
        """Entries."""
        if self._asked < _FIRST_TABLE:
            self._asked += frequencies.size
            return self._function(frequencies)[:, entries]
        top = float(frequencies.max(initial=0.0))
        if top > self._ends[-1]:
            try:
                self._extend(_BEYOND * top)
            except InputError:  # it ends between here and there, or even before
                return self._function(frequencies)[:, entries]
        parts = range(0, frequencies.size, _AT_ONCE)
        found = [self._read(frequencies[i : i + _AT_ONCE], entries) for i in parts]
        return found[0] if len(found) == 1 else np.concatenate(found)

    def _read(self, frequencies: Floats, entries: slice) -> Complex:
        at = np.maximum(np.searchsorted(self._ends, frequencies) - 1, 0)
        low, high = self._ends[at], self._ends[at + 1]
        powers = chebvander((2.0 * frequencies - low - high) / (high - low), _DEGREE)
        found: Complex = np.matmul(powers[:, None], self._polynomials[..., entries][at])[:, 0]
        rough = ~self._smooth[at]
        if rough.any():
            found[rough] = self._function(frequencies[rough])[:, entries]
        return found

    def _extend(self, top: float) -> None:
        """Divide the range between the table's end and a frequency."""
        pending = np.array([[self._ends[-1], top]])
        done: list[tuple[float, Complex, bool]] = []
        while pending.size:
            low, high = pending[:, :1], pending[:, 1:]
            # the lower end exactly, so that rounding leads to no frequency below 0
            asked = low + 0.5 * (high - low) * (1.0 + _NODES)
            values = self._function(asked.ravel()).reshape(*asked.shape, -1)
            made = _COEFFICIENTS @ values
            size = np.abs(values).max(axis=1, keepdims=True)
            good = (np.abs(made[:, -_LAST:]) <= _TOLERANCE * size).all(axis=(1, 2))
            short = high - low < _SHORTEST * np.maximum(high, _SHORTEST * top)
            ended = good | short[:, 0] | (len(pending) > _MOST)
            done += zip(pending[ended, 1], made[ended], good[ended], strict=True)
            left = pending[~ended]
            middle = left.mean(axis=1)
            pending = np.concatenate(
                [np.stack([left[:, 0], middle], 1), np.stack([middle, left[:, 1]], 1)]
            )
        self._done += sorted(done, key=lambda interval: interval[0])
        ends, polynomials, smooth = zip(*self._done, strict=True)
        self._ends = np.array([0.0, *ends])
        self._polynomials, self._smooth = np.array(polynomials), np.array(smooth)
