"""The functions of frequency that a whole span of piezoelectric Timoshenko beam is made of.

The textbook transfer matrix grows like cosh λ and divides by jΩ; both cost digits.
Here the motion is split into the part even and the part odd about mid-span, each solved
for displacements.  With (paper eqs 39-47, misprints corrected)

    σ = m Ω² l²/GA,   τ = ρI Ω² l²/EI,   β⁴ = m Ω² l⁴/EI,
    φ = EI/(GA l²) = σ/β⁴,   ψ = ρI/(m l²) = τ/β⁴,
    r = √(β⁴ + (σ − τ)²/4),   q = λ₂² = r + (σ + τ)/2,   p = λ₁² = β⁴ (1 − ρI Ω²/GA)/q,
    a = q − τ = p + σ,   b = p + τ = q − σ,   a b = β⁴,   a + b = p + q = 2 r,
    q/b = 1 + φ a,   p/a = 1 − φ b,   q/a = 1 + ψ b,   p/b = 1 − ψ a,

z₁ = λ₁/2, z₂ = λ₂/2, c₁ = cosh z₁, c₂ = cos z₂, S₁ = sinh z₁/λ₁, S₂ = sin z₂/λ₂, and
A = S₂ c₁, B = S₁ c₂, everything is a rational function of

    X = (A − B)/(a + b),          Y = (q A + p B)/(a + b),         c₁ c₂,   S₁ S₂,
    E  = Y − σ X          = (b A + a B)/(a + b),              even part, ends held,
    E' = Y − τ X          = (a A + b B)/(a + b),              even part, ends free,
    O  = (1 − ρI Ω²/GA) X + φ Y = (q A/b − p B/a)/(a + b),    odd part, ends held,
    O' = τ Y + β⁴ (1 − ρI Ω²/GA) X = β⁴ (q A/a − p B/b)/(a + b), odd part, ends free.

Held against c₁² − s₁² = c₂² + s₂² = 1, these are functions of the whole span where two
halves would cancel, the transmission from end to end:

    (a S₁c₁ + b S₂c₂)/(a + b) = β⁴ S₁S₂ O + c₁c₂ E,
    (s₁² + s₂²)/(a + b)       = β⁴ X O + Y E,
    (p S₁c₁/a − q S₂c₂/b)/(a + b) = (1 − ρI Ω²/GA) S₁S₂ E − c₁c₂ O.

All are even entire functions of λ₁ and λ₂.  Small arguments take the power series (no
division by Ω, exact at 0 Hz), large ones the products above with exp(|Re z₁| + |Im z₂|)
taken out of every factor; that common factor leaves every ratio.

Precision.  Two errors are left: the phase, ε |λ|, and the cancellation where a function
vanishes.  A result made of these functions has as condition number the size of its terms over
its value, and a relative error of at most ε times this and the roundings in the functions.

Sources: T. C. Huang, J. Appl. Mech. 28 (1961) 579 for the frequency equations (E, E', O, O'
and their products are his); E. C. Pestel and F. A. Leckie, Matrix Methods in
Elastomechanics (1963), chapter 7, for why minors are formed before numbers are put in.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, fields
from functools import cache
from math import factorial
from typing import Any, TypeVar

import numpy as np

from tactgen.geometry.arrays import Bools, Complex, Floats, Numbers
from tactgen.tmm.beam.sections import Section

EPS = float(np.finfo(float).eps)

#: Roundings in a function relative to its size, from the series and, per 1 + |λ|, from the
#: products.  Dynamic stiffness and mounted response at 6e5 random points, held against more
#: digits, had at most 0.83 of the error so estimated.
_SERIES_ROUNDINGS, _PHASE_ROUNDINGS = 4.0, 0.5

S = TypeVar("S", bound="Span")

#: |s| = |z|² below which the series is used, and its terms, which then leave 1e-18.
_SERIES_RADIUS, _SERIES_TERMS = 1.0, 10


@dataclass(frozen=True)
class Span:
    """X, Y, c₁c₂, S₁S₂, E, E', O, O' of the module's docstring, (n,), times one common factor."""

    beta4: Numbers
    shear: Numbers
    x: Numbers
    y: Numbers
    cc: Numbers
    ss: Numbers
    even: Numbers
    even_free: Numbers
    odd: Numbers
    odd_free: Numbers


