"""The two working precisions, and the relative error that is promised with them."""

from __future__ import annotations

from typing import Any

import numpy as np

from tactgen.geometry.arrays import Complex, Floats
from tactgen.tmm.beam.transfer.double_double import DoubleDouble

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
    """Return the relative error that results of these condition numbers may have."""
    extended = 2.0 * EPS + EXTENDED_ROUNDINGS * EXTENDED_EPS * np.asarray(condition)
    return np.maximum(TOLERATED, extended)


def sqrt(v: Any) -> Any:
    """Return the root of an array or a double-double number."""
    return v.sqrt() if isinstance(v, DoubleDouble) else np.sqrt(v)


def head(v: Any) -> Complex:
    """Return the number as doubles, for comparisons."""
    return v.hi if isinstance(v, DoubleDouble) else v


def rounded(v: Any) -> Complex:
    """Return the number in the working precision."""
    return v.hi.astype(EXTENDED) + v.lo if isinstance(v, DoubleDouble) else v


def phase(v: Any) -> tuple[Complex, Complex | None]:
    """Return the number as a double and the rest, both in the working precision."""
    if isinstance(v, DoubleDouble):
        return v.hi.astype(EXTENDED), v.lo.astype(EXTENDED)
    return v, None


def size(v: Any) -> Floats:
    """Return the magnitude as doubles."""
    return np.asarray(np.abs(v).astype(float, copy=False))
