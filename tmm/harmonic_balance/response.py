"""The steady oscillation that a drive raises from rest."""

from __future__ import annotations

import numpy as np

from tactgen.tmm.harmonic_balance.continuation import follow
from tactgen.tmm.harmonic_balance.newton import NoConvergence
from tactgen.tmm.harmonic_balance.oscillator import Orbit, Oscillator
from tactgen.tmm.harmonic_balance.steady import Resolution, equilibrium, resolved

#: Points of a branch from rest after which the search ends.
_MOST = 300


def steady_orbit(
    oscillator: Oscillator,
    omega: float,
    level: float,
    *,
    guess: Orbit | None = None,
    resolution: Resolution | None = None,
) -> Orbit:
    """Return an orbit at a frequency (rad/s) and a drive.

    That nearest to the guess; without one, that to which the drive leads when it is raised from
    rest, round folds if there are any.  Where several orbits exist it is one of them.

    Raises
    ------
    NoConvergence
        If none is found.
    """
    resolution = resolution or Resolution()
    if guess is not None:
        return resolved(oscillator, Orbit(omega, level, guess.spectrum), resolution)
    rest = Orbit(omega, 0.0, equilibrium(oscillator).spectrum).with_harmonics(resolution.least)
    try:
        return resolved(oscillator, Orbit(omega, level, rest.spectrum), resolution)
    except NoConvergence:
        branch = follow(oscillator, rest, "level", 0.0, level, resolution=resolution, most=_MOST)
    reached = branch.orbits[-1]
    if branch.ended or reached.level < level:
        why = branch.ended or "the branch from rest leads back to rest"
        raise NoConvergence(
            f"at {omega / (2.0 * np.pi):.6g} Hz no orbit was found at a drive of {level:.6g}, "
            f"the highest met being {max(o.level for o in branch.orbits):.6g}: {why}"
        )
    return reached
