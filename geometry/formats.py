"""Number formats: engineering units, digits that the error allows."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

_PREFIX = {
    -15: "f", -12: "p", -9: "n", -6: "µ", -3: "m", 0: "", 3: "k", 6: "M", 9: "G",
}  # fmt: skip

#: Units of checks that are no SI units or counts: 42 thousandths of an inch are no minutes.
_PLAIN = frozenset({"in", "psi", "bars", "folds", "peaks"})


def engineering(value: float, unit: str, digits: int = 5) -> str:
    """Value with an SI prefix, e.g. ``49.56 µm``; plain for pure numbers."""
    value += 0.0  # no -0
    if unit in ("", "1"):
        return f"{value:.{digits}g}"
    if unit in _PLAIN:
        return f"{value:.{digits}g} {unit}"
    if value == 0.0 or not math.isfinite(value):
        return f"{value:g} {unit}"
    shown = float(f"{value:.{digits - 1}e}")  # what rounds up to 1000 has the next prefix
    exponent = max(-15, min(9, 3 * math.floor(math.log10(abs(shown)) / 3.0)))
    text = f"{value / 10.0**exponent:.{digits}g}"
    if (
        "e" in text and 1.0 <= abs(float(text)) < 1000.0
    ):  # fewer digits than it has before the point
        text = f"{float(text):.0f}"
    return f"{text} {_PREFIX[exponent]}{unit}"


def prefixed(largest: float, unit: str) -> tuple[float, str]:
    """Unit with the SI prefix that suits a magnitude, and how many of it make one unit."""
    if unit in ("", "1") or not math.isfinite(largest) or largest == 0.0:
        return 1.0, unit
    exponent = max(-15, min(9, 3 * math.floor(math.log10(abs(largest)) / 3.0)))
    return 10.0**-exponent, f"{_PREFIX[exponent]}{unit}"


def with_error(value: float, bar: float, unit: str) -> str:
    """Value ± bar in one unit, with two digits of the bar.

    Bars below 1e-7 of the value are shown as a power of ten, since the digits before them say
    nothing to a reader.
    """
    if value == 0.0 or not math.isfinite(value):
        return engineering(value, unit)
    if not math.isfinite(bar):
        return f"{engineering(value, unit)} (no error bar)"
    if bar == 0.0:
        return engineering(value, unit, 7)
    relative = abs(bar / value)
    if relative < 1e-7:
        return f"{engineering(value, unit, 7)} (±{relative:.0e} relative)"
    larger = max(abs(value), bar)  # a value within its bar is read beside it
    exponent = (
        0 if unit in ("", "1") else max(-15, min(9, 3 * math.floor(math.log10(larger) / 3.0)))
    )
    scaled, shown = value / 10.0**exponent, bar / 10.0**exponent
    decimals = max(0, 1 - math.floor(math.log10(shown)))
    prefix = "" if unit in ("", "1") else f" {_PREFIX[exponent]}{unit}"
    return f"{scaled:z.{decimals}f} ± {shown:.{decimals}f}{prefix}"


#: Bars below this share of their value are not shown.
FINE = 1e-5


def with_share(value: float, bar: float, unit: str, text: str = "") -> str:
    """Value to five digits ± bar in percent of it, which is left out below :data:`FINE`.

    A value of zero has its bar in its own unit.  `text` stands for the value if it is given.
    """
    if math.isnan(value):
        return "no value"
    text = text or engineering(value, unit)
    if math.isnan(bar):
        return text
    if not value:
        return f"{text} ±{engineering(bar, unit, 2)}" if bar else text
    relative = abs(bar / value)
    return f"{text} ±{share(relative)}" if relative >= FINE else text


def signed(value: float, decimals: int) -> str:
    """Number with its sign and so many decimals; what rounds to zero has no sign."""
    text = f"{value:+.{decimals}f}"
    return text if float(text) else text[1:]


def percent(value: float, decimals: int | None = None) -> str:
    """Signed fraction in percent, to so many decimals or down to rounding."""
    if not math.isfinite(value):
        return "n/a"
    if decimals is not None:
        return f"{signed(100.0 * value, decimals)} %"
    if abs(value) < 1e-11:
        return "0 %"
    if abs(value) < 5e-6:
        return f"{100.0 * value:+.0e} %"
    return f"{100.0 * value:+.3f} %"


def share(value: float) -> str:
    """Fraction without a sign in percent, two digits: an error bar, a size."""
    if not math.isfinite(value):
        return "n/a"
    return f"{two_digits(100.0 * value):g} %"


def two_digits(value: float) -> float:
    """Number rounded to two digits, which ``g`` then shows without an exponent."""
    return float(f"{value:.2g}")


def filters() -> dict[str, Callable[..., Any]]:
    """Template filters."""
    return {
        "eng": engineering,
        "bar": with_error,
        "percent": percent,
        "share": share,
        "signed": signed,
    }
