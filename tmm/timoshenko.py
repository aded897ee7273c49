"""Exact dynamic stiffness of one piezoelectric Timoshenko beam, safe at any frequency.

The textbook transfer matrix grows like cosh λ and divides by jΩ; both cost digits.
Here the beam's motion is split into the part even and the part odd about mid-span,
each solved for displacements.  With p = λ₁², q = λ₂² (paper eq 47, signs corrected)
and z₁ = λ₁/2, z₂ = λ₂/2, both parts need only

    X = (S₂ c₁ − S₁ c₂) / (p + q),      Y = (q S₂ c₁ + p S₁ c₂) / (p + q),
    c₁ = cosh z₁,  c₂ = cos z₂,  S₁ = sinh z₁ / λ₁,  S₂ = sin z₂ / λ₂,

and c₁c₂, S₁S₂.  All four are even entire functions of

    s, t = −(σ + τ)/4 ± (j/2) √(β⁴ − σ τ),

namely X = ¼ g[s, t], Y = ¼ (g(s) + g(t)), S₁S₂ = ½ h[s, t], c₁c₂ = ½ (h(s) + h(t)) with
g(s) = sinh √s / √s, h(s) = cosh √s and [s, t] a divided difference.  Small arguments
take the power series (no division by Ω, exact at 0 Hz), large ones the products above
with the common exponential taken out, which every entry of the result divides away.
"""

from __future__ import annotations

import math

import numpy as np

from geometry.arrays import Complex, Floats
from tmm.section import Section

#: |s| below which the series is used; 9 terms then reach double precision.
_SERIES_RADIUS = 1.0
_SERIES_TERMS = 10


def dynamic_stiffness(beam: Section, length: float, omega: Floats) -> Complex:
    """Return D(Ω) of one beam over the ports [w_0, ψ_0, w_l, ψ_l, U].

    Parameters
    ----------
    beam : Section
        Section constants (SI).
    length : float
        Beam length (m).
    omega : (n,) array
        Angular frequencies (rad/s), 0 included.

    Returns
    -------
    (n, 5, 5) complex array
        Rows: force and moment at the lower end, at the upper end (all acting on the
        beam), charge.  Antisymmetric in the mechanical-electrical block.
    """
    omega = np.asarray(omega, dtype=float)
    l, o2 = length, omega**2
    sigma = beam.m * o2 * l**2 / beam.GA
    tau = beam.rhoI * o2 * l**2 / beam.EI
    beta4 = beam.m * o2 * l**4 / beam.EI
    x, y, cc, ss = _span_functions(sigma + 0j, tau + 0j, beta4 + 0j)
    shear = 1.0 - beam.rhoI * o2 / beam.GA
    inertia = beam.m * o2 * l
    even = y - sigma * x
    odd = l**3 / beam.EI * shear * x + l / beam.GA * y
    even_ff, even_fm, even_mm = (
        -inertia * ss / even,
        -inertia * l * x / even,
        beam.EI / l * cc / even,
    )
    odd_ff, odd_fm, odd_mm = cc / odd, l * y / odd, l**2 * shear * ss / odd

    # one unit of an end displacement is half a unit of the even and half of the odd part
    d = np.zeros((omega.size, 5, 5), dtype=complex)
    d[:, 0, 0] = d[:, 2, 2] = 0.5 * (even_ff + odd_ff)
    d[:, 0, 2] = d[:, 2, 0] = 0.5 * (even_ff - odd_ff)
    d[:, 1, 1] = d[:, 3, 3] = 0.5 * (even_mm + odd_mm)
    d[:, 1, 3] = d[:, 3, 1] = 0.5 * (odd_mm - even_mm)
    d[:, 2, 3] = d[:, 3, 2] = 0.5 * (even_fm + odd_fm)
    d[:, 0, 1] = d[:, 1, 0] = -0.5 * (even_fm + odd_fm)
    d[:, 0, 3] = d[:, 3, 0] = 0.5 * (even_fm - odd_fm)
    d[:, 2, 1] = d[:, 1, 2] = 0.5 * (odd_fm - even_fm)
    d[:, 1, 4], d[:, 3, 4] = beam.K, -beam.K
    d[:, 4, 1], d[:, 4, 3] = -beam.K, beam.K
    d[:, 4, 4] = beam.C * l
    return d


