"""Confidence intervals by the profile of the sum of squares, where linear ones mislead.

A parameter that the curve hardly determines bends the sum of squares far from a parabola,
or leaves it flat up to a bound.  Its interval then consists of the values that some choice
of the other parameters fits nearly as well as the best (likelihood ratio; Bates and Watts,
Nonlinear Regression Analysis and Its Applications, 1988, chapter 6).
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from tactgen.geometry.arrays import Floats
from tactgen.validation.studies.identification.curve_fit import Misfit, least_squares
from tactgen.validation.studies.identification.curve_model import CurveModel
from tactgen.validation.studies.identification.fit_parameters import FitParameter

#: An end is found to this fraction of its distance from the optimum (in ln p).
_TOLERANCE = 1e-2
#: A refit's sum of squares is found to this fraction; an interval's end adds some 4/n to it.
_COST_TOLERANCE = 1e-6
#: First step where the linear one is no guide (in ln p).
_LEAST_STEP, _LARGEST_STEP = 1e-3, 1.0


def profile_interval(
    model: CurveModel,
    misfit: Misfit,
    parameters: Sequence[FitParameter],
    best: Floats,
    index: int,
    *,
    variance: float,
    quantile: float,
    deviation: float,
) -> tuple[float, float, tuple[str, ...]]:
    """Return the ends of a parameter's interval, and which of them are only its bounds.

    Parameters
    ----------
    best : (p,) array
        Values at the optimum, SI.
    index : int
        The parameter.
    variance : float
        Of the residuals: estimated, or 1 where they are in units of a stated one.
    quantile : float
        Half width of an interval in standard deviations.
    deviation : float
        Linear standard deviation of ln p, a guide to the first step; may be nan.
    """
    least = float(np.sum(misfit.residuals(model(best)) ** 2))
    guess = quantile * deviation if np.isfinite(deviation) else _LARGEST_STEP
    step = float(np.clip(guess, _LEAST_STEP, _LARGEST_STEP))
    ends, opened = [], []
    for edge, direction in (("low", -1.0), ("high", 1.0)):
        room = abs(float(np.log(best[index] / getattr(parameters[index], edge))))
        walk = _Walk(model, misfit, parameters, best, index, direction, least)
        reached = _crossing(walk, least + variance * quantile**2, step, room)
        if reached is None:
            opened.append(edge)
            ends.append(float(getattr(parameters[index], edge)))
        else:
            ends.append(float(best[index] * np.exp(direction * reached)))
    return ends[0], ends[1], tuple(opened)


class _Walk:
    """The least sum of squares at a distance from the optimum, the other parameters refitted.

    Each refit begins where the last one ended, for the ends are approached step by step.
    """

    def __init__(
        self,
        model: CurveModel,
        misfit: Misfit,
        parameters: Sequence[FitParameter],
        best: Floats,
        index: int,
        direction: float,
        least: float,
    ) -> None:
        self._fit = (model, misfit, parameters)
        self._best, self._now = best, best.copy()
        self._index, self._direction = index, direction
        self._others = [i for i in range(best.size) if i != index]
        # the optimum is not refitted: of an exact curve that could end above its own target
        self._costs = {0.0: least}

    def __call__(self, distance: float) -> float:
        # a second refit at the same place could end lower, and so hide a change of sign
        if distance not in self._costs:
            self._costs[distance] = self._refitted(distance)
        return self._costs[distance]

    def _refitted(self, distance: float) -> float:
        model, misfit, parameters = self._fit
        at = self._now.copy()
        at[self._index] = self._best[self._index] * np.exp(self._direction * distance)
        if not self._others:
            return float(np.sum(misfit.residuals(model(at)) ** 2))
        cost, self._now = least_squares(
            model, misfit, parameters, at, self._others, most=30, tolerance=_COST_TOLERANCE
        )
        return 2.0 * cost


def _crossing(walk: _Walk, target: float, step: float, room: float) -> float | None:
    """Return the distance at which the sum of squares reaches the target, None if nowhere."""
    from scipy.optimize import brentq

    inner, outer = 0.0, min(step, room)
    while walk(outer) < target:
        if outer >= room:
            return None
        inner, outer = outer, min(2.0 * outer, room)
    return float(brentq(lambda d: walk(d) - target, inner, outer, xtol=_TOLERANCE * outer))
