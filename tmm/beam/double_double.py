"""Complex numbers of twice the double's length, as unevaluated sums of two doubles.

Error-free sums and products (Dekker 1971; Knuth, TAOCP 2, 4.2.2) without a fused
multiply-add, some 30 digits on every machine.  Only what wave parameters need: the
four operations and the square root.
"""

from __future__ import annotations

from typing import Any, TypeAlias

import numpy as np

from tactgen.geometry.arrays import Bools, Complex, Floats

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
        """Return the root with the branch that numpy's has; one Newton step doubles it."""
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
    """Return a + b and its rounding error; exact part by part."""
    total = a + b
    back = total - a
    return total, (a - (total - back)) + (b - back)


def _product(a: Complex, b: Complex) -> tuple[Complex, Complex]:
    """Return a b and its rounding error."""
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
