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
vanishes.  In extended precision σ … λ₂ are worked out in double-double numbers, so that
phases and the distance from the cut-off ρI Ω² = GA are exact, and the functions in the
machine's long double (64 bits on x86-64, 113 on most others; where it is a plain double
only the phases gain).  A result made of these functions has as condition number the size of
its terms over its value.  It is kept in double precision while its error there is below
`TOLERATED`, and worked out in extended precision otherwise; what is promised then is
:func:`tmm.beam.span.error_bound`.

Sources: T. C. Huang, J. Appl. Mech. 28 (1961) 579 for the frequency equations (E, E', O, O'
and their products are his); E. C. Pestel and F. A. Leckie, Matrix Methods in
Elastomechanics (1963), chapter 7, for why minors are formed before numbers are put in.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, fields
from functools import cache
from typing import Any, TypeAlias, TypeVar

import numpy as np

from tactgen.geometry.arrays import Bools, Complex, Floats, Numbers
from tactgen.tmm.beam.sections import Section

#: 2^27 + 1 cuts a double's 53 bits in two halves whose products are exact.
_SPLITTER = 134217729.0


class DoubleDouble:
    """hi + lo, each a complex array of one shape, |lo| at most half a last digit of hi."""

    __array_ufunc__ = None  # array * DoubleDouble is ours to do, not numpy's, element by element

    def __init__(self, hi: Complex, lo: Complex | None = None) -> None:
        self.hi = np.asarray(hi, dtype=complex)
        self.lo = np.zeros_like(self.hi) if lo is None else lo

    def __getitem__(self, mask: Bools) -> DoubleDouble:
        return DoubleDouble(self.hi[mask], self.lo[mask])

    def __add__(self, other: Operand) -> DoubleDouble:
        other = _as_pair(other)
        hi, lo = _sum(self.hi, other.hi)
        return _tidy(hi, lo + (self.lo + other.lo))

    def __neg__(self) -> DoubleDouble:
        return DoubleDouble(-self.hi, -self.lo)

    def __sub__(self, other: Operand) -> DoubleDouble:
        return self + -_as_pair(other)

    def __rsub__(self, other: Operand) -> DoubleDouble:
        return _as_pair(other) - self

    def __mul__(self, other: Operand) -> DoubleDouble:
        other = _as_pair(other)
        hi, lo = _product(self.hi, other.hi)
        return _tidy(hi, lo + (self.hi * other.lo + self.lo * other.hi))

    __radd__, __rmul__ = __add__, __mul__

    def __truediv__(self, other: Operand) -> DoubleDouble:
        other = _as_pair(other)
        first = self.hi / other.hi
        rest = self - other * first
        return _tidy(first, rest.hi / other.hi)

    def sqrt(self) -> DoubleDouble:
        """Root with the branch that numpy's has; one Newton step doubles it."""
        root = np.sqrt(self.hi)
        rest = self - DoubleDouble(root) * root
        return _tidy(root, rest.hi / np.where(root == 0.0, 1.0, 2.0 * root))


#: What a DoubleDouble can be combined with.
Operand: TypeAlias = "DoubleDouble | Complex | Floats | complex"


def _as_pair(value: Operand) -> DoubleDouble:
    if isinstance(value, DoubleDouble):
        return value
    return DoubleDouble(np.asarray(value, dtype=complex))


def _tidy(hi: Complex, lo: Complex) -> DoubleDouble:
    total = hi + lo
    return DoubleDouble(total, lo - (total - hi))


def _sum(a: Any, b: Any) -> tuple[Any, Any]:
    """+ b and its rounding error; exact part by part."""
    total = a + b
    back = total - a
    return total, (a - (total - back)) + (b - back)


def _product(a: Complex, b: Complex) -> tuple[Complex, Complex]:
    """B and its rounding error."""
    rr, rr_low = _real_product(a.real, b.real)
    ii, ii_low = _real_product(a.imag, b.imag)
    ri, ri_low = _real_product(a.real, b.imag)
    ir, ir_low = _real_product(a.imag, b.real)
    re, re_low = _sum(rr, -ii)
    im, im_low = _sum(ri, ir)
    return re + 1j * im, (re_low + (rr_low - ii_low)) + 1j * (im_low + (ri_low + ir_low))


def _real_product(a: Floats, b: Floats) -> tuple[Floats, Floats]:
    total = a * b
    a_high, a_low = _halves(a)
    b_high, b_low = _halves(b)
    error = ((a_high * b_high - total) + a_high * b_low + a_low * b_high) + a_low * b_low
    return total, error


def _halves(a: Floats) -> tuple[Floats, Floats]:
    wide = _SPLITTER * a
    high = wide - (wide - a)
    return high, a - high


#: Working precision of the extended evaluation, and its rounding unit.
EXTENDED = np.clongdouble
EXTENDED_EPS = float(np.finfo(np.longdouble).eps)
EPS = float(np.finfo(float).eps)

