"""Exact dynamic stiffness of piezoelectric Timoshenko beams, entry by entry, at any frequency.

Of the functions of :mod:`tmm.beam.span`, the even part has the dynamic stiffness

    1/E [[−β⁴ S₁S₂, −β⁴ X], [−β⁴ X, c₁c₂]],    the odd part    1/O [[c₁c₂, Y], [Y, g S₁S₂]],

g = 1 − ρI Ω²/GA, in units of EI/l³ and l.  One unit of an end's displacement is half a unit
of the even and half of the odd part, so with Δ = E O the held beam's entries are

    D_ww = (c₁c₂ E − β⁴ S₁S₂ O)/2Δ,  D_wψ = −(Y E − β⁴ X O)/2Δ,  D_ψψ = (c₁c₂ O + g S₁S₂ E)/2Δ,

and the transmissions from end to end those of :mod:`tmm.beam.span`, over Δ.

Accuracy.  An entry's condition number is the size of the terms of its numerator, and of E
and O, over their values: some tens away from the entry's poles (E O = 0, natural frequencies
of the lossless beam with both ends held) and zeros, 1/distance in radians of phase near them.
The relative error of every entry is at most :func:`tmm.beam.span.error_bound` of it,
1e-12 up to a condition of 1.8e5 on x86-64; :func:`condition` returns it.  Exactly at a pole of a
lossless beam there is no digit to be had: the entry is infinite.  An entry too small for a double
(transmission through a long lossy beam) is 0.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from tactgen.geometry.arrays import Complex, Floats
from tactgen.tmm.beam.sections import Section
from tactgen.tmm.beam.span import EPS, TOLERATED, ThroughSpan, blocks, extended_span, span

#: Rows, columns and signs of D that each of the six dimensionless entries fills.
_PLACES = (
    ((0, 0, 1.0), (2, 2, 1.0)),
    ((0, 1, 1.0), (2, 3, -1.0)),
    ((1, 1, 1.0), (3, 3, 1.0)),
    ((0, 2, 1.0),),
    ((0, 3, 1.0), (1, 2, -1.0)),
    ((1, 3, 1.0),),
)


def dynamic_stiffness(beam: Section, length: Any, omega: Any) -> Complex:
    """Return D(Ω) over the ports [w_0, ψ_0, w_l, ψ_l, U].

    The section's constants, the length and Ω broadcast against each other.  D is an
    analytic function of all of them: complex values give derivatives along a contour.

    Parameters
    ----------
    beam : Section
        Section constants (SI), numbers or arrays.
    length : float or array
        Beam length (m).
    omega : float or array
        Angular frequency (rad/s), 0 included.

    Returns
    -------
    (..., 5, 5) complex array
        Rows: force and moment at the lower end, at the upper end (all acting on the
        beam), charge.  Antisymmetric in the mechanical-electrical block.
    """
    entries, _ = _evaluated(beam, length, omega)
    stiff = np.asarray(beam.EI) / np.asarray(length)
    arms = (stiff / np.square(length), stiff / length, stiff)
    shape = np.broadcast_shapes(entries.shape[1:], np.shape(beam.K), np.shape(beam.C))
    d = np.zeros((*shape, 5, 5), dtype=complex)
    for at, entry in enumerate(entries):
        value = entry * arms[at % 3]
        for row, column, sign in _PLACES[at]:
            d[..., row, column] = d[..., column, row] = sign * value
    d[..., 1, 4], d[..., 3, 4] = beam.K, np.negative(beam.K)
    d[..., 4, 1], d[..., 4, 3] = np.negative(beam.K), beam.K
    d[..., 4, 4] = np.multiply(beam.C, length)
    return d


def condition(beam: Section, length: Any, omega: Any) -> Floats:
    """Return the condition numbers (..., 5, 5) of D's entries, as the module defines them."""
    _, conditions = _evaluated(beam, length, omega)
    out = np.ones((*conditions.shape[1:], 5, 5))  # 1 for what is exact
    for at, values in enumerate(conditions):
        for row, column, _ in _PLACES[at]:
            out[..., row, column] = out[..., column, row] = values
    return out


def wavenumbers(beam: Section, length: float, omega: Floats) -> tuple[Floats, Floats]:
    """Return |λ₁| and |λ₂| (n,) of the lossless beam, for choosing how to divide it."""
    o2 = np.asarray(omega, dtype=float) ** 2
    ei = np.asarray(beam.EI).real
    sigma = beam.m * o2 * length**2 / beam.GA
    tau = beam.rhoI * o2 * length**2 / ei
    root = np.sqrt(beam.m * o2 * length**4 / ei + 0.25 * (sigma - tau) ** 2)
    mean = 0.5 * (sigma + tau)
    return np.sqrt(np.abs(root - mean)), np.sqrt(root + mean)


def _evaluated(beam: Section, length: Any, omega: Any) -> tuple[Complex, Floats]:
    """Return D_ww, D_wψ, D_ψψ, then w-w, w-ψ, ψ-ψ through the beam, (6, ...), in EI/l³ and l.

    And their condition numbers.
    """
    inputs = (beam.EI, beam.GA, beam.m, beam.rhoI, length, omega)
    shape = np.broadcast_shapes(*(np.shape(v) for v in inputs))
    entries, conditions = np.empty((6, *shape), dtype=complex), np.empty((6, *shape))
    rows = [array[at, ...] for array in (entries, conditions) for at in range(6)]
    for (ei, ga, m, rho_i, l, o), results in blocks(inputs, rows):
        values, sizes, roundings = span(Section(ei, ga, m, rho_i), l, o, ThroughSpan)
        found, worst = _entries(values, sizes)
        hard = ~(EPS * roundings * worst.max(axis=0) < TOLERATED)
        if hard.any():
            some = Section(ei[hard], ga[hard], m[hard], rho_i[hard])
            values, sizes, _ = extended_span(some, l[hard], o[hard], ThroughSpan)
            found[:, hard], worst[:, hard] = _entries(values, sizes)
        for out, result in zip(results, (*found, *worst), strict=True):
            out[...] = result
    return entries, conditions


def _entries(values: ThroughSpan, sizes: ThroughSpan) -> tuple[Complex, Floats]:
    """Return the entries (6, n) and their condition numbers, of one block."""
    numerators, bounds = _numerators(values, -1.0), np.abs(_numerators(sizes, 1.0))
    with np.errstate(divide="ignore", invalid="ignore"):  # exactly at a pole: infinite
        poles = sizes.even / np.abs(values.even) + sizes.odd / np.abs(values.odd)
        conditions = bounds / np.abs(numerators).astype(float) + poles.astype(float)
        entries = numerators / (values.even * values.odd)
    return entries.astype(complex), conditions


def _numerators(s: ThroughSpan, minus: float) -> Any:
    """Return the six numerators over Δ; with sizes and `minus` 1, the sizes (up to sign)."""
    return np.stack(
        [
            0.5 * (s.cc * s.even + minus * (s.beta4 * s.ss * s.odd)),
            -0.5 * (s.y * s.even + minus * (s.beta4 * s.x * s.odd)),
            0.5 * (s.cc * s.odd + s.shear * s.ss * s.even),
            -s.through_force,
            -s.through_mixed,
            s.through_moment,
        ]
    )
