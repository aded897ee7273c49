"""The paper's own way of computing: its matrix A, corrected, in plain double precision.

What the transfer-matrix model is compared with for accuracy and speed, and what the audit of the
printed formulas asks for the effect of each.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from tactgen.geometry.arrays import Complex, Floats
from tactgen.tmm.beam.printed_formulas import matrix_a
from tactgen.tmm.beam.sections import Section


def transfer(beam: Section, length: float, frequencies: Floats) -> Complex:
    """A (n, 5, 5), overflow and 0/0 included."""
    with np.errstate(all="ignore"):
        return matrix_a(beam, length, frequencies)


def dynamic_stiffness(beam: Section, length: float, frequencies: Floats) -> Complex:
    """D (n, 5, 5) over [w_0, ψ_0, w_l, ψ_l, U] by inverting A's upper right block."""
    a, jw = transfer(beam, length, frequencies), 2j * np.pi * np.asarray(frequencies, float)
    n = jw.size
    # internal [M, F] below that turn the motion below into the motion above; rates to motions
    given = np.zeros((n, 2, 5), dtype=complex)
    given[:, 0, 2] = given[:, 1, 3] = jw
    with np.errstate(all="ignore"):
        given[:, :, :2] = -a[:, :2, :2] * jw[:, None, None]
        given[:, :, 4] = -a[:, :2, 4]
        below = _solved(a[:, :2, 2:4], given)
        above = a[:, 2:, 2:4] @ below
        above[:, :, :2] += a[:, 2:, :2] * jw[:, None, None]
        above[:, :, 4] += a[:, 2:, 4]
        above[:, 2] /= jw[:, None]  # current to charge
    return np.stack([-below[:, 1], -below[:, 0], above[:, 1], above[:, 0], above[:, 2]], axis=1)


def response(a: Complex, frequencies: Floats, *, base: tuple[Any, Any] | None, tip: Any) -> Complex:
    """Tip velocity and current per volt (2, n): paper eqs 6-12, boundary conditions through A.

    Dynamic stiffnesses `base` (lateral, rotational; None is a clamp) and `tip` hold the ends.
    """
    jw = 2j * np.pi * np.asarray(frequencies, float)
    start = np.zeros((jw.size, 5, 3), dtype=complex)  # below: two unknowns, and U
    with np.errstate(all="ignore"):
        if base is None:
            start[:, 2, 0] = start[:, 3, 1] = 1.0
        else:
            start[:, 0, 0], start[:, 3, 0] = 1.0, base[0] / jw
            start[:, 1, 1], start[:, 2, 1] = 1.0, base[1] / jw
        start[:, 4, 2] = 1.0
        above = a @ start
        conditions = np.stack([above[:, 2], above[:, 3] + (tip / jw)[:, None] * above[:, 0]], 1)
        unknown = _solved(conditions[:, :, :2], -conditions[:, :, 2:])[:, :, 0]
        state = np.einsum("nij,nj->in", above[:, [0, 4], :2], unknown) + above[:, [0, 4], 2].T
    return np.asarray(state)


def _solved(matrix: Complex, right: Complex) -> Any:
    """Solve (n, 2, 2) systems by Cramer's rule; a singular one gives infinities."""
    (a, b), (c, d) = matrix[:, 0].T, matrix[:, 1].T
    inverse = np.array([[d, -b], [-c, a]]).transpose(2, 0, 1) / (a * d - b * c)[:, None, None]
    return inverse @ right