#: Relative error of a result that double precision may cost.
TOLERATED = 7e-13
#: Extended roundings in a result, per unit of its condition number: its sums have up to
#: fifteen terms of several factors each.  On the way into nine resonances at most 26 were found.
EXTENDED_ROUNDINGS = 50.0


def error_bound(condition: Floats | float) -> Floats:
    """Relative error that results of these condition numbers may have."""
    extended = 2.0 * EPS + EXTENDED_ROUNDINGS * EXTENDED_EPS * np.asarray(condition)
    return np.maximum(TOLERATED, extended)


def sqrt(v: Any) -> Any:
    """Root of an array or a double-double number."""
    return v.sqrt() if isinstance(v, DoubleDouble) else np.sqrt(v)


def head(v: Any) -> Complex:
    """Number as doubles, for comparisons."""
    return v.hi if isinstance(v, DoubleDouble) else v


def rounded(v: Any) -> Complex:
    """Number in the working precision."""
    return v.hi.astype(EXTENDED) + v.lo if isinstance(v, DoubleDouble) else v


def phase(v: Any) -> tuple[Complex, Complex | None]:
    """Number as a double and the rest, both in the working precision."""
    if isinstance(v, DoubleDouble):
        return v.hi.astype(EXTENDED), v.lo.astype(EXTENDED)
    return v, None


def size(v: Any) -> Floats:
    """Magnitude as doubles."""
    return np.asarray(np.abs(v).astype(float, copy=False))


#: Roundings in a function relative to its size, from the series and, per 1 + |λ|, from the
#: products.  The results of :mod:`tmm.beam.span` and :mod:`tmm.beam.mounted_beam`
#: at 6e5 random points, held against extended precision, had at most 0.83 of the error so
#: estimated.
_SERIES_ROUNDINGS, _PHASE_ROUNDINGS = 4.0, 0.5

S = TypeVar("S", bound="Span")

#: |s| = |z|² below which the series is used.
_SERIES_RADIUS = 1.0


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


def extended_span(
    beam: Section, length: Complex, omega: Complex, kind: type[S]
) -> tuple[S, S, Floats]:
    """Span in extended precision; all constants are (n,) arrays like Ω.

    Rounding errors are here of the order of `EXTENDED_EPS` times the sizes, whatever |λ|, and
    the roundings returned have no meaning.
    """
    constants = (beam.EI, beam.GA, beam.m, beam.rhoI, length, omega)
    return _evaluated(_waves(*(DoubleDouble(v) for v in constants)), kind)


def _waves(ei: Any, ga: Any, m: Any, rho_i: Any, l: Any, omega: Any) -> _Waves:
    o2, l2 = omega * omega, l * l
    # what does not depend on frequency first: small arrays in a sweep
    sigma, tau, beta4 = (m * l2 / ga) * o2, (rho_i * l2 / ei) * o2, (m * (l2 * l2) / ei) * o2
    lean = 0.5 * (sigma - tau)
    root = sqrt(beta4 + lean * lean)
    return _Waves(
        sigma, tau, beta4, 1.0 - (rho_i * o2) / ga, ei / (ga * l2), rho_i / (m * l2), root
    )


def _evaluated(w: _Waves, kind: type[S]) -> tuple[S, S, Floats]:
    small = np.abs(head(w.root)) + 0.5 * np.abs(head(w.sigma + w.tau)) < 2.0 * _SERIES_RADIUS
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
    sigma, tau, beta4, shear, phi, _, root = (rounded(v) for v in _values(w))
    total, product = -0.5 * (sigma + tau), 0.25 * root * root
    real = total.real.dtype
    factors = _series_factors(real)
    powers = np.empty((factors.shape[1], total.size), dtype=total.dtype)
    powers[0], powers[1] = 1.0, total
    for n in range(2, len(powers)):
        powers[n] = total * powers[n - 1] - product * powers[n - 2]
    # real factors: real and imaginary parts are columns of their own
    x, y, cc, ss = (factors @ powers.view(real)).view(total.dtype)
    y, cc = y - total * x, cc - total * ss
    values = (beta4, shear, x, y, cc, ss)
    return (
        _summed(values, (sigma, tau, phi), kind, -1.0),
        _summed([size(v) for v in values], [size(v) for v in (sigma, tau, phi)], kind, 1.0),
        np.full(total.size, _SERIES_ROUNDINGS),
    )


