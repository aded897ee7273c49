"""Whether an orbit is stable: its unstable Floquet exponents, counted.

A small deviation e^{st} p(t) of an orbit obeys Hill's infinite determinant, H(s) over the harmonics
of p, with D(nΩ + s/j) on its diagonal.  Divided by that of a stable system without coupling of
harmonics, det H tends to 1 far from the axis, and by the argument principle the turns of
det H(jω) round 0, as ω goes from −Ω/2 to Ω/2, count the exponents in the right half plane (the
Nyquist criterion of periodic systems: Wereley and Hall 1990).  It asks for D at real frequencies
only, so that it serves every model, also with losses that no differential equation has.
"""

from __future__ import annotations

import numpy as np

from tactgen.geometry.arrays import Complex, Floats
from tactgen.tmm.harmonic_balance.balance import LawHarmonics, law_harmonics
from tactgen.tmm.harmonic_balance.oscillator import Orbit, Oscillator

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
