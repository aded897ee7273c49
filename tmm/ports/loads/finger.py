"""The finger that the paper measured: a spring and a damper that depend on frequency (eqs 1-5).

It was fitted between 10 and 1000 Hz.  Outside, its fit turns negative in stiffness (1183 Hz) and
then creates energy (1705 Hz), so both constants are held at the nearer end of the fitted range.
"""

from __future__ import annotations

import numpy as np

from tactgen.geometry.arrays import Complex, Floats

#: Range in which the paper fitted the finger's impedance (Hz).
FINGER_RANGE = (10.0, 1000.0)

# Paper table 1.  The table's units of q1..q3 are those of a phase in degrees.
_P = (2.263e-4, 3.401e-1, 57.79, 49.17)
_Q = (8.327e-8, -1.584e-4, 1.036e-1, -38.67)


def finger_impedance(frequencies: Floats) -> Complex:
    """Return the fitted impedance Z(f) (N s/m), paper eqs 1-3, without any guard."""
    f = np.asarray(frequencies, dtype=float)
    p1, p2, p3, p4 = _P
    amplitude = (p1 * f**2 + p2 * f + p3) / (f + p4)
    phase = np.deg2rad(np.polyval(_Q, f))
    return np.asarray(amplitude * np.exp(1j * phase))


def finger_spring_damper(frequencies: Floats) -> tuple[Floats, Floats]:
    """Return stiffness c(f) in N/m and damping d(f) in N s/m, paper eqs 4-5.

    Held constant outside :data:`FINGER_RANGE`.
    """
    f = np.clip(np.asarray(frequencies, dtype=float), *FINGER_RANGE)
    impedance = finger_impedance(f)
    return -2.0 * np.pi * f * impedance.imag, impedance.real


def finger_stiffness(frequencies: Floats) -> Complex:
    """Return the finger's lateral dynamic stiffness (n,) in N/m: a law of frequency."""
    f = np.asarray(frequencies, dtype=float)
    stiffness, damping = finger_spring_damper(f)
    return np.asarray(stiffness + 2j * np.pi * f * damping)
