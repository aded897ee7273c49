"""Effective section constants of the pieces of the generator (paper eqs 49-55).

Closed form only; the beam finite elements compute theirs by quadrature.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any, TypeAlias

import numpy as np

from tactgen.geometry.bimorph.segments import Piece, StackLayer, stack
from tactgen.geometry.device.materials import EPS0, lossy_coupling, lossy_modulus
from tactgen.geometry.device.parameters import Beam, Device, Glue, Piezo, Shim

#: A number, or an array of them for many beams at once; complex where there are losses.
Constant: TypeAlias = Any


@dataclass(frozen=True)
class Section:
    """Section constants of a piezoelectric Timoshenko beam, or of many (broadcasting).

    M = EI ψ' − K U,  F = GA (w' + ψ),  charge per length q = K ψ' + C U.
    """

    EI: Constant  #: Bending stiffness (N m²)
    GA: Constant  #: Shear stiffness with the correction factor (N)
    m: Constant  #: Mass per length (kg/m)
    rhoI: Constant  #: Rotary inertia per length (kg m)
    K: Constant = 0.0  #: Moment per voltage across one layer (N m/V)
    C: Constant = 0.0  #: Capacitance per length at zero curvature (F/m)


@dataclass(frozen=True)
class Joint:
    """An elastic connection without length or mass: [F, M] = compliance⁻¹ · jump of [w, ψ]."""

    #: (..., 2, 2) Jump of w (m) and ψ (rad) per force (N) and moment (N m) passed upwards
    compliance: Constant


def section(
    piece: Piece, device: Device, beam: Beam, *, lossy: bool, share: float = 0.5
) -> Section:
    """Constants of a beam at a share of its length; `lossy` switches all losses on."""
    if piece.section == "cylinder":
        return _cylinder(device, piece.radius, lossy=lossy)
    if piece.section == "bond":
        raise ValueError("a bond is no beam; see tmm.beam.transfer_matrix.bonded_tab")
    width = piece.layers(device.bimorph, share).width
    return _stacked(stack(piece, device, share), width, beam, lossy=lossy)


def section_across(
    piece: Piece, device: Device, beam: Beam, *, lossy: bool, share: float = 0.5
) -> Section:
    """Constants of a beam that bends across its width, where the voltage moves nothing."""
    width = piece.layers(device.bimorph, share).width
    bending = shearing = mass = inertia = 0.0
    for layer in stack(piece, device, share):
        area, wide = width * layer.thickness * layer.share, width * layer.share
        young, shear = moduli(layer.material, lossy=lossy)
        bending, shearing = bending + young * area * wide**2 / 12.0, shearing + shear * area
        mass = mass + layer.material.density * area
        inertia = inertia + layer.material.density * area * wide**2 / 12.0
    return Section(EI=bending, GA=beam.shear_correction * shearing, m=mass, rhoI=inertia)


def without_electrode(active: Section) -> Section:
    """Section without electrodes: no charge on the ceramic's faces.

    With D₃ through each layer zero (no charge on its faces, none inside, none flowing
    along) bending raises a voltage, K ψ' + C U = 0, that stiffens.  As everywhere in the
    beam models the field is uniform through each layer, so the layer's mean strain is
    stiffened, to 1/(s₁₁ (1 − k₃₁²)), and the strain's variation about it is not.
    """
    return replace(active, EI=active.EI + active.K**2 / active.C, K=0.0, C=0.0)


@dataclass
class _Sums:
    """Integrals over the layers of a section, per width.

    N = A ε + B κ − n U and M = B ε + D κ − m U with the strain ε at x = 0 and κ = ψ'.
    """

    A: Constant = 0.0
    B: Constant = 0.0
    D: Constant = 0.0
    n: Constant = 0.0
    m: Constant = 0.0
    capacitance: Constant = 0.0
    shear: Constant = 0.0
    #: Of the density with x to the power of 0, 1 and 2
    mass: Constant = 0.0
    mass_x: Constant = 0.0
    mass_xx: Constant = 0.0


def _stacked(layers: list[StackLayer], width: Constant, beam: Beam, *, lossy: bool) -> Section:
    """Plane section of layers without axial force; paper eqs 49-55 for piezo, shim, piezo.

    (With h_s/2 in eq 49 and (1 − j tan δ) in eq 55.)  Where the layers do not mirror each other
    ε = (n U − B κ) / A follows the bending, and the section turns about x = B / A.  That glue lets
    layers slide near their ends, over about √(E h_p t_g / G_g), no plane section can show.
    """
    s = _Sums()
    for layer in layers:
        _add(s, layer, lossy=lossy)
    axis = s.B / s.A
    about = np.real(axis)
    return Section(
        EI=width * (s.D - s.B * axis),
        GA=width * beam.shear_correction * s.shear,
        m=width * s.mass,
        rhoI=width * (s.mass_xx - 2.0 * about * s.mass_x + about**2 * s.mass),
        K=width * (s.m - s.n * axis),
        C=width * (s.capacitance + s.n**2 / s.A),
    )


def ceramic_stresses(layers: list[StackLayer]) -> list[tuple[Constant, Constant]]:
    """Axial stress at both faces of each ceramic: per curvature ψ' (Pa m) and per volt (Pa/V).

    With losses, no axial force on the whole.
    """
    s = _Sums()
    for layer in layers:
        _add(s, layer, lossy=True)
    axis, stretch = s.B / s.A, s.n / s.A
    found = []
    for layer in layers:
        if not isinstance(layer.material, Piezo):
            continue
        own = _Sums()  # of this layer alone, its width being the bimorph's
        _add(own, replace(layer, share=1.0), lossy=True)
        young, _ = moduli(layer.material, lossy=True)
        t, middle = layer.thickness, 0.5 * (layer.low + layer.high)
        # of a face without charge the mean strain raises a voltage, which stiffens
        stiffer = own.A / t - young
        for face in (layer.low, layer.high):
            per_curvature = young * (face - axis) + stiffer * (middle - axis)
            found.append((per_curvature, (young + stiffer) * stretch - own.n / t))
    return found


def _add(s: _Sums, layer: StackLayer, *, lossy: bool) -> None:
    """Add one layer; its integrals count as its width beside the bimorph's."""
    t, of, wide = layer.thickness, layer.material, layer.share
    first = 0.5 * t * (layer.low + layer.high)
    # (high³ − low³) / 3 without cancellation
    second = t * (layer.low**2 + layer.low * layer.high + layer.high**2) / 3.0
    young, shear = (wide * modulus for modulus in moduli(of, lossy=lossy))
    density = wide * of.density
    s.A, s.B, s.D = s.A + young * t, s.B + young * first, s.D + young * second
    s.shear = s.shear + shear * t
    s.mass, s.mass_x = s.mass + density * t, s.mass_x + density * first
    s.mass_xx = s.mass_xx + density * second
    if not isinstance(of, Piezo):
        return
    permittivity = 1.0 - 1j * of.loss_tangent if lossy else 1.0
    # of 1 V on the upper face: stress −E d E_x, and charge per strain and per volt
    d31 = lossy_coupling(of.d31, of.coupling_loss, lossy=lossy)
    stress = -layer.poling * d31 * young
    capacitance = (wide * of.eps33 * EPS0 * permittivity - d31**2 * young) / t
    if not layer.electrodes:
        # without charge its mean strain raises a voltage, which stiffens
        mean = first / t
        stiffer = stress**2 / capacitance
        s.A, s.B, s.D = s.A + stiffer, s.B + stiffer * mean, s.D + stiffer * mean**2
        return
    s.n, s.m = s.n + layer.hot * stress, s.m + layer.hot * stress * first / t
    s.capacitance = s.capacitance + layer.hot**2 * capacitance


