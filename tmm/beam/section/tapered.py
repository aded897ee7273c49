"""A tapered beam as prismatic segments, to fourth order in their length.

Along a taper the state y = [w, ψ, F, M, Q, U] obeys y' = A(z) y with entries that are sums of
1/EI, 1/GA, m Ω², ρI Ω², K/EI and C + K²/EI.  Over a segment of length l, with A₁ and A₂ at
its two Gauss points, the commutator-free Magnus method of order four (Blanes and Moan,
Appl. Numer. Math. 56, 2006, 1519) is

    y(l) = exp(l (a A₂ + b A₁)) exp(l (a A₁ + b A₂)) y(0),   a, b = 1/4 ± √3/6,

and since a + b = 1/2 either factor is a prismatic beam half as long.  So the segments are
joined, and stay reciprocal and passive, like any others.
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from tactgen.tmm.beam.section.section import Constant, Section

#: Shares of a segment's length at which its sections are taken.
_GAUSS = (0.5 - math.sqrt(3.0) / 6.0, 0.5 + math.sqrt(3.0) / 6.0)
#: Weights 2 a and 2 b of the nearer and the farther one.
_NEAR, _FAR = 0.5 + math.sqrt(3.0) / 3.0, 0.5 - math.sqrt(3.0) / 3.0
#: Ratio of the two sections' stiffness above which the nearer one is taken as it is: a taper
#: that runs out to nearly nothing, where the farther one's small weight would turn signs.
_STEEPEST = 8.0


def segmented(
    at: Callable[[float], Section], length: float, segments: int
) -> list[tuple[Section, Constant]]:
    """Return prismatic beams, two for each segment, with their lengths (m).

    `at` gives the section at a share of the length.
    """
    found = []
    for i in range(segments):
        low, high = (at((i + point) / segments) for point in _GAUSS)
        half = 0.5 * length / segments
        found += [(_mean(low, high), half), (_mean(high, low), half)]
    return found


def _mean(near: Section, far: Section) -> Section:
    """Return the prismatic section whose A is 2 a A_near + 2 b A_far."""
    ratio = np.abs(near.EI / far.EI)
    if np.any((ratio > _STEEPEST) | (ratio < 1.0 / _STEEPEST)):
        return near

    def mean(first: Constant, second: Constant) -> Constant:
        return _NEAR * first + _FAR * second

    stiffness = 1.0 / mean(1.0 / near.EI, 1.0 / far.EI)
    coupling = mean(near.K / near.EI, far.K / far.EI) * stiffness
    free = mean(near.C + near.K**2 / near.EI, far.C + far.K**2 / far.EI)
    return Section(
        EI=stiffness,
        GA=1.0 / mean(1.0 / near.GA, 1.0 / far.GA),
        m=mean(near.m, far.m),
        rhoI=mean(near.rhoI, far.rhoI),
        K=coupling,
        C=free - coupling**2 / stiffness,
    )
