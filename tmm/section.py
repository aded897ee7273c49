"""Effective section constants of the pieces of the generator (paper eqs 49-55).

Closed form only; the beam finite elements compute theirs by quadrature.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from geometry.beam_pieces import Piece
from geometry.materials import EPS0
from geometry.parameters import Beam, Device


@dataclass(frozen=True)
class Section:
    """Section constants of a piezoelectric Timoshenko beam.

    M = EI ψ' − K U,  F = GA (w' + ψ),  charge per length q = K ψ' + C U.

    Attributes
    ----------
    EI : complex
        Bending stiffness (N m²).
    GA : float
        Shear stiffness with the correction factor (N).
    m : float
        Mass per length (kg/m).
    rhoI : float
        Rotary inertia per length (kg m).
    K : complex
        Moment per voltage across one layer (N m/V).
    C : complex
        Capacitance per length at zero curvature (F/m).
    """

    EI: complex
    GA: float
    m: float
    rhoI: float
    K: complex = 0.0
    C: complex = 0.0


def section(piece: Piece, device: Device, beam: Beam, *, lossy: bool) -> Section:
    """Return the constants of one piece; `lossy` switches Q and tan δ on."""
    if piece.section == "bimorph":
        return _bimorph(device, beam, lossy=lossy)
    if piece.section == "shim":
        return _bare_shim(device, beam)
    return _cylinder(device, piece.radius)


def _bimorph(device: Device, beam: Beam, *, lossy: bool) -> Section:
    """Paper eqs 49-55, with h_s/2 in eq 49 and (1 − j tan δ) in eq 55."""
    b, hp, hs = (
        device.bimorph.width,
        device.bimorph.piezo_thickness,
        device.bimorph.shim_thickness,
    )
    piezo, shim = device.piezo, device.shim
    stiffening = 1.0 + 1j / piezo.quality_factor if lossy else 1.0
    permittivity = 1.0 - 1j * piezo.loss_tangent if lossy else 1.0
    modulus = stiffening / piezo.s11
    # (h_s/2 + h_p)³ − (h_s/2)³ without cancellation for thin layers
    cubes = hp * (0.75 * hs**2 + 1.5 * hs * hp + hp**2)
    return Section(
        EI=b * (shim.youngs_modulus * hs**3 / 12.0 + 2.0 / 3.0 * modulus * cubes),
        GA=beam.shear_correction * b * (shim.shear_modulus * hs + 2.0 * hp / piezo.s55),
        m=b * (shim.density * hs + 2.0 * piezo.density * hp),
        rhoI=b * (shim.density * hs**3 / 12.0 + 2.0 / 3.0 * piezo.density * cubes),
        K=-device.bimorph.poling_sign * b * piezo.d31 * modulus * (hs + hp),
        C=2.0 * b * (piezo.eps33 * EPS0 * permittivity - piezo.d31**2 * modulus) / hp,
    )


def _bare_shim(device: Device, beam: Beam) -> Section:
    b, h, shim = device.bimorph.width, device.bimorph.shim_thickness, device.shim
    return Section(
        EI=shim.youngs_modulus * b * h**3 / 12.0,
        GA=beam.shear_correction * shim.shear_modulus * b * h,
        m=shim.density * b * h,
        rhoI=shim.density * b * h**3 / 12.0,
    )


def _cylinder(device: Device, radius: float) -> Section:
    """Solid circular section; shear correction 6 (1 + ν) / (7 + 6 ν) (Cowper 1966)."""
    rod = device.rod
    area, inertia = math.pi * radius**2, math.pi * radius**4 / 4.0
    shear_modulus = rod.youngs_modulus / (2.0 * (1.0 + rod.poisson_ratio))
    correction = 6.0 * (1.0 + rod.poisson_ratio) / (7.0 + 6.0 * rod.poisson_ratio)
    return Section(
        EI=rod.youngs_modulus * inertia,
        GA=correction * shear_modulus * area,
        m=rod.density * area,
        rhoI=rod.density * inertia,
    )
