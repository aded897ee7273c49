"""Newton's method on a convex energy, each step as long as that energy wants it.

Finds where ∫ ψ(F0 + K x) dV is least, K linear.  The magnetic energies are convex because
H grows with B: the exact Jacobian is never indefinite, and along a step the slope of the
energy only grows, so the best length is the one zero of that slope.  Finding it costs a
few field evaluations, which are cheap beside a factorisation; halving the step until the
energy falls takes three times as many factorisations with the scalar potential.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from tactgen.fem.solvers.linear_solver import Factor, SolverError, factorise
from tactgen.geometry.arrays import Floats, Sparse

#: Stop when the energy norm of what will be left is this fraction of the field's, once the factors
#: at hand have taken away what they can: as much as in the step before, yet nine tenths at most.
TOLERANCE, _MOST_TAKEN = 1e-10, 0.1
#: Rounding may keep it above; a last step of this size leaves its square.
_LAST_STEP = 1e-7
_MAX_STEPS = 60
#: A step is long enough when this fraction of the initial slope is left.
_SLOPE_LEFT = 0.1
_MAX_TRIALS = 30
#: A trial by interpolation stays so far from the ends of its bracket, as a share of it.
_WITHIN = 0.1
#: Relative rounding of an energy, the sum over all quadrature points.
_ROUNDING = 1e-12
#: Factors are kept as long as each step with them leaves no more than this: a new Hessian and its
#: factors cost as much as five such steps.
_FAST = 0.3
#: Those of another field are tried where it is this near, in the energy norm.
_NEAR = 0.03
#: Energy norm of what a solution by the factors of a matrix nearby may miss before most of that is
#: taken away; and corrections that cost as much as a factorisation of the matrix itself.
_CORRECTED, _MOST_CORRECTIONS = 1e-6, 6


class ConvexEnergy(Protocol):
    """An energy of the unknowns x (n,)."""

    def value(self, x: Floats) -> float:
        """Energy (J)."""
        ...

    def scale(self, x: Floats) -> float:
        """Positive energy (J) of the size of the field's own."""
        ...

    def gradient(self, x: Floats) -> Floats:
        """Gradient (n,)."""
        ...

    def hessian(self, x: Floats) -> Sparse:
        """Positive definite Hessian (n, n), or one close to it."""
        ...


class Factors:
    """The factors of one Hessian after the other; their common ordering is found once."""

    def __init__(self) -> None:
        self._factor: Factor | None = None

    @property
    def held(self) -> bool:
        """Whether there are any."""
        return self._factor is not None

    def update(self, matrix: Sparse) -> None:
        """Take a matrix of the same pattern as those before."""
        if not (matrix.diagonal() > 0.0).all():
            raise _not_convex()
        if self._factor is None:
            self._factor = factorise(matrix, definite=True)
        else:
            self._factor.refactorise(matrix)

    def solve(self, right: Floats) -> Floats:
        """Solution for right sides (n,) or (n, k)."""
        assert self._factor is not None
        return self._factor.solve(right)

    def solve_near(self, matrix: Sparse, right: Floats) -> Floats:
        """Solution of a matrix near that of the factors, which it becomes if needed.

        By conjugate gradients with them, for each of the right sides (n, k).
        """
        columns = [self._nearby(matrix, each) for each in right.T] if self.held else [None]
        found = [each for each in columns if each is not None]
        if len(found) == right.shape[1]:
            return np.stack(found, axis=1)
        self.update(matrix)
        return self.solve(right)

    def _nearby(self, matrix: Sparse, right: Floats) -> Floats | None:
        found, left = np.zeros_like(right), right
        direction = taken = self.solve(left)
        size = before = float(left @ taken)
        for _ in range(_MOST_CORRECTIONS):
            across = matrix @ direction
            length = before / float(direction @ across)
            found, left = found + length * direction, left - length * across
            taken = self.solve(left)
            now = float(left @ taken)
            if now <= _CORRECTED**2 * size:
                return found + taken
            direction, before = taken + now / before * direction, now
        return None


