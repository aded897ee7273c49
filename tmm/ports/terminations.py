"""Support and load of the lateral actuator as dynamic stiffnesses (paper sections 3, 4).

The finger is a measured spring and damper (eqs 1-5), fitted between 10 and 1000 Hz.
Outside, its fit turns negative in stiffness (1183 Hz) and then creates energy
(1705 Hz), so both constants are held at the nearer end of the fitted range.
"""

from __future__ import annotations

import numpy as np

from geometry.arrays import Bools, Complex, Floats
from geometry.device.parameters import Load, Support
from tmm.ports.multiport import Termination

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


def outside_finger_range(load: Load, frequencies: Floats) -> Bools:
    """Return which frequencies (n,) the load model does not cover."""
    f = np.asarray(frequencies, dtype=float)
    if load.kind != "finger":
        return np.zeros(f.shape, dtype=bool)
    low, high = FINGER_RANGE
    tolerance = 1e-9 * high
    return np.asarray((f < low - tolerance) | (f > high + tolerance))


def load_stiffness(load: Load, frequencies: Floats) -> Complex:
    """Return the load's lateral dynamic stiffness (n,) in N/m; jΩ times paper eq 11."""
    f = np.asarray(frequencies, dtype=float)
    omega = 2.0 * np.pi * f
    if load.kind == "finger":
        stiffness, damping = finger_spring_damper(f)
        return np.asarray(stiffness + 1j * omega * damping)
    if load.kind == "mass":
        return np.asarray(-(omega**2) * load.mass + 0j)
    if load.kind == "spring_damper":
        return np.asarray(load.stiffness + 1j * omega * load.damping)
    return np.zeros(f.shape, dtype=complex)


def conservative_load(load: Load) -> tuple[float, float]:
    """Return the load's constant stiffness (N/m) and mass (kg), for statics and modes.

    The finger has neither: its stiffness depends on frequency and is known only between
    10 and 1000 Hz, so static values and undamped modes are those of the unloaded tip.
    """
    if load.kind == "mass":
        return 0.0, load.mass
    if load.kind == "spring_damper":
        return load.stiffness, 0.0
    return 0.0, 0.0


def base_stiffness(support: Support, frequencies: Floats) -> tuple[Complex, Complex] | None:
    """Return the support's lateral and rotational dynamic stiffness, None if rigid.

    jΩ times the paper's R41 and R32 (eqs 7, 8).
    """
    if support.kind != "spring":
        return None
    omega = 2.0 * np.pi * np.asarray(frequencies, dtype=float)
    lateral = np.full(omega.shape, support.lateral_stiffness, dtype=complex)
    rotational = (
        support.rotational_stiffness
        + 1j * omega * support.rotational_damping
        - omega**2 * support.rotational_inertia
    )
    return lateral, rotational


def termination(support: Support, load: Load, frequencies: Floats) -> Termination:
    """Return what a scene attaches to the mechanical ports, with all losses."""
    return Termination(
        base=base_stiffness(support, frequencies), tip=load_stiffness(load, frequencies)
    )


def static_termination(support: Support, load: Load) -> Termination:
    """Return the lossless termination at 0 Hz, shape (1,)."""
    stiffness, _ = conservative_load(load)
    return Termination(
        base=base_stiffness(support, np.zeros(1)), tip=np.full(1, stiffness, dtype=complex)
    )
