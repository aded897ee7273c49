"""Timoshenko's shear correction factor of the layered section, by its own shear energy.

Equilibrium along the beam gives the shear stress of a section under a force F (Jourawski),

    τ(x) = F S(x)/EI,   S(x) = ∫ E x' dx'  from x to the outer face,

and the factor makes F²/(2 GA) its strain energy b/2 ∫ τ²/G dx per length.  For one material
it is 5/6; a core much softer in shear than the faces carries nearly all of the force and
nearly all of the energy, and the factor falls far below that.
"""

from __future__ import annotations

from typing import NamedTuple

from tactgen.geometry.device.parameters import Device


class _Layer(NamedTuple):
    """Upper half of the section: from `low` to `high` (m), moduli in Pa."""

    low: float
    high: float
    young: float
    shear: float


def energy_shear_correction(device: Device) -> float:
    """Return the factor by which ``Σ G A`` of the layers is to be multiplied.

    Young's moduli are those of a beam (no transverse stress, short circuit).
    """
    layers = _upper_half(device)
    bending = sum(y.young * (y.high**3 - y.low**3) / 3.0 for y in layers)
    energy = outside = 0.0
    for layer in reversed(layers):
        # S = a − b x² within the layer
        b = 0.5 * layer.young
        a = outside + b * layer.high**2
        powers = (layer.high**n - layer.low**n for n in (1, 3, 5))
        first, third, fifth = powers
        energy += (a**2 * first - 2.0 * a * b * third / 3.0 + b**2 * fifth / 5.0) / layer.shear
        outside = a - b * layer.low**2
    plain = sum(layer.shear * (layer.high - layer.low) for layer in layers)
    return bending**2 / (energy * plain)


def _upper_half(device: Device) -> list[_Layer]:
    bimorph, piezo, shim, glue = device.bimorph, device.piezo, device.shim, device.glue
    half, bond = 0.5 * bimorph.shim_thickness, bimorph.glue_thickness
    layers = [_Layer(0.0, half, shim.youngs_modulus, shim.shear_modulus)]
    if bond > 0.0:
        shear = glue.youngs_modulus / (2.0 * (1.0 + glue.poisson_ratio))
        layers.append(_Layer(half, half + bond, glue.youngs_modulus, shear))
    low = half + bond
    layers.append(_Layer(low, low + bimorph.piezo_thickness, 1.0 / piezo.s11, 1.0 / piezo.s55))
    return layers
