"""Folds and peaks of a branch, found to rounding between two of its points."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TypeAlias

from tactgen.tmm.harmonic_balance.continuation import Branch, Step, with_harmonics
from tactgen.tmm.harmonic_balance.oscillator import Orbit, Oscillator

#: A complex amplitude that is read off an orbit.
Readout: TypeAlias = Callable[[Orbit], complex]

#: Step of the derivative along the branch, relative to its length of 1.
_STEP = 1e-5


@dataclass(frozen=True)
class SpecialPoint:
    """An orbit between two points of a branch.

    Attributes
    ----------
    orbit : Orbit
        The orbit.
    after : int
        Index of the point before it.
    """

    orbit: Orbit
    after: int


def folds(oscillator: Oscillator, branch: Branch) -> tuple[SpecialPoint, ...]:
    """Return where the parameter turns back."""
    return _zeros(oscillator, branch, lambda step: float(step.tangent[-1]), falling=False)


def peaks(oscillator: Oscillator, branch: Branch, amplitude: Readout) -> tuple[SpecialPoint, ...]:
    """Return where the magnitude of an amplitude is largest along the branch."""

    def slope(step: Step) -> float:
        y, course = step.course.pack(step.orbit), step.course
        ahead, behind = (
            abs(amplitude(course.unpack(y + s * step.tangent, step.orbit))) for s in (_STEP, -_STEP)
        )
        return float(ahead - behind)

    return _zeros(oscillator, branch, slope, falling=True)


def _zeros(
    oscillator: Oscillator, branch: Branch, of: Callable[[Step], float], *, falling: bool
) -> tuple[SpecialPoint, ...]:
    from scipy.optimize import brentq

    found = []
    values = [of(step) for step in branch.steps]
    pairs = zip(branch.steps, branch.steps[1:], values, values[1:], strict=False)
    for index, (step, after, here, there) in enumerate(pairs):
        if here * there >= 0.0 or (falling and here < 0.0) or after.length == 0.0:
            continue
        begin = with_harmonics(step, max(step.orbit.harmonics, after.orbit.harmonics))
        begin = begin.at(oscillator, 0.0)
        ends = [of(begin), of(begin.at(oscillator, step.length))]
        if ends[0] * ends[1] >= 0.0:  # the zero lies beside a point, by rounding
            nearer = step.orbit if abs(here) < abs(there) else after.orbit
            found.append(SpecialPoint(nearer, index))
            continue
        length = brentq(
            lambda s, begin=begin: of(begin.at(oscillator, s)), 0.0, step.length, xtol=1e-12
        )
        found.append(SpecialPoint(begin.at(oscillator, float(length)).orbit, index))
    return tuple(found)