def wavenumbers(beam: Section, length: float, omega: Floats) -> tuple[Floats, Floats]:
    """Return |λ₁| and |λ₂| (n,) of the lossless beam, for choosing how to divide it."""
    o2 = np.asarray(omega, dtype=float) ** 2
    ei = complex(beam.EI).real
    sigma = beam.m * o2 * length**2 / beam.GA
    tau = beam.rhoI * o2 * length**2 / ei
    root = np.sqrt(beam.m * o2 * length**4 / ei + 0.25 * (sigma - tau) ** 2)
    mean = 0.5 * (sigma + tau)
    return np.sqrt(np.abs(root - mean)), np.sqrt(root + mean)


def _span_functions(
    sigma: Complex, tau: Complex, beta4: Complex
) -> tuple[Complex, Complex, Complex, Complex]:
    """Return X, Y, c₁c₂, S₁S₂ (n,), up to a common factor that cancels in the result."""
    root = np.sqrt(beta4 + 0.25 * (sigma - tau) ** 2)
    total = sigma + tau
    small = np.abs(root) + 0.5 * np.abs(total) < 2.0 * _SERIES_RADIUS
    out = np.empty((4, *sigma.shape), dtype=complex)
    for part, mask in ((_by_series, small), (_by_products, ~small)):
        if mask.any():
            out[:, mask] = part(sigma[mask], tau[mask], beta4[mask], root[mask])
    return out[0], out[1], out[2], out[3]


def _by_series(
    sigma: Complex, tau: Complex, beta4: Complex, root: Complex
) -> tuple[Complex, Complex, Complex, Complex]:
    """Power series in the sum and the product of s and t."""
    total, product = -0.5 * (sigma + tau), 0.25 * root**2
    # complete homogeneous polynomials h_n(s, t), and power sums s^n + t^n
    h_before, h_now = np.zeros_like(total), np.ones_like(total)
    p_before, p_now = np.full_like(total, 2.0), total
    x, y = np.zeros_like(total), np.full_like(total, 2.0)
    cc, ss = np.full_like(total, 2.0), np.zeros_like(total)
    for n in range(1, _SERIES_TERMS):
        even, odd = 1.0 / math.factorial(2 * n), 1.0 / math.factorial(2 * n + 1)
        x, ss = x + odd * h_now, ss + even * h_now
        y, cc = y + odd * p_now, cc + even * p_now
        h_before, h_now = h_now, total * h_now - product * h_before
        p_before, p_now = p_now, total * p_now - product * p_before
    return 0.25 * x, 0.25 * y, 0.5 * cc, 0.5 * ss


def _by_products(
    sigma: Complex, tau: Complex, beta4: Complex, root: Complex
) -> tuple[Complex, Complex, Complex, Complex]:
    """Products of the two wave types, each with its growing exponential taken out."""
    q = 0.5 * (sigma + tau) + root
    p = (beta4 - sigma * tau) / q
    z1, z2 = 0.5 * np.sqrt(p), 0.5 * np.sqrt(q)
    c1, s1 = _cosh_and_sinhc(z1 + 0j)
    c2, s2 = _cosh_and_sinhc(1j * z2)
    s1, s2 = 0.5 * s1, 0.5 * s2
    x = (s2 * c1 - s1 * c2) / (p + q)
    y = (q * s2 * c1 + p * s1 * c2) / (p + q)
    return x, y, c1 * c2, s1 * s2


def _cosh_and_sinhc(z: Complex) -> tuple[Complex, Complex]:
    """Return cosh z and sinh z / z, both times exp(−|Re z|)."""
    z = np.where(z.real < 0.0, -z, z)
    # halves of 1 ± exp(−2 Re z), the lower sign without cancellation
    plus, minus = 0.5 * (1.0 + np.exp(-2.0 * z.real)), -0.5 * np.expm1(-2.0 * z.real)
    cos, sin = np.cos(z.imag), np.sin(z.imag)
    cosh, sinh = plus * cos + 1j * minus * sin, minus * cos + 1j * plus * sin
    zero = z == 0.0
    return cosh, np.where(zero, 1.0, sinh / np.where(zero, 1.0, z))
