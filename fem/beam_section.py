"""Section constants for the beam elements, integrated over the layers.

By Gauss quadrature of the constitutive law at any place along a piece, not from the closed
forms of the transfer-matrix model.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np

from tactgen.geometry.arrays import Complex, Floats, Numbers
from tactgen.geometry.bimorph.pieces import Piece
from tactgen.geometry.device.materials import EPS0, lossy_modulus
from tactgen.geometry.device.parameters import Beam, Device


def section_constants(
    piece: Piece, device: Device, beam: Beam, share: Floats, *, lossy: bool
) -> Complex:
    """EI, GA, m, rhoI, K, C (6, n) at n shares of a piece's length.

    By integration over the layers.  Where the ceramic has no electrode each layer takes the
    uniform field that leaves it without charge, which adds k²/c to EI.
    """
    if piece.section == "cylinder":
        cylinder = _cylinder_section(piece.radius, device, lossy=lossy)
        return np.repeat(cylinder[:, None], share.size, axis=1)
    out = np.zeros((6, share.size), dtype=complex)
    for layer in _layers(piece, device, share, lossy=lossy):
        part = _layer_integrals(layer, piece.layers(device.bimorph, share).width, beam)
        if not piece.electrode and np.any(layer.field):
            part[0] += part[4] ** 2 / part[5]
            part[4:] = 0.0
        out += part
    return out


@dataclass(frozen=True)
class _Layer:
    """One layer of a section: its faces (n,), constants, and field per volt (n,) along x."""

    low: Floats
    high: Floats
    modulus: complex
    shear: complex
    density: float
    field: Floats
    d31: float = 0.0
    permittivity: complex = 0.0


def _layers(piece: Piece, device: Device, share: Floats, *, lossy: bool) -> list[_Layer]:
    bimorph, piezo, shim, glue = device.bimorph, device.piezo, device.shim, device.glue
    here = piece.layers(bimorph, share)
    none = np.zeros(share.size)
    half, hp = 0.5 * here.shim_thickness + none, here.piezo_thickness + none
    fibre, across = (
        lossy_modulus(modulus, shim.loss_factor, lossy=lossy)
        for modulus in (shim.youngs_modulus, shim.shear_modulus)
    )
    found = [_Layer(-half, half, fibre, across, shim.density, none)]
    if piece.section == "shim":
        return found
    face = half + bimorph.glue_thickness
    if bimorph.glue_thickness:
        modulus = lossy_modulus(glue.youngs_modulus, glue.loss_factor, lossy=lossy)
        bond = modulus, 0.5 * modulus / (1.0 + glue.poisson_ratio)
        found += [
            _Layer(half, face, *bond, glue.density, none),
            _Layer(-face, -half, *bond, glue.density, none),
        ]
    ceramic = (1.0 + 1j / piezo.quality_factor if lossy else 1.0) / piezo.s11
    electric = (
        bimorph.poling_sign * piezo.d31,
        piezo.eps33 * EPS0 * (1.0 - 1j * piezo.loss_tangent if lossy else 1.0),
    )
    # field along x per volt between outer electrode and shim
    return [
        *found,
        _Layer(face, face + hp, ceramic, 1.0 / piezo.s55, piezo.density, -1.0 / hp, *electric),
        _Layer(-face - hp, -face, ceramic, 1.0 / piezo.s55, piezo.density, 1.0 / hp, *electric),
    ]


def _layer_integrals(layer: _Layer, width: Any, beam: Beam) -> Complex:
    """One layer's share of EI, GA, m, rhoI, K, C (6, n)."""
    out = np.zeros((6, layer.low.size), dtype=complex)
    e, d31, field = layer.modulus, layer.d31, layer.field
    for x, weight in gauss(layer.low, layer.high):
        # stress per curvature: E x; per volt: −E d31 field.  D = d31 E x ψ' + eps* field,
        # and the charge on the electrodes is −∫ D field dA
        out += (
            width
            * weight
            * np.stack(
                np.broadcast_arrays(
                    e * x**2,
                    beam.shear_correction * layer.shear,
                    layer.density,
                    layer.density * x**2,
                    e * d31 * field * x,
                    (layer.permittivity - e * d31**2) * field**2,
                )
            )
        )
    return out


def _cylinder_section(radius: float, device: Device, *, lossy: bool) -> Numbers:
    """Integrate a solid disc in strips; Cowper's (1966) shear correction."""
    rod = device.rod
    area = inertia = 0.0
    for angle, weight in gauss(-0.5 * math.pi, 0.5 * math.pi, points=16):
        x, strip = radius * math.sin(angle), 2.0 * (radius * math.cos(angle)) ** 2
        area += weight * strip
        inertia += weight * strip * x**2
    e, rho = lossy_modulus(rod.youngs_modulus, rod.loss_factor, lossy=lossy), rod.density
    shear = e / (2.0 * (1.0 + rod.poisson_ratio))
    shear *= 6.0 * (1.0 + rod.poisson_ratio) / (7.0 + 6.0 * rod.poisson_ratio)
    return np.array([e * inertia, shear * area, rho * area, rho * inertia, 0.0, 0.0])


def gauss(low: Any, high: Any, points: int = 3) -> list[tuple[Any, Any]]:
    """Points and weights between two ends, numbers or arrays."""
    centre, half = 0.5 * (low + high), 0.5 * (high - low)
    return [(centre + half * a, half * b) for a, b in _rule(points)]


@cache
def _rule(points: int) -> list[tuple[float, float]]:
    """Points and weights of Gauss' rule on −1 to 1."""
    x, weights = np.polynomial.legendre.leggauss(points)
    return list(zip(x.tolist(), weights.tolist(), strict=True))