@dataclass(frozen=True)
class ThroughSpan(Span):
    """With half the transmissions from end to end, times the square of the common factor."""

    through_force: Numbers
    through_mixed: Numbers
    through_moment: Numbers


@dataclass(frozen=True)
class _Waves:
    """σ, τ, β⁴, 1 − ρI Ω²/GA, φ, ψ and r of the docstring, (n,), all in one arithmetic."""

    sigma: Any
    tau: Any
    beta4: Any
    shear: Any
    phi: Any
    psi: Any
    root: Any

    def at(self, mask: Bools) -> _Waves:
        return self if mask.all() else _Waves(*(v[mask] for v in _values(self)))


def span(beam: Section, length: Any, omega: Any, kind: type[S]) -> tuple[S, S, Floats]:
    """Functions in double precision, their sizes, and the roundings in them.

    All are flat over the common shape of the section's constants, the length and Ω.  The
    sizes are those of what each function is a sum of; its rounding error is of the order of
    ε times roundings times its size.
    """
    constants = (beam.EI, beam.GA, beam.m, beam.rhoI, length, omega)
    shape = np.broadcast_shapes(*(np.shape(v) for v in constants))
    w = _waves(*(np.asarray(v) for v in constants))
    return _evaluated(
        _Waves(
            *(np.broadcast_to(v, shape).astype(complex, copy=False).ravel() for v in _values(w))
        ),
        kind,
    )


def _waves(ei: Any, ga: Any, m: Any, rho_i: Any, l: Any, omega: Any) -> _Waves:
    o2, l2 = omega * omega, l * l
    # what does not depend on frequency first: small arrays in a sweep
    sigma, tau, beta4 = (m * l2 / ga) * o2, (rho_i * l2 / ei) * o2, (m * (l2 * l2) / ei) * o2
    lean = 0.5 * (sigma - tau)
    root = np.sqrt(beta4 + lean * lean)
    return _Waves(
        sigma, tau, beta4, 1.0 - (rho_i * o2) / ga, ei / (ga * l2), rho_i / (m * l2), root
    )


def _evaluated(w: _Waves, kind: type[S]) -> tuple[S, S, Floats]:
    small = np.abs(w.root) + 0.5 * np.abs(w.sigma + w.tau) < 2.0 * _SERIES_RADIUS
    if small.all():
        return _by_series(w, kind)
    if not small.any():
        return _by_products(w, kind)
    below, above = _by_series(w.at(small), kind), _by_products(w.at(~small), kind)
    roundings = np.empty(small.size)
    roundings[small], roundings[~small] = below[2], above[2]
    return _merged(small, below[0], above[0]), _merged(small, below[1], above[1]), roundings


def _merged(mask: Bools, inside: S, outside: S) -> S:
    columns = []
    for one, other in zip(_values(inside), _values(outside), strict=True):
        column = np.empty(mask.size, dtype=one.dtype)
        column[mask], column[~mask] = one, other
        columns.append(column)
    return type(inside)(*columns)


def _by_series(w: _Waves, kind: type[S]) -> tuple[S, S, Floats]:
    """Power series of X, Y, c₁c₂ and S₁S₂ in the sum and the product of two squares.

    With s, t = −(σ + τ)/4 ± j r/2, X = ¼ g[s, t], Y = ¼ (g(s) + g(t)), S₁S₂ = ½ h[s, t] and
    c₁c₂ = ½ (h(s) + h(t)), where g(s) = sinh √s/√s, h(s) = cosh √s and [s, t] is a divided
    difference.  The divided differences of s^n are the complete homogeneous polynomials
    H_(n−1)(s, t), and s^n + t^n = 2 H_n − (s + t) H_(n−1).
    """
    sigma, tau, beta4, shear, phi, _, root = _values(w)
    total, product = -0.5 * (sigma + tau), 0.25 * root * root
    factors = _series_factors()
    powers = np.empty((factors.shape[1], total.size), dtype=complex)
    powers[0], powers[1] = 1.0, total
    for n in range(2, len(powers)):
        powers[n] = total * powers[n - 1] - product * powers[n - 2]
    # real factors: real and imaginary parts are columns of their own
    x, y, cc, ss = (factors @ powers.view(float)).view(complex)
    y, cc = y - total * x, cc - total * ss
    values = (beta4, shear, x, y, cc, ss)
    return (
        _summed(values, (sigma, tau, phi), kind, -1.0),
        _summed([*map(np.abs, values)], [*map(np.abs, (sigma, tau, phi))], kind, 1.0),
        np.full(total.size, _SERIES_ROUNDINGS),
    )


