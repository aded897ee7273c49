"""Driven motion of one beam between a support and a load, in closed form, fast.

The dynamic stiffness D has poles where the beam *held* at both ends resonates, which the
mounted beam does not: solving its equations loses digits there.  So the equations are
solved with symbols first.  With the base on κ_w, κ_ψ and the tip on κ_t (dynamic stiffnesses
in EI/l³ and EI/l), Cramer's rule gives tip displacement and ψ_tip − ψ_base as N/P and V/P,

    P = det(D + κ) Δ = Σ κ-products · (minor of D without the held rows) Δ,

and each minor of D times Δ = E O is again entire, a product of the functions of
:mod:`tmm.beam.transfer.span`: free ends β⁴E'O', one end's w held −½(c₁c₂O' + β⁴g S₁S₂E'),
cantilever ¼(c₁²c₂² − β⁴g S₁²S₂² + 2β⁴XY − β⁴E'O − O'E), and so on (g = 1 − ρI Ω²/GA).  The voltage
drives only the even part, hence N.  V is the derivative of P to twice the even part's c₁c₂/E.
There is no pivot and no matrix; what cancels in P and N does so only near the mounted beam's
own resonances and antiresonances.  (The minors are those of the delta-matrix method, Pestel
and Leckie 1963, chapter 7.)

Accuracy.  `condition` is the size of the terms of P, N and the charge over their values; the
relative error of displacement and charge is at most :func:`tmm.beam.transfer.precision.error_bound`
of it.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from geometry.arrays import Bools, Complex, Floats, Numbers
from geometry.bimorph.ends import Law, Springs, TipLoad
from tmm.beam.section.section import Section
from tmm.beam.transfer.blocks import BLOCK, blocks
from tmm.beam.transfer.precision import EPS, EXTENDED, TOLERATED, size
from tmm.beam.transfer.span import Span, extended_span, span
from tmm.ports.terminations import base_stiffness, tip_stiffness


@dataclass(frozen=True)
class TipResponse:
    """Complex peak amplitudes under a drive voltage, all of the inputs' common shape.

    Attributes
    ----------
    w_tip : complex array
        Tip displacement (m).
    charge : complex array
        Charge on the electrodes (C), layers in parallel.
    condition : array
        Condition number of the worse of the two.
    """

    w_tip: Complex
    charge: Complex
    condition: Floats


@dataclass(frozen=True)
class _Mounted:
    """One chunk of points: section, length, Ω, and what holds the ends (SI), (n,) arrays."""

    beam: Section
    length: Complex
    omega: Complex
    base: tuple[Complex, Complex] | None
    tip: Complex


def tip_response(
    beam: Section,
    length: Any,
    omega: Any,
    *,
    base: tuple[Any, Any] | None,
    tip: Any,
    voltage: float = 1.0,
    chunk: int = BLOCK,
) -> TipResponse:
    """Return the response of a uniform beam to a voltage amplitude (V).

    Equal to :func:`tmm.ports.multiport.respond` on the beam's D, but several times faster, right
    also at the poles of D, and in constant memory beside inputs and results.

    Parameters
    ----------
    beam : Section
        Section constants (SI).  They, and all that follows, broadcast against each other.
    length : float or array
        Beam length (m).
    omega : float or array
        Angular frequency (rad/s).
    base : pair of arrays or None
        Lateral (N/m) and rotational (N m/rad) dynamic stiffness of the support; None is a
        rigid clamp.
    tip : complex or array
        Lateral dynamic stiffness of the load (N/m).
    voltage : float
        Amplitude across each layer (V).
    chunk : int
        Points worked on at a time.

    Raises
    ------
    numpy.linalg.LinAlgError
        If nothing holds the beam at 0 Hz.
    """
    ends = (tip,) if base is None else (tip, *base)
    constants = (beam.EI, beam.GA, beam.m, beam.rhoI, beam.K, beam.C)
    inputs = [np.asarray(v) for v in (*constants, length, omega, *ends)]
    shape = np.broadcast_shapes(*(v.shape for v in inputs))
    out = TipResponse(np.empty(shape, complex), np.empty(shape, complex), np.empty(shape))
    results = (out.w_tip, out.charge, out.condition)
    for given, (w_tip, charge, condition) in blocks(inputs, results, chunk):
        section, (l, o, t, *b) = Section(*given[:6]), given[6:]
        mounted = _Mounted(section, l, o, (b[0], b[1]) if b else None, t)
        w_tip[...], charge[...], condition[...] = _respond(mounted)
    out.w_tip[...] *= voltage
    out.charge[...] *= voltage
    return out


def design_map(
    beam: Section,
    lengths: Floats,
    frequencies: Floats,
    base: Springs | None,
    tips: Sequence[TipLoad | Law],
    voltage: float = 1.0,
) -> TipResponse:
    """Return the response (n_load, n_length, n_frequency) over a grid of designs.

    Parameters
    ----------
    beam : Section
        Section constants (SI).
    lengths : (n_length,) array
        m.
    frequencies : (n_frequency,) array
        Hz.
    base : Springs or None
        Of the base; None is a rigid clamp.
    tips : sequence of TipLoad or Law
        Loads at the tip.
    voltage : float
        Amplitude across each layer (V).
    """
    f = np.asarray(frequencies, dtype=float)
    shape = (len(tips), np.size(lengths), f.size)
    out = TipResponse(np.empty(shape, complex), np.empty(shape, complex), np.empty(shape))
    for start in range(0, f.size, 16 * BLOCK):
        block = np.s_[..., start : start + 16 * BLOCK]
        loads = np.stack([tip_stiffness(tip, f[block]) for tip in tips])
        part = tip_response(
            beam,
            np.asarray(lengths)[:, None],
            2.0 * np.pi * f[block],
            base=None if base is None else base_stiffness(base, f[block]),
            tip=loads[:, None, :],
            voltage=voltage,
        )
        out.w_tip[block], out.charge[block] = part.w_tip, part.charge
        out.condition[block] = part.condition
    return out


def _respond(mounted: _Mounted) -> tuple[Complex, Complex, Floats]:
    """Return tip displacement and charge per volt, and the condition number."""
    values, sizes, roundings = span(mounted.beam, mounted.length, mounted.omega, Span)
    w_tip, charge, condition = _quotients(mounted, values, sizes)
    hard = ~(EPS * roundings * condition < TOLERATED)
    if hard.any():
        some = _at(mounted, hard)
        values, sizes, _ = extended_span(some.beam, some.length, some.omega, Span)
        w_tip[hard], charge[hard], condition[hard] = _quotients(_wide(some), values, sizes)
    return w_tip, charge, condition


def _quotients(mounted: _Mounted, values: Span, sizes: Span) -> tuple[Complex, Complex, Floats]:
    beam, l = mounted.beam, mounted.length
    bend = l / beam.EI
    tip = mounted.tip * (bend * l * l)
    base = None
    if mounted.base is not None:
        base = (mounted.base[0] * (bend * l * l), mounted.base[1] * bend)
    p, n, v = _cramer(values, base, tip, -1.0)
    turn = beam.K * beam.K * bend
    q = beam.C * l * p + turn * v
    bounds = _cramer(
        sizes, None if base is None else (size(base[0]), size(base[1])), size(tip), 1.0
    )
    whole = size(beam.C * l) * bounds[0] + size(turn) * bounds[2]
    if (p == 0.0).any():
        raise np.linalg.LinAlgError("nothing holds the beam, or it resonates without losses")
    with np.errstate(divide="ignore", invalid="ignore"):
        condition = bounds[0] / size(p) + np.fmax(bounds[1] / size(n), whole / size(q))
    return n / p * (beam.K * bend * l), q / p, condition


def _cramer(
    s: Span, base: tuple[Numbers, Numbers] | None, tip: Numbers, minus: float
) -> tuple[Any, Any, Any]:
    """Return P, N and V of the docstring; with sizes and `minus` 1, their sizes."""
    cc, ss, x, y = s.cc, s.ss, s.x, s.y
    stiff, inert, cross = s.shear * ss, s.beta4 * ss, s.beta4 * x
    # products that several minors share; `pull` is the tip's 2 D_ww Δ, `turn` its 2 D_ψψ Δ
    free, soft = s.odd_free * s.even, inert * stiff
    pull = cc * s.even + minus * (inert * s.odd)
    turn = cc * s.odd + stiff * s.even
    pinned = cc * cc + minus * (soft + s.beta4 * s.even_free * s.odd + free)
    both = (
        0.25 * pinned + 0.5 * (cross * y) + tip * (0.5 * turn),
        minus * 0.5 * (y * s.even + minus * (cross * s.odd)),
        0.5 * pull + tip * (s.even * s.odd),
    )
    if base is None:
        return both
    lateral, rotational = base
    ends = minus * 0.5 * (cc * s.odd_free + inert * s.shear * s.even_free)
    rigid = minus * (free + soft)
    none = (
        s.beta4 * (s.even_free * s.odd_free) + tip * ends,
        minus * (cross * s.odd_free),
        2.0 * (inert * s.odd_free) + tip * rigid,
    )
    pin = (ends + tip * (cc * stiff), cross * stiff, rigid + tip * (2.0 * (stiff * s.even)))
    slide = (
        0.5 * (inert * s.odd_free + minus * (s.beta4 * cc * s.even_free))
        + tip * (0.25 * pinned + minus * 0.5 * (cross * y)),
        0.5 * (inert * y + cross * cc),
        minus * (inert * cc) + tip * (0.5 * pull),
    )
    held = zip(none, pin, slide, both, strict=True)
    p, n, v = ((n0 + lateral * w) + rotational * (r + lateral * b) for n0, w, r, b in held)
    return p, n, v


def _at(mounted: _Mounted, mask: Bools) -> _Mounted:
    """Return the masked points."""
    return _each(mounted, lambda v: v[mask])


def _wide(mounted: _Mounted) -> _Mounted:
    """Return the same numbers in extended precision."""
    return _each(mounted, lambda v: v.astype(EXTENDED))


def _each(mounted: _Mounted, change: Callable[[Complex], Complex]) -> _Mounted:
    b, base = mounted.beam, mounted.base
    return _Mounted(
        Section(*(change(v) for v in (b.EI, b.GA, b.m, b.rhoI, b.K, b.C))),
        change(mounted.length),
        change(mounted.omega),
        None if base is None else (change(base[0]), change(base[1])),
        change(mounted.tip),
    )
