"""Numerical error bars: two meshes, or a mesh and its residual, and what they say.

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
#: (validation/evidence/coverage_bimorph.py).
ASSUMED_GAIN = 1.6
#: Least gain in error of halved elements that is counted with.  Less is seen where rounding is all
#: that separates two meshes; then what does separate them is the bar, with the safety factor.
LEAST_HALVED = 2.0
#: Safety factor on the extrapolated error.
SAFETY = 1.25
#: Share of the largest difference in a class of modes, or at rest; or of what a difference of two
#: errors can be at most.
_BY_CHANCE = 0.1
#: Error bar of one level of bricks per difference from the next coarser level.
BRICK_FACTOR = SAFETY / (ASSUMED_GAIN - 1.0)
#: Error bar of bricks per difference that polynomials of one degree more make by their residual,
#: those of displacement and those of potential apart.  Theirs is most of what is missing, but less
#: where the solution is singular at an edge inside the body: at the end of a tab, of glue or of an
#: electrode, or where a base holds the shim alone.  Chosen on 31 bimorphs drawn at random, so that
#: 19 of 20 errors are within their bars; of 35 drawn after it 98 % were, with half the bars at most
#: 4.2 times the error (validation/evidence/coverage_bimorph.py).  With one factor for all, those
#: without such an edge had to have bars of ten errors for those with one to be covered.
SURPLUS_FACTOR, SURPLUS_FACTOR_AT_EDGES = 2.5, 5.0


def observed_factor(before: Floats, last: Floats, order: float) -> Floats:
    """Error bar of the finest of three meshes per difference from the next coarser.

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
    """Relative difference (...) that each answer of a group counts with at least.

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


def cancelling(change: float, most: float) -> float:
    """Size that a difference of two errors counts with, estimated as `change`.

    Of two errors that are much alike next to nothing may be left by chance: a tenth of the `most`
    that it can be counts besides.  Chosen on coupling factors of 20 bimorphs and of 15 members of
    families drawn at random: with the factors above, those of 20 and of 7 drawn after them were
    all covered, half of them by bars of at most 2.7 and 2.2 errors.
    """
    return abs(change) + _BY_CHANCE * most


def two_mesh_factor(ratio: float, order: float = ASSUMED_ORDER) -> float:
    """Error bar of the finer mesh per difference between two meshes.

    Parameters
    ----------
    ratio : float
        Element size of the coarser over that of the finer mesh, above 1.
    """
    return float(SAFETY / (ratio**order - 1.0))
