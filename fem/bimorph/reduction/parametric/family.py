"""A family of bimorphs on one level of bricks: built by looking where the basis knows least.

The basis begins with what the middle of the range and points near corners have to say.  Then the
bound of every answer is looked at in many points of the range, which takes no large system,
and the worst point is asked, until the bound is below the tolerance everywhere (a greedy
search).  How much was really missing there, once it is known, sets the bound's margin.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from tactgen.fem.bimorph.reduction.parametric.builder import FamilyBuilder
from tactgen.fem.bimorph.reduction.parametric.expansion import Expansion
from tactgen.fem.bimorph.reduction.parametric.reduced import Members, ReducedMotion
from tactgen.fem.piezo.symmetry import Motion
from tactgen.geometry.arrays import Floats
from tactgen.geometry.bimorph.bimorph_bricks import BrickMeshing
from tactgen.geometry.device.parameters import Device
from tactgen.geometry.store.values import storable

#: Most members that are asked.
_MOST = 60
#: Where no more is left out of the basis, that is rounding.
_ROUNDING = 1e-7
#: Tolerance of what is reduced at one point only: below, new shapes are rounding of others.
_AT_ONE_POINT = 1e-10


@storable
@dataclass(frozen=True)
class ReducedFamily:
    """A family on one level of bricks.

    Attributes
    ----------
    terms : Expansion
        Its matrices' terms.
    ranges : dict of str to (float, float)
        Lowest and highest value of each scene key that varies (SI).
    motions : dict of str to ReducedMotion
        Each class of motion on its basis.
    bound : float
        Largest relative error bound over the points that were looked at.
    asked : int
        Number of members that the bases were made of.
    unknowns : int
        Number of unknowns of a member in the first class of motion.
    """

    terms: Expansion
    ranges: dict[str, tuple[float, float]]
    motions: dict[Motion, ReducedMotion]
    bound: float
    asked: int
    unknowns: int

    def members(
        self, motion: Motion, device: Device, values: Mapping[str, Floats], *, lossy: bool = False
    ) -> Members:
        """Return the small systems of bimorphs that differ from `device` in `values` (n,)."""
        c = self.terms.coefficients(device, values, lossy=lossy)
        return self.motions[motion].members(self.terms, c)


def build_family(
    device: Device,
    ranges: Mapping[str, tuple[float, float]],
    meshing: BrickMeshing,
    modes: Mapping[Motion, int],
    *,
    tolerance: float,
    frequencies: Sequence[float] = (),
    announce: Callable[[str], None] = lambda _: None,
) -> ReducedFamily:
    """Reduce the bimorphs of a range of scene keys to small systems.

    Parameters
    ----------
    device : Device
        What does not vary.
    ranges : mapping of str to (float, float)
        Lowest and highest value of what does (SI).
    meshing : BrickMeshing
        How finely the bimorphs are divided.
    modes : mapping of Motion to int
        Classes of motion, and how many modes of each are wanted.
    tolerance : float
        Relative error bound to reach for frequencies, deflection, compliance and capacitance.
    frequencies : sequence of float
        Frequencies (Hz) at which responses with losses are wanted, if any are; what a resonance
        magnifies is left to the responses' bars.
    """
    builder = FamilyBuilder.of(
        device, dict(ranges), meshing, dict(modes), tolerance, _looked_at_too(frequencies)
    )
    for point in builder.beginning():
        builder.ask(point, list(modes))
    while True:
        bound, at = builder.worst()
        enough = builder.asked >= _MOST or builder.least < _ROUNDING
        if bound <= tolerance or enough:
            return _made(builder, bound)
        announce(f"bound {bound:.1e} after {builder.asked} members")
        builder.look_closer(at)
        builder.ask(builder.points[at], builder.poor(at))


def tangent_family(
    device: Device,
    meshing: BrickMeshing,
    modes: Mapping[Motion, int],
    *,
    frequencies: Sequence[float] = (),
) -> ReducedFamily:
    """Reduce the neighbourhood of one bimorph, for derivatives in all of its numbers at once.

    The basis holds what the bimorph itself has to say, to rounding.  A frequency, or what a
    load does at a load, is stationary in its state: what the basis misses next to the bimorph
    is of second order in the distance, so the derivatives of the small system are those of the
    large one, φᵀ (K' − λ M') φ and −xᵀ K' x, for whichever number K and M depend on.

    Parameters
    ----------
    device : Device
        The bimorph, on a division of its own.
    meshing : BrickMeshing
        How finely it is divided.
    modes : mapping of Motion to int
        Classes of motion, and how many modes of each are wanted.
    frequencies : sequence of float
        As of :func:`build_family`.
    """
    builder = FamilyBuilder.of(
        device, {}, meshing, dict(modes), _AT_ONE_POINT, _looked_at_too(frequencies)
    )
    return _made(builder, 0.0)


def _made(builder: FamilyBuilder, bound: float) -> ReducedFamily:
    """Return the family as it has grown."""
    return ReducedFamily(
        builder.products.terms,
        builder.ranges,
        builder.frozen(),
        bound,
        builder.asked,
        builder.unknowns,
    )


def _looked_at_too(frequencies: Sequence[float]) -> Floats:
    """Return where a response is looked at: in the middle, and where inertia counts most."""
    found = np.sort(np.asarray(frequencies, dtype=float))
    return np.unique(found[[found.size // 2, -1]]) if found.size else found
