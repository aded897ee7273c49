"""Springs and dampers that join others at their ports.

Reciprocal and passive, with a finite D(Ω) at 0 Hz.
"""

from __future__ import annotations

import numpy as np

from tactgen.geometry.arrays import Floats
from tactgen.tmm.ports.multiport import Multiport
from tactgen.tmm.ports.port import Pair, Port


def spring(
    frequencies: Floats,
    pair: Pair,
    *,
    stiffness: float,
    damping: float = 0.0,
    ends: tuple[str, str] = ("low", "high"),
) -> Multiport:
    """Return a spring with a viscous damper between two motions of one kind.

    Parameters
    ----------
    frequencies : (n,) array
        Hz.
    pair : Pair
        LATERAL, AXIAL or ROTATION.
    stiffness, damping : float
        Effort per motion, and per rate of motion: N/m and N s/m, or N m/rad and N m s/rad.
    ends : (str, str)
        Names of the two ports.
    """
    f = np.atleast_1d(np.asarray(frequencies, dtype=float))
    value = stiffness + 2j * np.pi * f * damping
    between = np.array([[1.0, -1.0], [-1.0, 1.0]])
    ports = tuple(Port(name, pair) for name in ends)
    return Multiport(f, value[:, None, None] * between, ports)