@cache
def _series_factors() -> Floats:
    """Factors of H_0, H_1, … in ¼ g[s,t], ½ Σ g_n H_n, Σ h_n H_n, ½ h[s,t]."""
    even = [1.0 / factorial(2 * n) for n in range(_SERIES_TERMS)]
    odd = [value / (2 * n + 1) for n, value in enumerate(even)]
    rows = ([*odd[1:], 0.0], odd, even, [*even[1:], 0.0])
    return np.asarray(np.array(rows) * np.array(([0.25], [0.5], [1.0], [0.5])))


def _summed(first: Sequence[Any], rates: Sequence[Any], kind: type[S], minus: float) -> S:
    """Docstring's functions from X, Y, c₁c₂, S₁S₂; with sizes and `minus` 1, sizes."""
    (beta4, shear, x, y, cc, ss), (sigma, tau, phi) = first, rates
    even, even_free = y + minus * (sigma * x), y + minus * (tau * x)
    odd, odd_free = shear * x + phi * y, tau * y + beta4 * shear * x
    parts = [*first, even, even_free, odd, odd_free]
    if issubclass(kind, ThroughSpan):
        parts += [
            0.5 * (beta4 * ss * odd + cc * even),
            0.5 * (beta4 * x * odd + y * even),
            0.5 * (shear * ss * even + minus * (cc * odd)),
        ]
    return kind(*parts)


def _by_products(w: _Waves, kind: type[S]) -> tuple[S, S, Floats]:
    """Products of the two wave types, each with its growing exponential taken out."""
    leans = (w.sigma - w.tau).real >= 0.0
    # of a = r + (σ − τ)/2 and b = r − (σ − τ)/2 the larger by sum, the smaller by a b = β⁴
    large = w.root + (w.sigma - w.tau) * np.where(leans, 0.5, -0.5)
    small = w.beta4 / large
    q = 0.5 * (w.sigma + w.tau) + w.root
    p = w.beta4 * w.shear / q
    z1, z2 = 0.5 * np.sqrt(p), 0.5j * np.sqrt(q)
    (c1, s1, decay1), (c2, s2, decay2) = _hyperbolic(z1), _hyperbolic(z2)
    a, b = np.where(leans, large, small), np.where(leans, small, large)
    # q/b and q/a by sums, whose second term is small for slender beams; so p/a and p/b
    rates = _Rates(
        w.beta4, w.shear, p, q, a, b, 1.0 + w.phi * a, _less(w.phi * b, p, a),
        1.0 + w.psi * b, _less(w.psi * a, p, b), 1.0 / (p + q),
    )  # fmt: skip
    # S₁ and S₂; z₂ stands for j λ₂/2, so its sinh z/z is sin z/z, its sinh² z is −sin² z
    first, second = 0.5 * _over(s1, z1), 0.5 * _over(s2, z2)
    values = _combined(
        rates, c1, c2, first, second, (s1 * s1, -s2 * s2), (decay1, decay2), kind, -1.0
    )
    reach1, reach2 = 2.0 * np.abs(z1), 2.0 * np.abs(z2)
    one = np.ones_like(reach1)
    sizes = _combined(
        _Rates(*map(np.abs, _values(rates))),
        one, one, 1.0 / (1.0 + reach1), 1.0 / (1.0 + reach2), (one, one),
        (decay1, decay2), kind, 1.0,
    )  # fmt: skip
    # at the cut-off λ₁ is the root of a small difference
    phase1 = np.abs(w.beta4 / q) * np.maximum(np.abs(w.shear), 1.0) / np.maximum(reach1, 1.0)
    return values, sizes, _PHASE_ROUNDINGS * (1.0 + phase1 + reach2)


