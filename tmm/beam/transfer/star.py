"""Redheffer's star product (1962) of elements in wave variables, and rows joined by it.

What the waves are, and what X is, stands in :mod:`tmm.beam.transfer.scattering`.
"""

from __future__ import annotations

import numpy as np

from tactgen.geometry.arrays import Complex


def neighbours(order: list[int]) -> tuple[list[int], list[int], list[int], list[int]]:
    """Pair what stands side by side in a row of numbered things; equal pairs count once.

    Returns
    -------
    lower, upper : list of int
        Numbers of the two things of each different pair.
    left_over : list of int
        The last one of an odd row.
    order : list of int
        The shorter row, numbered by pairs, then what is left over.
    """
    pairs = list(zip(order[::2], order[1::2], strict=False))
    place = {pair: i for i, pair in enumerate(dict.fromkeys(pairs))}
    lower, upper = (list(side) for side in zip(*place, strict=True))
    left_over = order[2 * len(pairs) :]
    return lower, upper, left_over, [place[p] for p in pairs] + [len(place)] * len(left_over)


def tree(made: Complex, order: list[int]) -> Complex:
    """Join (k, n, 5, 5) in the given order: neighbours, then pairs of neighbours, and so on."""
    while len(order) > 1:
        lower, upper, left_over, order = neighbours(order)
        made = np.concatenate([star(made[lower], made[upper]), made[left_over]])
    return np.asarray(made[order[0]])


def star(lower: Complex, upper: Complex) -> Complex:
    """Return X (..., 5, 5) of two elements joined: both see the same U, charges add.

    At the joint a of one end is −b of the other: forces cancel, displacements agree.  The
    wave up out of the lower element is −a_0 + up, the one down into it a_1 + down:

        up = X_10 a_0 + R_1 (a_1 + down) + s_1 U,   down = R_0 (up − a_0) − X_01 a_1 − s_0 U,

    R_1, s_1, X_10 of the lower element's upper end and R_0, s_0, X_01 of the upper's lower.
    """
    below, above = lower[..., 2:4, :], upper[..., :2, :]
    back, reflected = below[..., 2:4], above[..., :2]
    # what enters the waves at the joint without `up`: columns a_0, a_1, U
    entering = -above
    right = below + back @ entering
    up = np.linalg.solve(np.eye(2) - back @ reflected, right)
    down = entering + reflected @ up
    s = lower + upper
    s[..., :2, :] = lower[..., :2, :] - down + lower[..., :2, 2:4] @ down
    s[..., 2:4, :] = upper[..., 2:4, :] + up - upper[..., 2:4, :2] @ up
    s[..., 4, :] += (lower[..., 4:5, 2:4] @ down - upper[..., 4:5, :2] @ up)[..., 0, :]
    return s
