"""Driven motion of one beam between a support and a load, in closed form, fast.

The dynamic stiffness D has poles where the beam *held* at both ends resonates, which the
mounted beam does not: solving its equations loses digits there.  So the equations are
solved with symbols first.  With the base on κ_w, κ_ψ and the tip on κ_t (dynamic stiffnesses
in EI/l³ and EI/l), Cramer's rule gives tip displacement, ψ_tip − ψ_base and ψ_tip as N/P, V/P
and R/P,

    P = det(D + κ) Δ = Σ κ-products · (minor of D without the held rows) Δ,

and each minor of D times Δ = E O is again entire, a product of the functions of
:mod:`tmm.beam.span`: free ends β⁴E'O', one end's w held −½(c₁c₂O' + β⁴g S₁S₂E'),
cantilever ¼(c₁²c₂² − β⁴g S₁²S₂² + 2β⁴XY − β⁴E'O − O'E), and so on (g = 1 − ρI Ω²/GA).  The voltage
drives only the even part, hence N.  V is the derivative of P to twice the even part's c₁c₂/E,
and of its terms R takes those in which the base's rotation is held, and half of the others.
There is no pivot and no matrix; what cancels in P and N does so only near the mounted beam's
own resonances and antiresonances.  (The minors are those of the delta-matrix method, Pestel
and Leckie 1963, chapter 7.)

Accuracy.  The condition number is the size of the terms of P, N, R and the charge over their
values; the bound on the error follows from it as in :mod:`tmm.beam.span`.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, TypeAlias

import numpy as np

from tactgen.geometry.arrays import Complex, Floats, Numbers
from tactgen.geometry.bimorph.boundary_conditions import Ends, TipLoad
from tactgen.tmm.beam.scattering import Element
from tactgen.tmm.beam.sections import Section
from tactgen.tmm.beam.span import BLOCK, EPS, Span, blocks, span
from tactgen.tmm.ports.multiport import Response
from tactgen.tmm.ports.supports_and_loads import base_stiffness, tip_stiffness


@dataclass(frozen=True)
class MountedResponse:
    """Complex peak amplitudes per volt across each layer, all of the inputs' common shape."""

    #: Tip displacement (m/V) and rotation (rad/V)
    w_tip: Complex
    psi_tip: Complex
    charge: Complex  #: Charge on the electrodes (C/V), layers in parallel
    error: Floats  #: Bound on the relative error of all three, by rounding

    @property
    def response(self) -> Response:
        """The same by port names."""
        motion = {"w_tip": self.w_tip, "psi_tip": self.psi_tip}
        return Response(motion, {"voltage": self.charge})


#: Tip displacement, rotation and charge per volt, and the relative error, of one chunk.
_Found: TypeAlias = tuple[Complex, Complex, Complex, Floats]


@dataclass(frozen=True)
class _Mounted:
    """Chunk of points: section, length, Ω and end stiffnesses (SI), (n,) arrays."""

    beam: Section
    length: Complex
    omega: Complex
    base: tuple[Complex, Complex] | None
    tip: Complex


def mounted_response(
    beam: Section,
    length: Any,
    omega: Any,
    *,
    base: tuple[Any, Any] | None,
    tip: Any,
    chunk: int = BLOCK,
) -> MountedResponse:
    """Response of a uniform beam to a voltage of 1 V.

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
    chunk : int
        Points worked on at a time.

    Raises numpy.linalg.LinAlgError if nothing holds the beam at 0 Hz.
    """
    ends = (tip,) if base is None else (tip, *base)
    constants = (beam.EI, beam.GA, beam.m, beam.rhoI, beam.K, beam.C)
    inputs = [np.asarray(v) for v in (*constants, length, omega, *ends)]
    shape = np.broadcast_shapes(*(v.shape for v in inputs))
    w_tip, psi_tip, charge = (np.empty(shape, complex) for _ in range(3))
    out = MountedResponse(w_tip, psi_tip, charge, np.empty(shape))
    results = (out.w_tip, out.psi_tip, out.charge, out.error)
    for given, found in blocks(inputs, results, chunk):
        section, (l, o, t, *b) = Section(*given[:6]), given[6:]
        mounted = _Mounted(section, l, o, (b[0], b[1]) if b else None, t)
        for array, values in zip(found, _respond(mounted), strict=True):
            array[...] = values
    return out


