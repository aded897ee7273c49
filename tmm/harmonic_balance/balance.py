"""The balance of harmonics, and its exact derivatives, by alternating frequency and time.

The law is evaluated at equal steps over one period and transformed back; so is its tangent,
whose harmonics make the Jacobian (Cameron and Griffin 1989; Krack and Gross, *Harmonic Balance
for Nonlinear Vibration Problems*, 2019).  Unknowns are real: Q₀, then real and imaginary part of
each harmonic.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import TypeAlias

import numpy as np

from tactgen.geometry.arrays import Complex, Floats


@dataclass(frozen=True)
class LawPoint:
    """A law at n instants."""

    #: (n, k) What the law asks for at each coordinate, positive against a positive motion
    effort: Floats
    #: (n, k, k) Derivatives of the effort by the motions and by their rates
    by_motion: Floats
    by_rate: Floats


#: From motions (n, k) and their rates (n, k), at n instants each on its own.
Law: TypeAlias = Callable[[Floats, Floats], LawPoint]


@dataclass(frozen=True)
class Oscillator:
    """Linear system at k coordinates with a nonlinear law and its excitation."""

    #: From angular frequencies (n,) ≥ 0 in rad/s to (n, k, k + 1) complex: D(Ω), and in the last
    #: column the effort at each coordinate per unit of drive, the coordinates being held; on the
    #: same side of the equation as D, so -1 for a force of one unit that pushes
    linear: Callable[[Floats], Complex]
    law: Law  #: What is not linear
    static: Floats  #: (k,) Constant efforts from outside
    scales: Floats  #: (k,) Motions of the size that matters, one for each coordinate

    @property
    def size(self) -> int:
        """Number of coordinates."""
        return int(self.scales.size)


@dataclass(frozen=True)
class Orbit:
    """One steady oscillation."""

    omega: float  #: Angular frequency (rad/s) of the drive
    level: float  #: Amplitude (peak) of the drive, in its unit
    spectrum: Complex  #: (harmonics + 1, k) complex Q_n; Q₀ is real

    @property
    def harmonics(self) -> int:
        """Highest harmonic."""
        return int(self.spectrum.shape[0]) - 1

    @property
    def frequency(self) -> float:
        """Frequency (Hz) of the drive."""
        return self.omega / (2.0 * np.pi)

    def motion(self, samples: int) -> Floats:
        """Q (samples, k) at equal steps over one period, which begins with the drive's peak.

        Parameters
        ----------
        samples : int
            More than twice the harmonics.
        """
        padded = np.zeros((samples // 2 + 1, self.spectrum.shape[1]), dtype=complex)
        padded[: self.harmonics + 1] = 0.5 * samples * self.spectrum
        padded[0] *= 2.0
        return np.asarray(np.fft.irfft(padded, n=samples, axis=0))

    def with_harmonics(self, harmonics: int) -> Orbit:
        """Orbit with more harmonics, which are 0, or with fewer."""
        spectrum = np.zeros((harmonics + 1, self.spectrum.shape[1]), dtype=complex)
        kept = min(harmonics, self.harmonics) + 1
        spectrum[:kept] = self.spectrum[:kept]
        return Orbit(self.omega, self.level, spectrum)


#: Instants per period and harmonic.  A smooth law needs 4; a kink's aliases fall with the square.
_SAMPLES = 16
_LEAST_SAMPLES = 64
#: Relative step of the central difference of D by frequency, whose error goes with its square.
_STEP = 1e-5


@dataclass(frozen=True)
class Balance:
    """The residual of an orbit with its derivatives; m = k (2 harmonics + 1)."""

    residual: Floats  #: (m,) Efforts left over
    jacobian: Floats  #: (m, m) By the unknowns
    #: (m,) By the two parameters
    by_omega: Floats
    by_level: Floats


@dataclass(frozen=True)
class LawHarmonics:
    """The law along an orbit."""

    effort: Complex  #: (2 H + 1, k) complex F_n up to twice the orbit's harmonics, as Q_n
    #: (4 H + 1, k, k) complex Two-sided coefficients of the tangents, of n = −2 H to 2 H
    by_motion: Complex
    by_rate: Complex


def samples(harmonics: int) -> int:
    """Number of instants per period, a power of two."""
    wanted = max(_LEAST_SAMPLES, _SAMPLES * harmonics)
    return int(2 ** np.ceil(np.log2(wanted)))


def law_harmonics(oscillator: Oscillator, orbit: Orbit) -> LawHarmonics:
    """Harmonics of the law along an orbit."""
    count, highest, k = samples(orbit.harmonics), 2 * orbit.harmonics, oscillator.size
    # motions and rates, then all that the law says, in one transform each
    rates = 1j * orbit.omega * np.arange(orbit.harmonics + 1)[:, None] * orbit.spectrum
    both = np.concatenate([orbit.spectrum, rates], axis=1)
    moved = replace(orbit, spectrum=both).motion(count)
    at = oscillator.law(moved[:, :k], moved[:, k:])
    tangents = (t.reshape(count, k * k) for t in (at.by_motion, at.by_rate))
    right = np.fft.rfft(np.concatenate([at.effort, *tangents], axis=1), axis=0)
    right = right[: highest + 1] / count
    effort = 2.0 * right[:, :k]
    effort[0] *= 0.5
    two_sided = np.concatenate([right[:0:-1, k:].conj(), right[:, k:]])
    return LawHarmonics(effort, *np.moveaxis(two_sided.reshape(-1, 2, k, k), 1, 0))


def real_vector(spectrum: Complex) -> Floats:
    """Harmonics (H + 1, k) as real unknowns (m,)."""
    parts = np.stack([spectrum.real, spectrum.imag], axis=1)
    flat, k = parts.ravel(), spectrum.shape[1]
    return np.concatenate([flat[:k], flat[2 * k :]])


def complex_spectrum(vector: Floats, k: int) -> Complex:
    """Real unknowns (m,) as harmonics (H + 1, k)."""
    parts = np.concatenate([vector[:k], np.zeros(k), vector[k:]]).reshape(-1, 2, k)
    return np.asarray(parts[:, 0] + 1j * parts[:, 1])


def balance(oscillator: Oscillator, orbit: Orbit) -> Balance:
    """Residual of an orbit and all its derivatives."""
    k, n = oscillator.size, np.arange(orbit.harmonics + 1)
    at, above, below = (n * orbit.omega * (1.0 + s) for s in (0.0, _STEP, -_STEP))
    linear = oscillator.linear(np.concatenate([at, above, below]))
    d, more, less = np.split(linear, 3)
    slope = (more - less) / (2.0 * _STEP * orbit.omega)
    law = law_harmonics(oscillator, orbit)
    q = orbit.spectrum
    residual = np.einsum("nij,nj->ni", d[..., :k], q) + law.effort[: n.size]
    residual[0] -= oscillator.static
    residual[1] += d[1, :, k] * orbit.level
    by_omega = np.einsum("nij,nj->ni", slope[..., :k], q)
    by_rate = _columns(law.by_rate, orbit.harmonics)
    by_omega += _times(by_rate, 1j * n[:, None] * q)
    by_omega[1] += slope[1, :, k] * orbit.level
    by_level = np.zeros_like(residual)
    by_level[1] = d[1, :, k]
    return Balance(
        real_vector(residual),
        _jacobian(d[..., :k], _columns(law.by_motion, orbit.harmonics), by_rate, orbit.omega),
        real_vector(by_omega),
        real_vector(by_level),
    )


def _columns(tangent: Complex, highest: int) -> tuple[Complex, Complex]:
    """DF_n by the real and by the imaginary part of Q_l, (H + 1, H + 1, k, k) each."""
    n = np.arange(highest + 1)
    zero = 2 * highest
    difference = tangent[zero + n[:, None] - n]
    total = tangent[zero + n[:, None] + n]
    real, imaginary = difference + total, 1j * (difference - total)
    for part in (real, imaginary):  # the constant has half the weight of a wave, both ways
        part[0] *= 0.5
    real[:, 0] = 2.0 * tangent[zero + n]
    real[0, 0] = tangent[zero]
    return real, imaginary


def _jacobian(
    d: Complex, by_motion: tuple[Complex, Complex], by_rate: tuple[Complex, Complex], omega: float
) -> Floats:
    """Derivatives (m, m); tangents as :func:`_columns`, the first of which is spent."""
    harmonics, k = d.shape[0] - 1, d.shape[1]
    n = np.arange(harmonics + 1)
    real, imaginary = by_motion
    by_rate_real, by_rate_imaginary = by_rate
    speed = (n * omega)[None, :, None, None]
    real += speed * by_rate_imaginary
    imaginary -= speed * by_rate_real
    real[n, n] += d
    imaginary[n, n] += 1j * d
    full = np.empty((n.size, 2, k, n.size, 2, k))
    for place, columns in enumerate((real, imaginary)):
        full[:, 0, :, :, place, :] = columns.real.transpose(0, 2, 1, 3)
        full[:, 1, :, :, place, :] = columns.imag.transpose(0, 2, 1, 3)
    side = 2 * k * n.size
    kept = np.concatenate([np.arange(k), np.arange(2 * k, side)])
    return np.asarray(full.reshape(side, side)[kept[:, None], kept])


def _times(columns: tuple[Complex, Complex], motion: Complex) -> Complex:
    """Harmonics of a tangent's product with a motion's (H + 1, k); see :func:`_columns`."""
    real, imaginary = columns
    product = np.einsum("nlij,lj->ni", real, motion.real)
    product += np.einsum("nlij,lj->ni", imaginary, motion.imag)
    return np.asarray(product)


def missing_motion(oscillator: Oscillator, orbit: Orbit) -> float:
    """Share of the motion that the harmonics left out would have.

    The law's efforts between the orbit's highest harmonic and twice that, answered by the
    linear system, relative to the orbit's own oscillation; of the worst coordinate, each
    compared at least with its scale.
    """
    h = orbit.harmonics
    beyond = np.arange(h + 1, 2 * h + 1)
    d = oscillator.linear(beyond * orbit.omega)[..., : oscillator.size]
    effort = law_harmonics(oscillator, orbit).effort[h + 1 :]
    left = np.linalg.solve(d, effort[..., None])[..., 0]
    size = np.sqrt((np.abs(orbit.spectrum[1:]) ** 2).sum(axis=0))
    size = np.maximum(size, oscillator.scales)
    return float((np.sqrt((np.abs(left) ** 2).sum(axis=0)) / size).max())


#: Stop after a step that is this share of the unknowns' scale: what is left goes as its square.
TOLERANCE = 1e-7
_SHORTEST = 2.0**-6


class NoConvergence(ArithmeticError):
    """Newton's method did not find an orbit; the message says in one sentence why."""


