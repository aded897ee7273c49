"""What a curve does not determine: vague parameters, and products that only their pair fixes."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from tactgen.validation.studies.curve_fit import CONFIDENCE, Statistics
from tactgen.validation.studies.fit_parameters import FittedParameter

#: Beyond this correlation the data do not separate two parameters.
_INSEPARABLE = 0.99
#: A parameter whose interval spans more than this factor is not determined by the data.
VAGUE = 2.0
#: Intervals narrower than this (of ln p) are those of an exact curve.
_EXACT = 1e-9


def findings(estimates: Sequence[FittedParameter], stats: Statistics) -> tuple[str, ...]:
    """Say what the curve does not determine, from the statistics of all parameters."""
    pairs = [
        (j, i)
        for i in range(len(estimates))
        for j in range(i)
        if abs(stats.correlation[i, j]) > _INSEPARABLE
    ]
    sentences = [_inseparable(estimates, stats, i, j) for i, j in pairs]
    tied = {i for pair in pairs for i in pair}
    for i, e in enumerate(estimates):
        if not e.edge or np.exp(min(2.0 * e.half_width, 300.0)) > VAGUE:
            sentences.append(_undetermined(e))
        if e.edge and i not in tied:
            sentences.append(
                f"{e.parameter.symbol} ended at its {'lower' if e.edge == 'low' else 'upper'} "
                f"bound {e.parameter.unit.show(e.value)}, where the data push it; widen the "
                "bounds, or do not fit it"
            )
    return tuple(sentence for sentence in sentences if sentence)


def _undetermined(e: FittedParameter) -> str:
    """How little the curve says of a parameter; nothing if it determines it."""
    name = e.parameter.symbol
    low, high = (e.parameter.unit.show(float(f"{end:.3g}")) for end in e.interval)
    span = float(np.exp(min(2.0 * e.half_width, 300.0)))
    if len(e.opened) == 2:
        text = f"the curve tells nothing about {name} between its bounds {low} and {high}"
    elif e.opened:
        limit = f"below {high}" if e.opened[0] == "low" else f"above {low}"
        text = f"{name} is not determined by this curve, which says only that it is {limit}"
    elif span > VAGUE:
        text = (
            f"{name} is practically not determined by this curve: its {100 * CONFIDENCE:g} % "
            f"interval spans a factor of {_factor(span)}"
        )
    else:
        return ""
    return f"{text}; hold it at a known value, or measure at frequencies where it acts"


def _inseparable(estimates: Sequence[FittedParameter], stats: Statistics, i: int, j: int) -> str:
    """Product of powers of two parameters that the data fix, and how well.

    Nothing if they fix none: then neither parameter is determined.
    """
    correlation = f"(correlation {stats.correlation[i, j]:+.4f})"
    powers = np.linalg.svd(stats.root[:, [i, j]])[2][1]  # the direction of least variance
    if abs(powers[1]) > 5.0 * abs(powers[0]):
        i, j, powers = j, i, powers[::-1]
    powers = powers / powers[0]
    fixed = float(stats.quantile * np.linalg.norm(stats.root[:, [i, j]] @ powers))
    if fixed > np.log(VAGUE):
        return ""
    a, b = (estimates[k].parameter.symbol for k in (i, j))
    widths = [estimates[k].half_width for k in (i, j)]
    if abs(powers[1]) < 0.1:
        return (
            f"{a} rests on {b} {correlation}: for a known {b} the curve fixes "
            f"{a} {_spread(fixed)}, else only {_spread(widths[0])}"
        )
    exponent = f"{abs(powers[1]):.3g}"
    product = f"{a} {'/' if powers[1] < 0.0 else '*'} {b if exponent == '1' else f'{b}^{exponent}'}"
    if max(widths) < _EXACT:
        return (
            f"{a} and {b} are told apart only because this curve has no noise {correlation}: with "
            f"noise it fixes {product}"
        )
    return (
        f"{a} and {b} cannot be told apart {correlation}: the curve fixes {product} "
        f"{_spread(fixed)}, but {a} alone only {_spread(widths[0])} and {b} {_spread(widths[1])}"
    )


def _spread(half_width: float) -> str:
    """How well something is known, from the half width of the interval of its ln."""
    if half_width < _EXACT:
        return "to rounding"
    if half_width < 0.2:
        return f"to ±{100.0 * half_width:.2g} %"
    return f"within a factor of {_factor(np.exp(min(half_width, 300.0)))}"


def _factor(value: float) -> str:
    return f"{value:.2g}" if value < 99.5 else f"{value:.0f}" if value < 1000.0 else "over 1000"
