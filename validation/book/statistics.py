"""How measured values scatter about their references, as the fire models' V&V guides state it."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from tactgen.geometry.arrays import Floats
from tactgen.validation.checks.verification import Verified


@dataclass(frozen=True)
class Scatter:
    """Measured values over references of a group's rows that have one number to meet.

    Attributes
    ----------
    measured, reference : (n,) array
        Absolute values; a row whose signs differ is left out and counted as a fail anyway.
    bias : float
        exp of the mean of ln(measured/reference), with the half variance of a log-normal.
    spread : float
        Standard deviation of ln(measured/reference): the relative scatter.
    """

    measured: Floats
    reference: Floats
    bias: float
    spread: float


def scatter(rows: Sequence[Verified]) -> Scatter | None:
    """Return the scatter of the rows that were to agree, or None if fewer than two have a number.

    Rows that differ for a stated reason are not counted: they say nothing about the models.
    """
    pairs = [
        (row.outcome.measured, row.check.reference)
        for row in rows
        if row.outcome is not None
        and row.verdict in ("pass", "fail")
        and isinstance(row.check.reference, float | int)
        and row.outcome.measured * row.check.reference > 0.0
    ]
    if len(pairs) < 2:
        return None
    measured, reference = np.abs(np.array(pairs)).T
    logarithms = np.log(measured / reference)
    spread = float(logarithms.std(ddof=1))
    bias = math.exp(float(logarithms.mean()) + 0.5 * spread**2)
    return Scatter(measured, reference, bias, spread)