def converge(
    evaluate: Callable[[Floats], tuple[Floats, Floats]], start: Floats, scale: Floats, most: int
) -> tuple[Floats, int, Floats]:
    """Zero of a function, the number of steps taken, and the Jacobian there (m, m).

    Parameters
    ----------
    evaluate : callable
        From unknowns (m,) to residual (m,) and Jacobian (m, m).
    start : (m,) array
        First guess.
    scale : (m,) array
        Size of each unknown.
    most : int
        Steps allowed.

    Raises NoConvergence if the steps do not become small.
    """
    x = start
    residual, jacobian = evaluate(x)
    for count in range(1, most + 1):
        scaled = jacobian * scale
        step = -_solve(scaled, residual)
        size = float(np.linalg.norm(step))
        if size <= TOLERANCE:
            return x + scale * step, count, jacobian
        length = 1.0
        while True:
            there = x + length * scale * step
            residual, jacobian = evaluate(there)
            after = float(np.linalg.norm(_solve(scaled, residual)))
            if after <= (1.0 - 0.25 * length) * size:
                break
            length *= 0.5
            if not np.isfinite(after) or length < _SHORTEST:
                raise NoConvergence("Newton's method did not settle: no step brought it nearer")
        x = there
    raise NoConvergence(f"Newton's method did not settle in {most} steps")


def _solve(matrix: Floats, right: Floats) -> Floats:
    try:
        return np.asarray(np.linalg.solve(matrix, right))
    except np.linalg.LinAlgError:
        raise NoConvergence("the equations are singular: nothing holds a coordinate") from None
