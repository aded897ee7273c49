"""Effective section constants of the pieces of the generator (paper eqs 49-55).

Closed form only; the beam finite elements compute theirs by quadrature.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any, TypeAlias

from tactgen.geometry.bimorph.pieces import Layers, Piece
from tactgen.geometry.device.materials import EPS0, lossy_modulus
from tactgen.geometry.device.parameters import Beam, Device

#: A number, or an array of them for many beams at once; complex where there are losses.
Constant: TypeAlias = Any


@dataclass(frozen=True)
class Section:
    """Section constants of a piezoelectric Timoshenko beam, or of many (broadcasting).

    M = EI ψ' − K U,  F = GA (w' + ψ),  charge per length q = K ψ' + C U.

    Attributes
    ----------
    EI : complex
        Bending stiffness (N m²).
    GA : float or complex
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

    EI: Constant
    GA: Constant
    m: Constant
    rhoI: Constant
    K: Constant = 0.0
    C: Constant = 0.0


@dataclass(frozen=True)
class Joint:
    """An elastic connection without length or mass: [F, M] = compliance⁻¹ · jump of [w, ψ].

    Attributes
    ----------
    compliance : (..., 2, 2) array
        Jump of w (m) and ψ (rad) per force (N) and moment (N m) passed upwards.
    """

    compliance: Constant


def section(
    piece: Piece, device: Device, beam: Beam, *, lossy: bool, share: float = 0.5
) -> Section:
    """Return the constants of a beam at a share of its length; `lossy` switches all losses on."""
    layers = piece.layers(device.bimorph, share)
    if piece.section == "bimorph":
        active = _bimorph(layers, device, beam, lossy=lossy)
        return active if piece.electrode else without_electrode(active)
    if piece.section == "shim":
        return _bare_shim(layers, device, beam, lossy=lossy)
    if piece.section == "cylinder":
        return _cylinder(device, piece.radius, lossy=lossy)
    raise ValueError(f"a {piece.section} is no beam; see bond")


def without_electrode(active: Section) -> Section:
    """Return the same layers where the ceramic's faces carry no charge.

    With D₃ through each layer zero (no charge on its faces, none inside, none flowing
    along) bending raises a voltage, K ψ' + C U = 0, that stiffens.  As everywhere in the
    beam models the field is uniform through each layer, so the layer's mean strain is
    stiffened, to 1/(s₁₁ (1 − k₃₁²)), and the strain's variation about it is not.
    """
    return replace(active, EI=active.EI + active.K**2 / active.C, K=0.0, C=0.0)


def _bimorph(layers: Layers, device: Device, beam: Beam, *, lossy: bool) -> Section:
    """Paper eqs 49-55, with h_s/2 in eq 49 and (1 − j tan δ) in eq 55, and a glue layer.

    Between shim and ceramic the glue is one more layer of a plane section: it lifts the
    ceramic by its thickness and adds its own stiffness and mass.  That it also lets the
    layers slide near their ends, over about √(E h_p t_g / G_g), no plane section can show.
    """
    b, hp, hs = layers.width, layers.piezo_thickness, layers.shim_thickness
    tg = device.bimorph.glue_thickness
    piezo, shim, glue = device.piezo, device.shim, device.glue
    stiffening = 1.0 + 1j / piezo.quality_factor if lossy else 1.0
    permittivity = 1.0 - 1j * piezo.loss_tangent if lossy else 1.0
    modulus = stiffening / piezo.s11
    core = hs + 2.0 * tg
    glue_modulus = lossy_modulus(glue.youngs_modulus, glue.loss_factor, lossy=lossy)
    glue_shear = glue_modulus / (2.0 * (1.0 + glue.poisson_ratio))
    shim_modulus, shim_shear = (
        lossy_modulus(modulus, shim.loss_factor, lossy=lossy)
        for modulus in (shim.youngs_modulus, shim.shear_modulus)
    )

    def stacked(of_shim: Constant, of_glue: Constant, of_piezo: Constant) -> Constant:
        """Return ∫ c x² dA of a constant c that each layer has."""
        return b * (
            of_shim * hs**3 / 12.0
            + 2.0 / 3.0 * (of_glue * _cubes(hs, tg) + of_piezo * _cubes(core, hp))
        )

    return Section(
        EI=stacked(shim_modulus, glue_modulus, modulus),
        GA=beam.shear_correction * b * (shim_shear * hs + 2.0 * (glue_shear * tg + hp / piezo.s55)),
        m=b * (shim.density * hs + 2.0 * (glue.density * tg + piezo.density * hp)),
        rhoI=stacked(shim.density, glue.density, piezo.density),
        K=-device.bimorph.poling_sign * b * piezo.d31 * modulus * (core + hp),
        C=2.0 * b * (piezo.eps33 * EPS0 * permittivity - piezo.d31**2 * modulus) / hp,
    )


def _cubes(core: Constant, layer: Constant) -> Constant:
    """Return (core/2 + layer)³ − (core/2)³ without cancellation for thin layers."""
    return layer * (0.75 * core**2 + 1.5 * core * layer + layer**2)


def _bare_shim(layers: Layers, device: Device, beam: Beam, *, lossy: bool) -> Section:
    b, h, shim = layers.width, layers.shim_thickness, device.shim
    loss = lossy_modulus(1.0, shim.loss_factor, lossy=lossy)
    return Section(
        EI=loss * shim.youngs_modulus * b * h**3 / 12.0,
        GA=loss * beam.shear_correction * shim.shear_modulus * b * h,
        m=shim.density * b * h,
        rhoI=shim.density * b * h**3 / 12.0,
    )


def _cylinder(device: Device, radius: float, *, lossy: bool) -> Section:
    """Solid circular section; shear correction 6 (1 + ν) / (7 + 6 ν) (Cowper 1966)."""
    rod = device.rod
    area, inertia = math.pi * radius**2, math.pi * radius**4 / 4.0
    modulus = lossy_modulus(rod.youngs_modulus, rod.loss_factor, lossy=lossy)
    shear_modulus = modulus / (2.0 * (1.0 + rod.poisson_ratio))
    correction = 6.0 * (1.0 + rod.poisson_ratio) / (7.0 + 6.0 * rod.poisson_ratio)
    return Section(
        EI=modulus * inertia,
        GA=correction * shear_modulus * area,
        m=rod.density * area,
        rhoI=rod.density * inertia,
    )
