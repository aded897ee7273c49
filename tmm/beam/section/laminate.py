"""Classical laminate theory of the bimorph as a wide plate: what its width can do at most.

A beam knows nothing of the width; a plate that is free to curve both ways knows all of
Poisson's effect and of d32, but nothing of the free side edges, near which the
transverse stress of each layer dies out within about one thickness.  The real bimorph,
2.7 thicknesses wide, lies between the two.

Per unit width, with curvatures k = (along, across) and the voltage U over each layer,

    M = D k − m U,   q = m·k + C₀ U,

each layer in plane stress (its own s₁₁, s₁₂, d₃₁, d₃₂) and, where the field may vary through
it, with constant electric displacement.  No moment across leaves the constants of a beam.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from tactgen.geometry.arrays import Floats
from tactgen.geometry.bimorph.pieces import Piece
from tactgen.geometry.device.parameters import Beam, Device
from tactgen.geometry.errors import InputError
from tactgen.tmm.beam.section.section import Section, section


def laminate_section(
    device: Device,
    beam: Beam,
    *,
    poisson: bool = True,
    d32: bool = True,
    varying_field: bool = True,
) -> Section:
    """Return the section constants of the plate, no moment across; all else as the beam's.

    Parameters
    ----------
    device : Device
        Without losses.
    beam : Beam
        Shear correction.
    poisson : bool
        Poisson's effect of ceramic and shim.
    d32 : bool
        The piezoelectric effect across the width.
    varying_field : bool
        Let the field vary through each layer.  Without this and the two others the
        constants are those of the beam models.

    Raises
    ------
    InputError
        If there is glue between the layers.
    """
    bimorph, piezo, shim = device.bimorph, device.piezo, device.shim
    if bimorph.glue_thickness > 0.0:
        raise InputError(
            f"bimorph.glue_thickness = {bimorph.glue_thickness:.4g} m is not in laminate theory; "
            "set it to 0 m"
        )
    ceramic = piezo.ceramic()
    s, h, hp = ceramic.s, bimorph.shim_thickness, bimorph.piezo_thickness
    nu = -s[0, 1] / s[0, 0] if poisson else 0.0
    plane = _plane_stress(1.0 / piezo.s11, 1.0 / piezo.s11, nu)
    d = piezo.d31 * np.array([1.0, 1.0 if d32 else 0.0])
    coupling = plane @ d
    clamped = float(ceramic.eps_t[2, 2] - d @ coupling)
    across = shim.transverse_modulus or 2.0 * (1.0 + shim.poisson_ratio) * shim.shear_modulus
    core = _plane_stress(shim.youngs_modulus, across, shim.poisson_ratio if poisson else 0.0)
    layers = 2.0 / 3.0 * ((0.5 * h + hp) ** 3 - (0.5 * h) ** 3)
    stiffness = core * h**3 / 12.0 + plane * layers
    if varying_field:
        stiffness = stiffness + 2.0 * np.outer(coupling, coupling) / clamped * hp**3 / 12.0
    moment = -bimorph.poling_sign * coupling * (h + hp)
    b, follows = bimorph.width, stiffness[0, 1] / stiffness[1, 1]
    return replace(
        section(Piece("bimorph", bimorph.length), device, beam, lossy=False),
        EI=b * float(stiffness[0, 0] - stiffness[0, 1] * follows),
        K=b * float(moment[0] - moment[1] * follows),
        C=b * float(2.0 * clamped / hp + moment[1] ** 2 / stiffness[1, 1]),
    )


def _plane_stress(along: float, across: float, poisson_ratio: float) -> Floats:
    """Return the (2, 2) stiffness (Pa) of an orthotropic sheet; ν is that of a pull along."""
    minor = poisson_ratio * across
    sheet = np.array([[along, minor], [minor, across]])
    return sheet / (1.0 - poisson_ratio**2 * across / along)