def uniform_response(
    row: Sequence[Element], ends: Ends, frequencies: Floats, *, series: bool
) -> MountedResponse | None:
    """Response (n,) of a row that is one uniform beam, None for any other or a load that turns.

    Frequencies (n,) are in Hz.  In `series` the layers share the volt and carry one charge,
    instead of each having a volt.
    """
    (beam, length), *others = row
    turns = isinstance(ends.tip, TipLoad) and ends.tip.has_size
    if others or not isinstance(beam, Section) or turns:
        return None
    base = None if ends.base is None else base_stiffness(ends.base, frequencies)
    tip, omega = tip_stiffness(ends.tip, frequencies), 2.0 * np.pi * frequencies
    found = mounted_response(beam, length, omega, base=base, tip=tip)
    if not series:
        return found
    return MountedResponse(0.5 * found.w_tip, 0.5 * found.psi_tip, 0.25 * found.charge, found.error)


def _respond(mounted: _Mounted) -> _Found:
    """Tip displacement, rotation and charge per volt, and the relative error."""
    values, sizes, roundings = span(mounted.beam, mounted.length, mounted.omega, Span)
    beam, l = mounted.beam, mounted.length
    bend = l / beam.EI
    tip = mounted.tip * (bend * l * l)
    base = None
    if mounted.base is not None:
        base = (mounted.base[0] * (bend * l * l), mounted.base[1] * bend)
    p, n, v, r = _cramer(values, base, tip, -1.0)
    turn = beam.K * beam.K * bend
    q = beam.C * l * p + turn * v
    bounds = _cramer(
        sizes, None if base is None else (np.abs(base[0]), np.abs(base[1])), np.abs(tip), 1.0
    )
    whole = np.abs(beam.C * l) * bounds[0] + np.abs(turn) * bounds[2]
    if (p == 0.0).any():
        raise np.linalg.LinAlgError("nothing holds the beam, or it resonates without losses")
    with np.errstate(divide="ignore", invalid="ignore"):
        worst = np.fmax(np.fmax(bounds[1] / np.abs(n), whole / np.abs(q)), bounds[3] / np.abs(r))
        error = EPS * roundings * (bounds[0] / np.abs(p) + worst)
    return n / p * (beam.K * bend * l), r / p * (beam.K * bend), q / p, error


def _cramer(
    s: Span, base: tuple[Numbers, Numbers] | None, tip: Numbers, minus: float
) -> tuple[Any, Any, Any, Any]:
    """P, N, V and R of the docstring; with sizes and `minus` 1, their sizes."""
    cc, ss, x, y = s.cc, s.ss, s.x, s.y
    stiff, inert, cross = s.shear * ss, s.beta4 * ss, s.beta4 * x
    # products that several minors share; `pull` is the tip's 2 D_ww Δ, `turn` its 2 D_ψψ Δ
    free, soft, mixed = s.odd_free * s.even, inert * stiff, cross * y
    pull = cc * s.even + minus * (inert * s.odd)
    turn = cc * s.odd + stiff * s.even
    pinned = cc * cc + minus * (soft + s.beta4 * s.even_free * s.odd + free)
    both = (
        0.25 * pinned + 0.5 * mixed + tip * (0.5 * turn),
        minus * 0.5 * (y * s.even + minus * (cross * s.odd)),
        0.5 * pull + tip * (s.even * s.odd),
    )
    if base is None:
        return (*both, both[2])
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
        + tip * (0.25 * pinned + minus * 0.5 * mixed),
        0.5 * (inert * y + cross * cc),
        minus * (inert * cc) + tip * (0.5 * pull),
    )
    turning = [w + lateral * b for w, b in zip(slide, both, strict=True)]
    still = [n0 + lateral * r for n0, r in zip(none, pin, strict=True)]
    p, n, v = (a + rotational * b for a, b in zip(still, turning, strict=True))
    r = 0.5 * (still[2] + (tip + minus * lateral) * mixed) + rotational * turning[2]
    return p, n, v, r
