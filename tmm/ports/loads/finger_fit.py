"""The paper's form of a finger's impedance (eqs 1, 2), fitted to a measured table.

|Z| = (p1 f² + p2 f + p3)/(f + p4) and arg Z = q1 f³ + q2 f² + q3 f + q4.  Magnitude and phase are
fitted each by itself, as the paper did, so that nothing makes them belong to one passive load.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tactgen.geometry.arrays import Complex, Floats
from tactgen.geometry.device.load_table import LoadTable

#: How often the weights of the linear problem are taken from its last solution.
_ROUNDS = 30


@dataclass(frozen=True)
class FingerForm:
    """Constants of eqs 1 and 2, as the paper's Table 1 lists them.

    Attributes
    ----------
    p : (4,) array
        p1 (N s²/m), p2 (N s/m), p3 (N/m), p4 (1/s).
    q : (4,) array
        q1 (° s³), q2 (° s²), q3 (° s), q4 (°).
    """

    p: Floats
    q: Floats

    def impedance(self, frequencies: Floats) -> Complex:
        """Return Z (n,) in N s/m."""
        f = np.asarray(frequencies, dtype=float)
        size = np.polyval(self.p[:3], f) / (f + self.p[3])
        return np.asarray(size * np.exp(1j * np.deg2rad(np.polyval(self.q, f))))


def finger_form(table: LoadTable) -> FingerForm:
    """Return the constants with the least squares of ln |Z| and of the phase.

    Multiplied out, eq 1 is linear in its constants; weighted by the last solution's denominator
    that is the problem itself (Sanathanan and Koerner 1963).
    """
    f, size = table.frequencies, np.abs(table.impedance)
    phase = np.rad2deg(np.unwrap(np.angle(table.impedance)))
    # in units of the highest frequency, so that no power outweighs another
    x = f / f[-1]
    rows = np.stack([x**2, x, np.ones_like(x), -size], axis=1)
    weight = 1.0 / size
    found = np.zeros(4)
    for _ in range(_ROUNDS):
        found = np.linalg.lstsq(rows * weight[:, None], size * x * weight, rcond=None)[0]
        below = np.abs(x + found[3])
        weight = 1.0 / (size * np.maximum(below, 1e-9))
    top = f[-1]
    p = np.array([found[0] / top, found[1], found[2] * top, found[3] * top])
    q = np.polyfit(x, phase, 3) / top ** np.arange(3, -1, -1)
    return FingerForm(p, q)
