"""Numerical error bars from refinement: two meshes in daily use, three where order is shown.

The grid convergence index (Roache 1994) with its usual safeguards.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

#: Order assumed between two meshes.  Corners where stiffness jumps at a clamp limit
#: quadratic elements to between 1 and 2 in energy-like quantities; 1.5 lies below what
#: the graded mesh family shows (2 to 3), so the bar errs on the wide side.
ASSUMED_ORDER = 1.5
#: Safety factor on the extrapolated error.
SAFETY = 1.25


@dataclass(frozen=True)
class Gci:
    """Outcome of a three-mesh study (relative numbers as fractions)."""

    order: float
    extrapolated: float
    fine: float
    coarse: float


def two_mesh_factor(ratio: float, order: float = ASSUMED_ORDER) -> float:
    """Return the error bar of the finer mesh per difference between two meshes.

    Parameters
    ----------
    ratio : float
        Element size of the coarser over that of the finer mesh, above 1.
    """
    return float(SAFETY / (ratio**order - 1.0))


def three_mesh_gci(fine: float, medium: float, coarse: float, ratio: float) -> Gci:
    """Return observed order, extrapolated value and grid convergence indices.

    Parameters
    ----------
    fine, medium, coarse : float
        The same quantity on three meshes of constant refinement ratio.

    Raises
    ------
    ValueError
        If the three values do not converge monotonically: then no order exists.
    """
    first, second = medium - fine, coarse - medium
    if first == 0.0 or second / first <= 1.0:
        raise ValueError("the three values do not converge monotonically")
    order = math.log(second / first) / math.log(ratio)
    gain = ratio**order - 1.0
    return Gci(
        order=order,
        extrapolated=fine - first / gain,
        fine=SAFETY * abs(first / fine) / gain,
        coarse=SAFETY * abs(second / medium) / gain,
    )