def moduli(of: Piezo | Shim | Glue, *, lossy: bool) -> tuple[Constant, Constant]:
    """Young's modulus along z, and shear modulus (Pa)."""
    if isinstance(of, Piezo):
        return (1.0 + 1j / of.quality_factor if lossy else 1.0) / of.s11, 1.0 / of.s55
    young = lossy_modulus(of.youngs_modulus, of.loss_factor, lossy=lossy)
    if isinstance(of, Shim):
        return young, lossy_modulus(of.shear_modulus, of.loss_factor, lossy=lossy)
    return young, young / (2.0 * (1.0 + of.poisson_ratio))


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


#: Shares of a segment's length at which its sections are taken.
_GAUSS = (0.5 - math.sqrt(3.0) / 6.0, 0.5 + math.sqrt(3.0) / 6.0)
#: Weights 2 a and 2 b of the nearer and the farther one.
_NEAR, _FAR = 0.5 + math.sqrt(3.0) / 3.0, 0.5 - math.sqrt(3.0) / 3.0
#: Ratio of the two sections' stiffness above which the nearer one is taken as it is: a taper
#: that runs out to nearly nothing, where the farther one's small weight would turn signs.
_STEEPEST = 8.0


def segmented(
    at: Callable[[float], Section], length: float, segments: int
) -> list[tuple[Section, Constant]]:
    """Prismatic beams, two for each segment, with their lengths (m).

    `at` gives the section at a share of the length.
    """
    found = []
    for i in range(segments):
        low, high = (at((i + point) / segments) for point in _GAUSS)
        half = 0.5 * length / segments
        found += [(_mean(low, high), half), (_mean(high, low), half)]
    return found


def _mean(near: Section, far: Section) -> Section:
    """Prismatic section whose A is 2 a A_near + 2 b A_far."""
    ratio = np.abs(near.EI / far.EI)
    if np.any((ratio > _STEEPEST) | (ratio < 1.0 / _STEEPEST)):
        return near

    def mean(first: Constant, second: Constant) -> Constant:
        return _NEAR * first + _FAR * second

    stiffness = 1.0 / mean(1.0 / near.EI, 1.0 / far.EI)
    coupling = mean(near.K / near.EI, far.K / far.EI) * stiffness
    free = mean(near.C + near.K**2 / near.EI, far.C + far.K**2 / far.EI)
    return Section(
        EI=stiffness,
        GA=1.0 / mean(1.0 / near.GA, 1.0 / far.GA),
        m=mean(near.m, far.m),
        rhoI=mean(near.rhoI, far.rhoI),
        K=coupling,
        C=free - coupling**2 / stiffness,
    )
