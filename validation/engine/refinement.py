"""Numerical error bars of the solid model: two meshes, and what their difference says.

The grid convergence index (Roache 1994) with an assumed order or gain and its safety factor.
"""

from __future__ import annotations

import numpy as np

from tactgen.geometry.arrays import Floats

#: Order assumed between two uniform meshes of tetrahedra.  Corners where stiffness jumps at a clamp
#: limit quadratic elements to between 1 and 2 in energy-like quantities.
ASSUMED_ORDER = 1.5
#: Factor by which the error falls at least from one level of bricks to the next: with it, and
#: the safety factor, 19 of 20 errors of varied bimorphs are within their bars
#: (validation/checks/coverage/solid.py).
ASSUMED_GAIN = 1.6
#: The same of the bimorph on its rod, where the slot's edges slow it down: from its level 4 to 5
#: the error of the first frequency falls by 1.43 (tests/validation/models/test_solid_on_rod.py).
ROD_GAIN = 1.4
#: Least gain in error of halved elements that is counted with.  Less is seen where rounding is all
#: that separates two meshes; then what does separate them is the bar, with the safety factor.
LEAST_HALVED = 2.0
#: Safety factor on the extrapolated error.
SAFETY = 1.25
#: Share of the largest difference in a class of modes, or at rest.
_BY_CHANCE = 0.1
#: Error bar of one level of bricks per difference from the next coarser level.
BRICK_FACTOR = SAFETY / (ASSUMED_GAIN - 1.0)
#: Error bar of bricks per difference that polynomials of one degree more make by their residual,
#: those of displacement and those of potential apart: at rest, and of natural frequencies.  Theirs
#: is most of what is missing, and least where edges are singular.  Of bimorphs drawn at random 19
#: of 20 errors are within their bars, and half the bars at most five times the error
#: (validation/checks/coverage/solid.py).
SURPLUS_FACTOR, SURPLUS_FACTOR_OF_MODES = 2.75, 3.5
#: Error bar of their response per difference from the next coarser level.  What is missing at rest,
#: which counts with the factor above, is enough about the first resonance; beyond the second 19 of
#: 20 errors are below this share.
RESPONSE_FACTOR = 0.7
#: The same on the rod.
ROD_FACTOR = SAFETY / (ROD_GAIN - 1.0)


def observed_factor(before: Floats, last: Floats, order: float) -> Floats:
    """Return the error bar of the finest of three meshes per difference from the next coarser.

    Each mesh has the last one's elements halved.  The error falls by what the two differences
    show: at most by what the order promises, at least by :data:`LEAST_HALVED`.

    Parameters
    ----------
    before, last : (...) array
        Sizes of the difference of the coarser two meshes, and of the finer two.
    order : float
        Of the error in the size of elements.
    """
    shown = np.asarray(before) / np.maximum(last, np.finfo(float).tiny)
    return np.asarray(SAFETY / (np.clip(shown, LEAST_HALVED, 2.0**order) - 1.0))


def least_difference(fine: Floats, coarse: Floats) -> Floats:
    """Return the relative difference (...) that each answer of a group counts with at least.

    Two levels may agree in one mode, or in one answer at rest, by chance, while they differ in
    its neighbours: a tenth of the largest difference in the group.

    Parameters
    ----------
    fine, coarse : (..., n) array
        Frequencies of one class of motion, or sizes at rest; nan where a mode has no partner.
        What is zero, such as motion without piezoelectricity, has no share.
    """
    apart = np.abs(fine - coarse) / np.where(fine == 0.0, np.inf, fine)
    return np.asarray(
        _BY_CHANCE * np.where(np.isfinite(apart), apart, 0.0).max(axis=-1, initial=0.0)
    )


def two_mesh_factor(ratio: float, order: float = ASSUMED_ORDER) -> float:
    """Return the error bar of the finer mesh per difference between two meshes.

    Parameters
    ----------
    ratio : float
        Element size of the coarser over that of the finer mesh, above 1.
    """
    return float(SAFETY / (ratio**order - 1.0))