@cache
def _series_factors(real: np.dtype[Any]) -> Floats:
    """Factors of H_0, H_1, … in ¼ g[s,t], ½ Σ g_n H_n, Σ h_n H_n, ½ h[s,t]."""
    terms = 10 if real == np.float64 else 17
    even = [real.type(1)]  # 1/(2n)!, in the working precision
    for n in range(1, terms):
        even.append(even[-1] / ((2 * n - 1) * (2 * n)))
    odd = [value / (2 * n + 1) for n, value in enumerate(even)]
    zero = real.type(0)
    rows = ([*odd[1:], zero], odd, even, [*even[1:], zero])
    scales = ([0.25], [0.5], [1.0], [0.5])
    return np.asarray(np.array(rows, dtype=real) * np.array(scales, dtype=real))


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
    leans = head(w.sigma - w.tau).real >= 0.0
    # of a = r + (σ − τ)/2 and b = r − (σ − τ)/2 the larger by sum, the smaller by a b = β⁴
    large = w.root + (w.sigma - w.tau) * np.where(leans, 0.5, -0.5)
    small = w.beta4 / large
    wide_q = 0.5 * (w.sigma + w.tau) + w.root
    wide_p = w.beta4 * w.shear / wide_q
    c1, s1, z1, decay1 = _hyperbolic(*phase(0.5 * sqrt(wide_p)))
    c2, s2, z2, decay2 = _hyperbolic(*phase(0.5j * sqrt(wide_q)))
    p, q, large, small, beta4, shear, phi, psi = (
        rounded(v) for v in (wide_p, wide_q, large, small, w.beta4, w.shear, w.phi, w.psi)
    )
    a, b = np.where(leans, large, small), np.where(leans, small, large)
    # q/b and q/a by sums, whose second term is small for slender beams; so p/a and p/b
    rates = _Rates(
        beta4, shear, p, q, a, b, 1.0 + phi * a, _less(phi * b, p, a),
        1.0 + psi * b, _less(psi * a, p, b), 1.0 / (p + q),
    )  # fmt: skip
    # S₁ and S₂; z₂ stands for j λ₂/2, so its sinh z/z is sin z/z, its sinh² z is −sin² z
    first, second = 0.5 * _over(s1, z1), 0.5 * _over(s2, z2)
    values = _combined(
        rates, c1, c2, first, second, (s1 * s1, -s2 * s2), (decay1, decay2), kind, -1.0
    )
    reach1, reach2 = 2.0 * size(z1), 2.0 * size(z2)
    one = np.ones_like(reach1)
    sizes = _combined(
        _Rates(*(size(v) for v in _values(rates))),
        one, one, 1.0 / (1.0 + reach1), 1.0 / (1.0 + reach2), (one, one),
        (decay1.astype(float), decay2.astype(float)), kind, 1.0,
    )  # fmt: skip
    return values, sizes, _PHASE_ROUNDINGS * (1.0 + reach1 + reach2)


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


def _hyperbolic(z: Complex, rest: Complex | None) -> tuple[Complex, Complex, Complex, Floats]:
    """Cosh z and sinh z, both times exp(−|Re z|), then z and exp(−2 |Re z|).

    `rest` is what z is too short by, small enough for a first-order term in the phase.
    """
    sign = np.copysign(1.0, z.real)
    x, angle = np.abs(z.real), sign * z.imag
    decay = np.exp(-2.0 * x)
    # halves of 1 ± exp(−2 |Re z|), the lower sign without cancellation
    plus, minus = 0.5 * (1.0 + decay), -0.5 * np.expm1(-2.0 * x)
    cos, sin = np.cos(angle), np.sin(angle)
    if rest is not None:
        small = sign * rest.imag
        cos, sin = cos - small * sin, sin + small * cos
        z = z + rest
    cosh, sinh = np.empty_like(z), np.empty_like(z)
    cosh.real, cosh.imag = plus * cos, minus * sin
    sinh.real, sinh.imag = sign * minus * cos, sign * plus * sin
    return cosh, sinh, z, decay


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
        value = entry * arms[at % 3]
        for row, column, sign in _PLACES[at]:
            d[..., row, column] = d[..., column, row] = sign * value
    d[..., 1, 4], d[..., 3, 4] = beam.K, np.negative(beam.K)
    d[..., 4, 1], d[..., 4, 3] = np.negative(beam.K), beam.K
    d[..., 4, 4] = np.multiply(beam.C, length)
    return d


def condition(beam: Section, length: Any, omega: Any) -> Floats:
    """Condition numbers (..., 5, 5) of D's entries, as the module defines them."""
    _, conditions = _span_matrices(beam, length, omega)
    out = np.ones((*conditions.shape[1:], 5, 5))  # 1 for what is exact
    for at, values in enumerate(conditions):
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
    """Entries (6, n) and their condition numbers, of one block."""
    numerators, bounds = _numerators(values, -1.0), np.abs(_numerators(sizes, 1.0))
    with np.errstate(divide="ignore", invalid="ignore"):  # exactly at a pole: infinite
        poles = sizes.even / np.abs(values.even) + sizes.odd / np.abs(values.odd)
        conditions = bounds / np.abs(numerators).astype(float) + poles.astype(float)
        entries = numerators / (values.even * values.odd)
    return entries.astype(complex), conditions


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
