"""Newton's method for small dense systems, each step as long as it brings the answer nearer.

A step is judged by the next one, taken with the same factors (Deuflhard's natural monotonicity
test), so that the units of equations do not matter.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from tactgen.geometry.arrays import Floats

#: Stop after a step that is this share of the unknowns' scale: what is left goes as its square.
TOLERANCE = 1e-7
_SHORTEST = 2.0**-6


class NoConvergence(ArithmeticError):
    """Newton's method did not find an orbit; the message says in one sentence why."""


def converge(
    evaluate: Callable[[Floats], tuple[Floats, Floats]],
    start: Floats,
    scale: Floats,
    most: int,
) -> tuple[Floats, int, Floats]:
    """Return the zero of a function, the number of steps taken, and the Jacobian there (m, m).

    Parameters
    ----------
    evaluate : callable
        From unknowns (m,) to residual (m,) and Jacobian (m, m).
    start : (m,) array
        First guess.
    scale : (m,) array
        Size of each unknown.
    most : int
        Steps allowed.

    Raises
    ------
    NoConvergence
        If the steps do not become small.
    """
    x = start
    residual, jacobian = evaluate(x)
    for count in range(1, most + 1):
        scaled = jacobian * scale
        step = -_solve(scaled, residual)
        size = float(np.linalg.norm(step))
        if size <= TOLERANCE:
            return x + scale * step, count, jacobian
        length = 1.0
        while True:
            there = x + length * scale * step
            residual, jacobian = evaluate(there)
            after = float(np.linalg.norm(_solve(scaled, residual)))
            if after <= (1.0 - 0.25 * length) * size:
                break
            length *= 0.5
            if not np.isfinite(after) or length < _SHORTEST:
                raise NoConvergence("Newton's method did not settle: no step brought it nearer")
        x = there
    raise NoConvergence(f"Newton's method did not settle in {most} steps")


def _solve(matrix: Floats, right: Floats) -> Floats:
    try:
        return np.asarray(np.linalg.solve(matrix, right))
    except np.linalg.LinAlgError:
        raise NoConvergence("the equations are singular: nothing holds a coordinate") from None
