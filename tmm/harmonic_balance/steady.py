"""One orbit at a stated frequency and drive, from a guess that is near; and the state of rest."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np

from tactgen.geometry.arrays import Bools, Complex, Floats
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
    found = at_fixed_drive(oscillator, guess.with_harmonics(max(guess.harmonics, resolution.least)))
    while missing_motion(oscillator, found) > resolution.missing:
        if found.harmonics >= resolution.most:
            break
        more = resolution.more(found.harmonics)
        found = at_fixed_drive(oscillator, found.with_harmonics(more))
    return found


_NEWTON_STEPS = 40


def free_oscillation(
    oscillator: Oscillator, turning_point: float, guess: Orbit, *, resolution: Resolution
) -> Orbit:
    """Free oscillation that passes a turning point, from a guess of about its frequency and motion.

    That point is the motion of the first coordinate at the instant at which all is at rest.  Only
    real parts of the guess are used, and what damps is an error of the answer, not noticed.

    Raises NoConvergence if none is found, or its frequency is not positive.
    """
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

#: Degree, and the places between the Chebyshev points at which a polynomial is held against the
#: function, in units of half an interval.
_DEGREE = 20
_CHECKED = np.cos(np.pi * (np.array([0.5, 5.5, 10.5, 14.5, 19.5])) / _DEGREE)
#: Error of an entry over its largest value on the interval: what the function's rounding leaves.
_TOLERANCE = 1e-12
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
_NODES = np.cos(np.pi * np.arange(_DEGREE + 1) / _DEGREE)
_WEIGHTS = np.where(np.arange(_DEGREE + 1) % 2, -1.0, 1.0)
_WEIGHTS[[0, -1]] *= 0.5


class Tabulated:
    """The function, from its table where that has been made.

    Called with frequencies (n,) in Hz, 0 or above, returns entries (n, e), or some of them.
    """

    def __init__(self, function: Function) -> None:
        self._function = function
        self._asked = 0
        self._ends = np.zeros(1)  # of the intervals, ascending
        self._values = np.zeros((0, _DEGREE + 1, 0), dtype=complex)
        self._smooth: Bools = np.zeros(0, dtype=bool)

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
        values = self._values[..., entries]
        found = _interpolated(values[at], (2.0 * frequencies - low - high) / (high - low))
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
            places = np.concatenate([_NODES, _CHECKED])
            asked = 0.5 * (low + high) + 0.5 * (high - low) * places
            # the ends exactly, so that rounding leads to no frequency below 0
            asked[:, 0], asked[:, _DEGREE] = pending[:, 1], pending[:, 0]
            values = self._function(asked.ravel()).reshape(*asked.shape, -1)
            nodes, known = values[:, : _DEGREE + 1], values[:, _DEGREE + 1 :]
            size = np.abs(nodes).max(axis=1, keepdims=True)
            each = np.repeat(nodes, _CHECKED.size, axis=0)
            met = _interpolated(each, np.tile(_CHECKED, len(nodes))).reshape(known.shape)
            smooth = (np.abs(met - known) <= _TOLERANCE * size).all(axis=(1, 2))
            short = high - low < _SHORTEST * np.maximum(high, _SHORTEST * top)
            ended = smooth | short[:, 0] | (len(pending) > _MOST)
            done += [
                (float(pending[i, 1]), nodes[i], bool(smooth[i])) for i in np.flatnonzero(ended)
            ]
            left = pending[~ended]
            middle = left.mean(axis=1)
            pending = np.concatenate(
                [np.stack([left[:, 0], middle], 1), np.stack([middle, left[:, 1]], 1)]
            )
        done.sort(key=lambda interval: interval[0])
        made = np.stack([values for _, values, _ in done])
        self._values = np.concatenate([self._values, made]) if self._smooth.size else made
        self._ends = np.append(self._ends, [end for end, _, _ in done])
        self._smooth = np.append(self._smooth, [smooth for _, _, smooth in done])


def _interpolated(values: Complex, places: Floats) -> Complex:
    """Polynomials (n, e) through values (n, degree + 1, e) at places (n,) from −1 to 1.

    By the barycentric formula (Berrut and Trefethen, SIAM Review 46 (2004) 501).
    """
    apart = places[:, None] - _NODES
    hit = apart == 0.0
    factor = _WEIGHTS / np.where(hit, 1.0, apart)
    on_node = hit.any(axis=1)
    factor[on_node] = hit[on_node]
    found = np.matmul(factor[:, None, :], values)[:, 0]
    return np.asarray(found / factor.sum(axis=1)[:, None])
