"""Newton's method on a convex energy, each step as long as that energy wants it.

Finds where ∫ ψ(F0 + K x) dV is least, K linear.  The magnetic energies are convex because
H grows with B: the exact Jacobian is never indefinite, and along a step the slope of the
energy only grows, so the best length is the one zero of that slope.  Finding it costs a
few field evaluations, which are cheap beside a factorisation; halving the step until the
energy falls takes three times as many factorisations with the scalar potential.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from fem.solvers.linear_solver import Factor, factorise
from geometry.arrays import Floats, Sparse

#: Stop when the step's energy norm is this fraction of the field's: energies are then right
#: to its square.
_TOLERANCE = 1e-7
_MAX_STEPS = 60
#: A step is long enough when this fraction of the initial slope is left.
_SLOPE_LEFT = 0.1
_MAX_TRIALS = 30
#: Relative rounding of an energy, the sum over all quadrature points.
_ROUNDING = 1e-12


class ConvexEnergy(Protocol):
    """An energy of the unknowns x (n,)."""

    def value(self, x: Floats) -> float:
        """Return the energy (J)."""
        ...

    def scale(self, x: Floats) -> float:
        """Return a positive energy (J) of the size of the field's own."""
        ...

    def gradient(self, x: Floats) -> Floats:
        """Return the gradient (n,)."""
        ...

    def hessian(self, x: Floats) -> Sparse:
        """Return the Hessian (n, n), or what differs little from it, positive definite."""
        ...


class NotConvergedError(RuntimeError):
    """Newton's method did not arrive; the message says how far it got."""


@dataclass(frozen=True)
class Minimum:
    """Where Newton's method ended.

    Attributes
    ----------
    x : (n,) float
        Unknowns.
    steps : int
        Newton steps taken.
    """

    x: Floats
    steps: int


def minimise(energy: ConvexEnergy, start: Floats) -> Minimum:
    """Return the minimum of `energy`.

    Raises
    ------
    NotConvergedError
        If it takes more than 60 steps.
    """
    x, size = start, np.inf
    factor: Factor | None = None
    for step in range(1, _MAX_STEPS + 1):
        gradient = energy.gradient(x)
        if not gradient.any():
            return Minimum(x, step - 1)
        if factor is None:
            factor = factorise(energy.hessian(x), definite=True)
        else:
            factor.refactorise(energy.hessian(x))
        direction = -factor.solve(gradient)
        slope = float(gradient @ direction)
        x = x + _length(energy, x, direction, slope) * direction
        size = np.sqrt(max(-slope, 0.0) / energy.scale(x))
        if size <= _TOLERANCE:
            return Minimum(x, step)
    raise NotConvergedError(
        f"the magnetic field did not settle in {_MAX_STEPS} Newton steps "
        f"(last step {size:.1e} of the field); check the magnetisation curves"
    )


def _length(energy: ConvexEnergy, x: Floats, direction: Floats, slope: float) -> float:
    """Return how far to go along `direction`, 1 at most, by regula falsi on the slope.

    A small slope alone is not enough: where the curve has flattened out it may be far
    beyond the minimum, so the energy must not have grown either.
    """
    enough = _SLOPE_LEFT * abs(slope)
    ceiling = energy.value(x) + _ROUNDING * energy.scale(x)
    low, slope_low, high, slope_high, length = 0.0, slope, 1.0, np.inf, 1.0
    for _ in range(_MAX_TRIALS):
        there = x + length * direction
        slope_there = float(energy.gradient(there) @ direction)
        over = slope_there > 0.0
        short = slope_there < -enough and length < 1.0
        far = slope_there > enough or (over and energy.value(there) > ceiling)
        if not (short or far):
            break
        if over:
            high, slope_high = length, slope_there
        else:
            low, slope_low = length, slope_there
        fraction = np.clip(slope_low / (slope_low - slope_high), 0.1, 0.9)
        length = low + (high - low) * float(fraction)
    return length
