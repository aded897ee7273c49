"""The skin on the tips: a sheet that ties each tip to its neighbours, besides each tip's own load.

A strip one pitch wide between two neighbours is stretched along x, k = E t / (1 − ν²), and sheared
along y, k = G t.  It has no mass and nothing holds it but the tips; what the finger as a whole
answers a tip is that tip's own load.
"""

from __future__ import annotations

import numpy as np

from tactgen.geometry.arrays import Floats
from tactgen.geometry.device.parameters import Display, Skin
from tactgen.tmm.ports.multiport import Multiport
from tactgen.tmm.ports.port import LATERAL, Port


def links(skin: Skin) -> tuple[float, float]:
    """Return the stiffness (N/m) between neighbours along x and along y."""
    plane = skin.youngs_modulus * skin.thickness / (1.0 - skin.poisson_ratio**2)
    shear = 0.5 * skin.youngs_modulus * skin.thickness / (1.0 + skin.poisson_ratio)
    return plane, shear


def sheet(skin: Skin, display: Display, frequencies: Floats, units: tuple[str, ...]) -> Multiport:
    """Return the sheet over the tips' lateral motions, ``w_UNIT``; frequencies (n,) in Hz."""
    along_x, along_y = links(skin)
    count = len(units)
    ties = np.zeros((count, count))
    for i in range(count):
        row, column = divmod(i, display.columns)
        if column + 1 < display.columns:
            _tie(ties, i, i + 1, along_x)
        if row + 1 < display.rows:
            _tie(ties, i, i + display.columns, along_y)
    f = np.asarray(frequencies, dtype=float)
    stiffness = np.broadcast_to(ties * (1.0 + 1j * skin.loss_factor), (f.size, count, count))
    return Multiport(f, stiffness.copy(), tuple(Port(f"w_{unit}", LATERAL) for unit in units))


def _tie(ties: Floats, i: int, j: int, stiffness: float) -> None:
    ties[[i, j], [i, j]] += stiffness
    ties[[i, j], [j, i]] -= stiffness
