"""Imitation skin with a weight on it, as the paper's large signals were measured under (Fig 15).

The tip shears a thick rubber sheet above its end face.  The sheet's upper side is held by the
weight's inertia, and by the rest of the sheet, which lies on the other tips and the support plate.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from tactgen.geometry.arrays import Complex, Floats

#: Frequency (Hz) at which the rubber's modulus is stated.
REFERENCE = 100.0


@dataclass(frozen=True)
class SkinPad:
    """A dynamic stiffness over frequency; each number may be an array over the frequencies.

    Attributes
    ----------
    shear_modulus : float
        Real part of the rubber's shear modulus at :data:`REFERENCE` (Pa).
    loss_factor : float
        Imaginary over real part, the same at all frequencies.
    thickness, contact_radius : float
        Of the sheet; of a disc as large as the tip's end face (m).
    weight : float
        Mass that rests on the sheet (kg).
    backing_stiffness : float
        What holds sheet and weight sideways besides (N/m, real part at :data:`REFERENCE`): the
        rest of the sheet, on the support plate and the other tips.
    """

    shear_modulus: Any
    loss_factor: Any
    thickness: Any
    contact_radius: Any
    weight: Any
    backing_stiffness: Any

    def __call__(self, frequencies: Floats) -> Complex:
        """Return the dynamic stiffness (n,) in N/m: sheet and backing in series; 0 at 0 Hz.

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
