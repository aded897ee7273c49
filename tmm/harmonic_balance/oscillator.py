"""What oscillates: a linear system seen at a few coordinates, and the law that acts on these.

    D(Ω) q + f(q, q̇) = static + excitation,   q(t) = Q₀ + Re Σ Q_n e^{jnΩt}

Everything linear, of whatever size, is condensed to D over the coordinates on which the law acts.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np

from tactgen.geometry.arrays import Complex, Floats


@dataclass(frozen=True)
class LawPoint:
    """A law at n instants.

    Attributes
    ----------
    effort : (n, k) array
        What the law asks for at each coordinate, positive against a positive motion.
    by_motion, by_rate : (n, k, k) array
        Derivatives of the effort by the motions and by their rates.
    """

    effort: Floats
    by_motion: Floats
    by_rate: Floats


#: From motions (n, k) and their rates (n, k), at n instants each on its own.
Law: TypeAlias = Callable[[Floats, Floats], LawPoint]


@dataclass(frozen=True)
class Oscillator:
    """A linear system at k coordinates, the law that acts on them, and what excites both.

    Attributes
    ----------
    linear : callable
        From angular frequencies (n,) ≥ 0 in rad/s to (n, k, k + 1) complex: D(Ω), and in the last
        column the effort at each coordinate per unit of drive, the coordinates being held; on
        the same side of the equation as D, so -1 for a force of one unit that pushes.
    law : Law
        What is not linear.
    static : (k,) array
        Constant efforts from outside.
    scales : (k,) array
        Motions of the size that matters, one for each coordinate.
    """

    linear: Callable[[Floats], Complex]
    law: Law
    static: Floats
    scales: Floats

    @property
    def size(self) -> int:
        """Number of coordinates."""
        return int(self.scales.size)


@dataclass(frozen=True)
class Orbit:
    """One steady oscillation.

    Attributes
    ----------
    omega : float
        Angular frequency (rad/s) of the drive.
    level : float
        Amplitude (peak) of the drive, in its unit.
    spectrum : (harmonics + 1, k) complex array
        Q_n; Q₀ is real.
    """

    omega: float
    level: float
    spectrum: Complex

    @property
    def harmonics(self) -> int:
        """Highest harmonic."""
        return int(self.spectrum.shape[0]) - 1

    @property
    def frequency(self) -> float:
        """Frequency (Hz) of the drive."""
        return self.omega / (2.0 * np.pi)

    def motion(self, samples: int) -> Floats:
        """Return q (samples, k) at equal steps over one period, which begins with the drive's peak.

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
        """Return the same orbit with more harmonics, which are 0, or with fewer."""
        spectrum = np.zeros((harmonics + 1, self.spectrum.shape[1]), dtype=complex)
        kept = min(harmonics, self.harmonics) + 1
        spectrum[:kept] = self.spectrum[:kept]
        return Orbit(self.omega, self.level, spectrum)