@dataclass(frozen=True)
class _Rates:
    """β⁴, 1 − ρI Ω²/GA, p, q, a, b, q/b, p/a, q/a, p/b, 1/(a + b): values or sizes."""

    beta4: Numbers
    shear: Numbers
    p: Numbers
    q: Numbers
    a: Numbers
    b: Numbers
    q_b: Numbers
    p_a: Numbers
    q_a: Numbers
    p_b: Numbers
    over: Numbers


def _less(part: Complex, p: Complex, other: Complex) -> Complex:
    """1 − `part`, which is p/`other`: by the quotient where the difference cancels."""
    difference = 1.0 - part
    late = np.abs(part.real) > 0.5
    if late.any():
        difference[late] = p[late] / other[late]
    return difference


def _combined(
    k: _Rates,
    c1: Numbers,
    c2: Numbers,
    first: Numbers,
    second: Numbers,
    squares: tuple[Numbers, Numbers],
    decays: tuple[Floats, Floats],
    kind: type[S],
    minus: float,
) -> S:
    """Docstring's functions of c₁, c₂, S₁, S₂; with sizes and `minus` 1, sizes."""
    one, other = second * c1, first * c2  # A and B
    parts = [
        k.beta4,
        k.shear,
        (one + minus * other) * k.over,
        (k.q * one + k.p * other) * k.over,
        c1 * c2,
        first * second,
        (k.b * one + k.a * other) * k.over,
        (k.a * one + k.b * other) * k.over,
        (k.q_b * one + minus * (k.p_a * other)) * k.over,
        (k.q_a * one + minus * (k.p_b * other)) * (k.beta4 * k.over),
    ]
    if issubclass(kind, ThroughSpan):
        over = 0.5 * k.over
        near, far = first * c1 * decays[1], second * c2 * decays[0]
        parts += [
            (k.a * near + k.b * far) * over,
            (squares[1] * decays[0] + squares[0] * decays[1]) * over,
            (k.p_a * near + minus * (k.q_b * far)) * over,
        ]
    return kind(*parts)


def _hyperbolic(z: Complex) -> tuple[Complex, Complex, Floats]:
    """Cosh z and sinh z, both times exp(−|Re z|), then exp(−2 |Re z|)."""
    sign = np.copysign(1.0, z.real)
    x, angle = np.abs(z.real), sign * z.imag
    decay = np.exp(-2.0 * x)
    # halves of 1 ± exp(−2 |Re z|), the lower sign without cancellation
    plus, minus = 0.5 * (1.0 + decay), -0.5 * np.expm1(-2.0 * x)
    cos, sin = np.cos(angle), np.sin(angle)
    cosh, sinh = np.empty_like(z), np.empty_like(z)
    cosh.real, cosh.imag = plus * cos, minus * sin
    sinh.real, sinh.imag = sign * minus * cos, sign * plus * sin
    return cosh, sinh, decay


def _over(sinh: Complex, z: Complex) -> Complex:
    """Sinh z/z, 1 where z is 0 (there the exponential taken out of sinh is 1)."""
    zero = z == 0.0
    return np.where(zero, 1.0, sinh / np.where(zero, 1.0, z)) if zero.any() else sinh / z


def _values(record: Any) -> list[Any]:
    return [getattr(record, field.name) for field in fields(record)]


#: Points in a block: the intermediate arrays then stay in a core's second-level cache.
BLOCK = 4096


