"""A load of springs, dampers and masses that follows a measured impedance and only takes energy.

Every passive linear load has an impedance that is a positive-real function of s = jΩ, and each of
these is a sum, with weights that are not negative, of a mass, a spring and resonators of all
frequencies (Herglotz; Brune's synthesis uses the same).  A fit over a dictionary of damped
resonators with such weights is therefore passive at every frequency, whatever the data, and needs
no search: it is one least-squares problem with bounds (NNLS), whose solution is unique in value.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tactgen.geometry.arrays import Complex, Floats


@dataclass(frozen=True)
class Dictionary:
    """Resonators that a fit may use.

    Attributes
    ----------
    per_decade : int
        How many frequencies a decade.
    ratios : tuple of float
        Their damping ratios.
    reach : float
        How far beyond the band they reach, a factor: what lies further off acts in the band as
        spring, damper or mass.
    """

    per_decade: int = 10
    ratios: tuple[float, ...] = (0.05, 0.2, 1.0)
    reach: float = 10.0


_RICH = Dictionary()


@dataclass(frozen=True)
class PassiveFit:
    """An impedance Z(s) = m s + d + k/s + Σ (a s + b)/(s² + 2ζω s + ω²), 0 ≤ b ≤ 2ζω a.

    Attributes
    ----------
    mass, damping, stiffness : float
        m, d and k (kg, N s/m, N/m), none negative.
    omega, ratio, a, b : (k,) array
        Angular frequency (rad/s), damping ratio and numerator of each resonator.
    """

    mass: float
    damping: float
    stiffness: float
    omega: Floats
    ratio: Floats
    a: Floats
    b: Floats

    def stiffness_at(self, frequencies: Floats) -> Complex:
        """Return the dynamic stiffness s Z (n,) in N/m at frequencies from 0 on (Hz)."""
        s = 2j * np.pi * np.asarray(frequencies, dtype=float)[:, None]
        below = s**2 + 2.0 * self.ratio * self.omega * s + self.omega**2
        resonators = (s * (self.a * s + self.b) / below).sum(axis=1)
        plain = self.mass * s**2 + self.damping * s + self.stiffness
        return np.asarray(plain[:, 0] + resonators)


def passive_fit(
    frequencies: Floats, impedance: Complex, dictionary: Dictionary = _RICH
) -> PassiveFit:
    """Return the passive load with the least sum of squared relative errors.

    Parameters
    ----------
    frequencies : (n,) array
        Hz, ascending, above 0.
    impedance : (n,) complex array
        N s/m, nowhere 0.
    dictionary : Dictionary
        Fewer resonators follow it less closely, and are a smaller system.
    """
    from scipy.optimize import nnls

    omega, ratio = _resonators(dictionary, float(frequencies[0]), float(frequencies[-1]))
    s = 2j * np.pi * np.asarray(frequencies, dtype=float)[:, None]
    below = s**2 + 2.0 * ratio * omega * s + omega**2
    # with b at its least, and at its most
    terms = np.concatenate(
        [s, np.ones_like(s), 1.0 / s, s / below, (s + 2.0 * ratio * omega) / below], axis=1
    )
    relative = terms / np.abs(impedance)[:, None]
    wanted = impedance / np.abs(impedance)
    rows = np.concatenate([relative.real, relative.imag])
    sizes = np.linalg.norm(rows, axis=0)
    found, _ = nnls(
        rows / sizes, np.concatenate([wanted.real, wanted.imag]), maxiter=30 * sizes.size
    )
    mass, damping, stiffness, *rest = found / sizes
    least, most = np.reshape(rest, (2, omega.size))
    used = least + most > 0.0
    return PassiveFit(
        float(mass),
        float(damping),
        float(stiffness),
        omega[used],
        ratio[used],
        (least + most)[used],
        (2.0 * ratio * omega * most)[used],
    )


def _resonators(dictionary: Dictionary, low: float, high: float) -> tuple[Floats, Floats]:
    """Return angular frequency (rad/s) and damping ratio of all resonators."""
    reach = dictionary.reach
    decades = np.log10(high / low * reach**2)
    count = int(np.ceil(dictionary.per_decade * decades)) + 1
    omega = 2.0 * np.pi * np.geomspace(low / reach, high * reach, count)
    grid = np.meshgrid(omega, dictionary.ratios, indexing="ij")
    return grid[0].ravel(), grid[1].ravel()
