"""The paper's finger and a pad of rubber: lateral loads as laws of frequency."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from tactgen.geometry.arrays import Complex, Floats

#: Range in which the paper fitted the finger's impedance (Hz).
FINGER_RANGE = (10.0, 1000.0)
# Paper table 1.  The table's units of q1..q3 are those of a phase in degrees.
_P = (2.263e-4, 3.401e-1, 57.79, 49.17)
_Q = (8.327e-8, -1.584e-4, 1.036e-1, -38.67)


def finger_impedance(frequencies: Floats) -> Complex:
    """Fitted impedance Z(f) (N s/m), paper eqs 1-3, without any guard."""
    f = np.asarray(frequencies, dtype=float)
    p1, p2, p3, p4 = _P
    amplitude = (p1 * f**2 + p2 * f + p3) / (f + p4)
    phase = np.deg2rad(np.polyval(_Q, f))
    return np.asarray(amplitude * np.exp(1j * phase))


def finger_spring_damper(frequencies: Floats) -> tuple[Floats, Floats]:
    """Stiffness c(f) in N/m and damping d(f) in N s/m, paper eqs 4-5.

    Held constant outside :data:`FINGER_RANGE`.
    """
    f = np.clip(np.asarray(frequencies, dtype=float), *FINGER_RANGE)
    impedance = finger_impedance(f)
    return -2.0 * np.pi * f * impedance.imag, impedance.real


def finger_stiffness(frequencies: Floats) -> Complex:
    """Finger's lateral dynamic stiffness (n,) in N/m: a law of frequency."""
    f = np.asarray(frequencies, dtype=float)
    stiffness, damping = finger_spring_damper(f)
    return np.asarray(stiffness + 2j * np.pi * f * damping)


#: Frequency (Hz) at which the rubber's modulus is stated.
REFERENCE = 100.0


@dataclass(frozen=True)
class SkinPad:
    """A dynamic stiffness over frequency; each number may be an array over the frequencies."""

    shear_modulus: Any  #: Real part of the rubber's shear modulus at :data:`REFERENCE` (Pa)
    loss_factor: Any  #: Imaginary over real part, the same at all frequencies
    #: Of the sheet; of a disc as large as the tip's end face (m)
    thickness: Any
    contact_radius: Any
    weight: Any  #: Mass that rests on the sheet (kg)
    #: What holds sheet and weight sideways besides (N/m, real part at :data:`REFERENCE`): the rest
    #: of the sheet, on the support plate and the other tips
    backing_stiffness: Any

    def __call__(self, frequencies: Floats) -> Complex:
        """Dynamic stiffness (n,) in N/m: sheet and backing in series; 0 at 0 Hz.

        Notes
        -----
        A rigid disc on an incompressible layer on rigid ground, moved sideways, has
        16/3 G R (1 + R/2H) (E. Kausel 1974; for H → ∞ R. D. Mindlin 1949).  A loss factor that
        is the same at all frequencies belongs to a modulus that goes with (jΩ)^α, tan(πα/2) the
        loss factor: causal and passive (a spring-pot).  Inertia of the rubber and waves in it are
        left out: at 1 kHz a shear wave is about twenty times as long as the disc's radius.
        """
        f = np.asarray(frequencies, dtype=float)
        radius, omega = self.contact_radius, 2.0 * np.pi * f
        law = 16.0 / 3.0 * radius * (1.0 + 0.5 * radius / self.thickness)
        power = 2.0 / np.pi * np.arctan(self.loss_factor)
        # (jf/f0)^α with a real part of 1 at f0
        rising = (f / REFERENCE) ** power * (1.0 + 1j * self.loss_factor)
        sheet = law * self.shear_modulus * rising
        backing = self.backing_stiffness * rising - omega**2 * self.weight
        with np.errstate(invalid="ignore"):  # nothing in series with nothing
            found = sheet * backing / (sheet + backing)
        return np.asarray(np.where(f > 0.0, found, 0.0))