def blocks(
    inputs: Sequence[Any], outputs: Sequence[Numbers], size: int = BLOCK
) -> Iterator[tuple[list[Complex], list[Numbers]]]:
    """Yield matching flat pieces of `size` points of all arrays: inputs to read, outputs to fill.

    The inputs are broadcast to their common shape, which the outputs have, and made complex.
    """
    # Freeing one large array raises the GNU allocator's thresholds (mallopt(3), M_MMAP_THRESHOLD);
    # without it every temporary is given back and faulted in anew, which halves the speed.
    np.empty(1 << 20)
    uses: Any = [["readonly"]] * len(inputs) + [["writeonly"]] * len(outputs)
    types: Any = [complex] * len(inputs) + [out.dtype for out in outputs]
    pieces = np.nditer(
        [*(np.asarray(v) for v in inputs), *outputs],
        flags=["external_loop", "buffered", "zerosize_ok"],
        op_flags=uses,
        op_dtypes=types,
        order="C",
        buffersize=size,
    )
    with pieces:
        for piece in pieces:
            yield list(piece[: len(inputs)]), list(piece[len(inputs) :])


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
    """D(Ω) over the ports [w_0, ψ_0, w_l, ψ_l, U].

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
    entries, _ = _span_matrices(beam, length, omega)
    stiff = np.asarray(beam.EI) / np.asarray(length)
    arms = (stiff / np.square(length), stiff / length, stiff)
    shape = np.broadcast_shapes(entries.shape[1:], np.shape(beam.K), np.shape(beam.C))
    d = np.zeros((*shape, 5, 5), dtype=complex)
    for at, entry in enumerate(entries):
        with np.errstate(invalid="ignore"):  # exactly at a pole: infinite
            value = entry * arms[at % 3]
        for row, column, sign in _PLACES[at]:
            d[..., row, column] = d[..., column, row] = sign * value
    d[..., 1, 4], d[..., 3, 4] = beam.K, np.negative(beam.K)
    d[..., 4, 1], d[..., 4, 3] = np.negative(beam.K), beam.K
    d[..., 4, 4] = np.multiply(beam.C, length)
    return d


def rounding(beam: Section, length: Any, omega: Any) -> Floats:
    """Bounds (..., 5, 5) on the relative rounding of D's entries."""
    _, bounds = _span_matrices(beam, length, omega)
    out = np.full((*bounds.shape[1:], 5, 5), 2.0 * EPS)  # of a product of constants
    for at, values in enumerate(bounds):
        for row, column, _ in _PLACES[at]:
            out[..., row, column] = out[..., column, row] = values
    return out


def wavenumbers(beam: Section, length: float, omega: Floats) -> tuple[Floats, Floats]:
    """|λ₁| and |λ₂| (n,) of the lossless beam, for choosing how to divide it."""
    o2 = np.asarray(omega, dtype=float) ** 2
    ei, ga = np.asarray(beam.EI).real, np.asarray(beam.GA).real
    sigma = beam.m * o2 * length**2 / ga
    tau = beam.rhoI * o2 * length**2 / ei
    root = np.sqrt(beam.m * o2 * length**4 / ei + 0.25 * (sigma - tau) ** 2)
    mean = 0.5 * (sigma + tau)
    return np.sqrt(np.abs(root - mean)), np.sqrt(root + mean)


def _span_matrices(beam: Section, length: Any, omega: Any) -> tuple[Complex, Floats]:
    """D_ww, D_wψ, D_ψψ, then w-w, w-ψ, ψ-ψ through the beam, (6, ...), in EI/l³ and l.

    And bounds on their relative rounding.
    """
    inputs = (beam.EI, beam.GA, beam.m, beam.rhoI, length, omega)
    shape = np.broadcast_shapes(*(np.shape(v) for v in inputs))
    entries, bounds = np.empty((6, *shape), dtype=complex), np.empty((6, *shape))
    rows = [array[at, ...] for array in (entries, bounds) for at in range(6)]
    for (ei, ga, m, rho_i, l, o), results in blocks(inputs, rows):
        values, sizes, roundings = span(Section(ei, ga, m, rho_i), l, o, ThroughSpan)
        found, conditions = _entries(values, sizes)
        for out, result in zip(results, (*found, *(EPS * roundings * conditions)), strict=True):
            out[...] = result
    return entries, bounds


def _entries(values: ThroughSpan, sizes: ThroughSpan) -> tuple[Complex, Floats]:
    """Entries (6, n) and their condition numbers, of one block."""
    numerators, bounds = _numerators(values, -1.0), np.abs(_numerators(sizes, 1.0))
    with np.errstate(divide="ignore", invalid="ignore"):  # exactly at a pole: infinite
        poles = sizes.even / np.abs(values.even) + sizes.odd / np.abs(values.odd)
        conditions = bounds / np.abs(numerators) + poles
        entries = numerators / (values.even * values.odd)
    return entries, conditions


def _numerators(s: ThroughSpan, minus: float) -> Any:
    """Six numerators over Δ; with sizes and `minus` 1, the sizes (up to sign)."""
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
