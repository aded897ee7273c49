"""Section of laminate theory.

A wide plate of layers bends along z, without force or moment across.  It has what a beam's section
leaves out: Poisson's effect, d32, and the field that follows the strain inside each layer.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from tactgen.geometry.arrays import Floats
from tactgen.geometry.bimorph.segments import Piece, StackLayer, bimorph_stack
from tactgen.geometry.device.materials import Piezoceramic
from tactgen.geometry.device.parameters import Beam, Device, Glue, Piezo, Shim
from tactgen.tmm.beam.sections import Section, moduli, section

#: Places of both strains at x = 0, along and across, both curvatures, and the voltage.
_STRAIN, _CURVATURE, _VOLTAGE = slice(0, 2), slice(2, 4), 4


def laminate_section(device: Device, beam: Beam, **simplified: bool) -> Section:
    """Section constants of the plate, no force and no moment across; all else as the beam's.

    Without losses.  Glue counts as one more layer that does not slide; `simplified` is what
    :func:`laminate_energy` leaves out.
    """
    energy, b = laminate_energy(device, **simplified), device.bimorph.width
    # what follows of itself: both strains, and the curvature across
    free, kept = [0, 1, 3], [2, 4]
    follows = np.linalg.solve(energy[np.ix_(free, free)], energy[np.ix_(free, kept)])
    (stiffness, coupling), (_, charge) = (
        energy[np.ix_(kept, kept)] - energy[np.ix_(kept, free)] @ follows
    )
    own = section(Piece("bimorph", device.bimorph.length), device, beam, lossy=False)
    return replace(own, EI=b * stiffness, K=-b * coupling, C=-b * charge)


def laminate_energy(
    device: Device, *, poisson: bool = True, d32: bool = True, varying_field: bool = True
) -> Floats:
    """Quadratic form (5, 5) of strains, curvatures and voltage, per width, of the layers.

    Without Poisson's effect, the piezoelectric effect across the width (d32) and the field's
    variation through each layer the constants are those of the beam models.
    """
    energy = np.zeros((5, 5))
    for layer in bimorph_stack(device):
        _add(energy, layer, poisson=poisson, d32=d32, varying_field=varying_field)
    return energy


def _add(
    energy: Floats, layer: StackLayer, *, poisson: bool, d32: bool, varying_field: bool
) -> None:
    """Add a layer to the quadratic form (5, 5) of strains, curvatures and voltage, per width."""
    of, t, middle = layer.material, layer.thickness, 0.5 * (layer.low + layer.high)
    own = t**3 / 12.0  # second moment about the layer's middle
    ceramic = of.ceramic() if isinstance(of, Piezo) else None
    sheet = layer.share * _sheet(of, ceramic, poisson=poisson)
    _add_sheet(energy, sheet * t, middle, sheet * own)
    if not isinstance(of, Piezo) or ceramic is None:
        return
    d = np.array([of.d31, ceramic.d[2, 1] if d32 else 0.0])
    stress = layer.poling * (sheet @ d)
    clamped = layer.share * ceramic.eps_t[2, 2] - d @ sheet @ d
    # by the field that follows the strain at a constant charge; electrodes hold its mean
    stiffer = np.outer(stress, stress) / clamped
    mean = 0.0 * stiffer if layer.electrodes else stiffer * t
    varies = varying_field and not layer.uniform
    _add_sheet(energy, mean, middle, varies * stiffer * own)
    if layer.electrodes:
        energy[_STRAIN, _VOLTAGE] += layer.hot * stress
        energy[_CURVATURE, _VOLTAGE] += layer.hot * stress * middle
        energy[_VOLTAGE, _STRAIN] = energy[_STRAIN, _VOLTAGE]
        energy[_VOLTAGE, _CURVATURE] = energy[_CURVATURE, _VOLTAGE]
        energy[_VOLTAGE, _VOLTAGE] -= layer.hot**2 * clamped / t


def _add_sheet(energy: Floats, mean: Floats, middle: float, own: Floats) -> None:
    """Add a sheet that resists the strain at its middle, and curvature about that, both (2, 2)."""
    energy[_STRAIN, _STRAIN] += mean
    energy[_STRAIN, _CURVATURE] += mean * middle
    energy[_CURVATURE, _STRAIN] += mean * middle
    energy[_CURVATURE, _CURVATURE] += mean * middle**2 + own


def _sheet(of: Piezo | Shim | Glue, ceramic: Piezoceramic | None, *, poisson: bool) -> Floats:
    """(2, 2) stiffness (Pa) of a material without stress through the thickness."""
    young, _ = moduli(of, lossy=False)
    if isinstance(of, Piezo):
        assert ceramic is not None
        s = ceramic.s
        ratio, nu = s[0, 0] / s[1, 1], -s[0, 1] / s[0, 0]
    elif isinstance(of, Shim):
        nu = of.poisson_ratio
        ratio = of.modulus_across / of.youngs_modulus
    else:
        nu, ratio = of.poisson_ratio, 1.0
    nu = nu if poisson else 0.0
    sheet = np.array([[1.0, nu * ratio], [nu * ratio, ratio]])
    return np.asarray(sheet * young / (1.0 - nu**2 * ratio))


def stretching(device: Device) -> tuple[float, float]:
    """Stretching stiffness (N) of the layers of a beam, and where it lies along x (m)."""
    layers = bimorph_stack(device)
    stiffness = np.array([
        moduli(layer.material, lossy=False)[0] * layer.share * layer.thickness for layer in layers
    ])  # fmt: skip
    middles = np.array([0.5 * (layer.low + layer.high) for layer in layers])
    whole = stiffness.sum()
    return float(device.bimorph.width * whole), float(stiffness @ middles / whole)
