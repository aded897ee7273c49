"""Classical laminate theory of the bimorph as a wide plate: an outer bound for its width.

A beam knows nothing of the width; a plate that is free to curve both ways knows all of
Poisson's effect and of d32, but nothing of the free side edges, near which the
transverse stress of each layer dies out within about one thickness.  The real bimorph,
2.7 thicknesses wide, lies between the two.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from geometry.parameters import Device


@dataclass(frozen=True)
class LaminateStatics:
    """Static free response per volt: tip displacement (m/V) and capacitance (F)."""

    tip_displacement: float
    capacitance: float


def static_response(device: Device) -> LaminateStatics:
    """Return the response of a clamped laminate without edge effects.

    Curvatures along and across are both free; the field in each layer varies so that the
    electric displacement through it is constant.
    """
    bimorph, piezo, shim = device.bimorph, device.piezo, device.shim
    ceramic = piezo.ceramic()
    nu = -ceramic.s[0, 1] / ceramic.s[0, 0]
    along = 1.0 / (piezo.s11 * (1.0 - nu**2))
    coupling = piezo.d31 * along * (1.0 + nu)  # e31 in plane stress
    clamped = float(ceramic.eps_t[2, 2]) - 2.0 * piezo.d31 * coupling
    h, hp = bimorph.shim_thickness, bimorph.piezo_thickness
    across = shim.transverse_modulus or 2.0 * (1.0 + shim.poisson_ratio) * shim.shear_modulus
    minor = shim.poisson_ratio * across
    in_plane = np.array([[shim.youngs_modulus, minor], [minor, across]])
    in_plane /= 1.0 - shim.poisson_ratio**2 * across / shim.youngs_modulus
    layers = 2.0 / 3.0 * ((0.5 * h + hp) ** 3 - (0.5 * h) ** 3)
    field = 2.0 * coupling**2 / clamped * hp**3 / 12.0  # the field's variation stiffens
    stiffness = in_plane * h**3 / 12.0 + along * np.array([[1.0, nu], [nu, 1.0]]) * layers + field
    moment = -bimorph.poling_sign * coupling * (h + hp) * np.ones(2)
    curvature = np.linalg.solve(stiffness, moment)
    charge = float(moment @ curvature) + 2.0 * clamped / hp
    return LaminateStatics(
        tip_displacement=float(-0.5 * curvature[0] * bimorph.length**2),
        capacitance=charge * bimorph.width * bimorph.length,
    )