@dataclass(frozen=True)
class Minimum:
    """Where Newton's method ended."""

    x: Floats  #: (n,) Unknowns
    steps: int  #: Newton steps taken, each with a Hessian of its own; others use its factors again


def minimise(
    energy: ConvexEnergy,
    start: Floats,
    factors: Factors | None = None,
    tolerance: float = TOLERANCE,
) -> Minimum:
    """Minimum of `energy`.

    Hessians' factors are used again while they are good: first of all those that are given, of
    earlier Hessians of the same pattern; afterwards they are of the last one made.  `tolerance` is
    the energy norm of what may be left, over the field's.

    Raises SolverError if it takes more than 60 steps, or the energy is not convex.
    """
    x, left, hessians = start, np.inf, 0
    factors = factors or Factors()
    gradient = energy.gradient(x)
    rest = factors.solve(gradient) if factors.held else None
    if rest is not None and not gradient @ rest <= _NEAR**2 * energy.scale(x):
        rest = None
    for _ in range(_MAX_STEPS):
        if not gradient.any():
            return Minimum(x, hessians)
        anew = rest is None
        if anew:
            factors.update(energy.hessian(x))
            hessians += 1
        direction = -(factors.solve(gradient) if rest is None else rest)
        slope = float(gradient @ direction)
        if not slope <= 0.0:
            raise _not_convex()
        share = _SLOPE_LEFT if anew else _FAST
        x, gradient, whole = _stepped(energy, x, direction, slope, share)
        size = energy.scale(x)
        # what is left is measured by the factors from before the step: the same to first order
        rest = factors.solve(gradient)
        before, left = (
            math.sqrt(abs(each) / size) if size else 0.0 for each in (slope, float(gradient @ rest))
        )
        # if not whole, the factors are far too soft here, and so is what they take
        if whole and left * max(left, _MOST_TAKEN * before) <= tolerance * before:
            return Minimum(x - rest, hessians)  # known, so taken away as well
        if anew and -slope <= _LAST_STEP**2 * size:
            return Minimum(x, hessians)
        if left > _FAST * before or not whole:
            rest = None
    raise SolverError(
        f"the magnetic field did not settle in {_MAX_STEPS} Newton steps "
        f"({left:.1e} of the field is left); check the magnetisation curves"
    )


def _not_convex() -> SolverError:
    return SolverError("the magnetic field's energy is not convex; check the magnetisation curves")


def _stepped(
    energy: ConvexEnergy, x: Floats, direction: Floats, slope: float, share: float = _SLOPE_LEFT
) -> tuple[Floats, Floats, bool]:
    """Where a step along `direction` ends, the gradient there, and whether it is whole.

    Its share of `direction`, 1 at most, is found by regula falsi on the slope, up to a share that
    may be left; the slope of an end that stays is halved each time (the Illinois rule; M. Dowell
    and P. Jarratt, BIT 11 (1971) 168): else where the slope has saturated, one end would hardly
    move.

    A small slope alone is not enough: where the curve has flattened out it may be far
    beyond the minimum, so the energy must not have grown either.
    """
    enough = share * abs(slope)
    ceiling = energy.value(x) + _ROUNDING * energy.scale(x)
    low, slope_low, high, slope_high, length = 0.0, slope, 1.0, np.inf, 1.0
    high_moved = False  # by the trial before
    for _ in range(_MAX_TRIALS):
        there = x + length * direction
        gradient = energy.gradient(there)
        slope_there = float(gradient @ direction)
        over = slope_there > 0.0
        short = slope_there < -enough and length < 1.0
        far = slope_there > enough or (over and energy.value(there) > ceiling)
        if not (short or far):
            return there, gradient, length == 1.0
        if over:
            if high_moved:
                slope_low *= 0.5
            high, slope_high = length, slope_there
        else:
            if not high_moved:
                slope_high *= 0.5
            low, slope_low = length, slope_there
        high_moved = over
        fraction = np.clip(slope_low / (slope_low - slope_high), _WITHIN, 1.0 - _WITHIN)
        length = low + (high - low) * float(fraction)
    return there, gradient, False
