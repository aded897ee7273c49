"""A family of bimorphs on one level of bricks: built by looking where the basis knows least.

The basis begins with what the middle of the range and points near corners have to say.  Then the
bound of every answer is looked at in many points of the range, which takes no large system,
and the worst point is asked, until the bound is below the tolerance everywhere (a greedy
search).  How much was really missing there, once it is known, sets the bound's margin.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import TypeVar

import numpy as np

from tactgen.fem.bimorph.bricks.assembly import assemble_bricks
from tactgen.fem.bimorph.motions import Motion
from tactgen.fem.bimorph.reduction.parametric.expansion import (
    Expansion,
    expansion,
    with_values,
)
from tactgen.fem.bimorph.reduction.parametric.growing import GrowingBasis
from tactgen.fem.bimorph.reduction.parametric.lookout import Answers, Lookout, at_rest, response
from tactgen.fem.bimorph.reduction.parametric.products import TermProducts
from tactgen.fem.bimorph.reduction.parametric.reduced import Members, ReducedMotion
from tactgen.fem.bimorph.system import SolidSystem, materials
from tactgen.fem.solvers.threads import side_by_side
from tactgen.geometry.arrays import Floats
from tactgen.geometry.bimorph.brick_family import BrickMeshing
from tactgen.geometry.bimorph.bricks import Bricks
from tactgen.geometry.bimorph.stretching import dividing, stretched
from tactgen.geometry.device.parameters import Device
from tactgen.geometry.store.values import storable

T = TypeVar("T")

#: Points of the range that are looked at, for each key that varies.
_LOOKED_AT = 64
#: Most members that are asked.
_MOST = 60
#: Where the first members lie, as a share of the way from the middle to the corners: what the
#: basis misses is then about as much at the ends of a range as within.
_NEAR = 0.93
#: Safety on what was observed to be missing per squared norm of a residual, where the bound
#: without it was no more than this: beyond, neighbours that bounds rest on are far off themselves.
_SAFETY, _OBSERVED = 2.0, 1e-2
#: How much less is left out of the basis where a point that was asked is the worst again, and
#: where what is left out is rounding.
_CLOSER, _ROUNDING = 0.2, 1e-7
#: Tolerance of what is reduced at one point only: below, new shapes are rounding of others.
_AT_ONE_POINT = 1e-10
#: Energy left out of the basis counts by its root, and this share of the tolerance's.
_LEFT_OUT = 0.1


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
    builder = _Builder.of(
        device, dict(ranges), meshing, dict(modes), tolerance, _looked_at_too(frequencies)
    )
    for point in builder.beginning():
        builder.ask(point, list(modes))
    while True:
        bound, at = builder.worst()
        enough = builder.asked >= _MOST or builder.least < _ROUNDING
        if bound <= tolerance or enough:
            return builder.family(bound)
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
    builder = _Builder.of(
        device, {}, meshing, dict(modes), _AT_ONE_POINT, _looked_at_too(frequencies)
    )
    return builder.family(0.0)


@dataclass
class _Builder:
    """A family that grows."""

    device: Device
    ranges: dict[str, tuple[float, float]]
    modes: dict[Motion, int]
    tolerance: float
    frequencies: Floats
    products: TermProducts
    bases: dict[Motion, GrowingBasis]
    margins: dict[Motion, float]
    points: Floats
    least: float
    asked: int = 1
    _seen: set[int] = field(default_factory=set)

    @classmethod
    def of(
        cls,
        device: Device,
        ranges: dict[str, tuple[float, float]],
        meshing: BrickMeshing,
        modes: dict[Motion, int],
        tolerance: float,
        frequencies: Floats,
    ) -> _Builder:
        middle = with_values(device, {key: 0.5 * sum(ends) for key, ends in ranges.items()})
        corners = [
            with_values(device, dict(zip(ranges, values, strict=True)))
            for values in itertools.product(*ranges.values())
        ]
        bricks = stretched(dividing(corners, meshing), middle.bimorph)
        system = assemble_bricks(middle, bricks, lossy=False)
        known = materials(middle, bricks.regions, middle.piezo.ceramic(), lossy=False)
        products = TermProducts(bricks, expansion(middle, bricks, system.volts_per_unit))
        least = float(_LEFT_OUT * np.sqrt(tolerance))

        def begun(motion: Motion) -> GrowingBasis:
            own = _in_motion(system, motion)
            basis = GrowingBasis(products, own, known, modes[motion])
            basis.learn(
                own, np.ones(3), least, _with_losses(middle, bricks, basis, frequencies)
            )  # fmt: skip
            return basis

        bases = _for_each(modes, begun)
        low, high = np.array(list(ranges.values())).reshape(-1, 2).T
        share = np.random.default_rng(2).uniform(size=(_LOOKED_AT * len(ranges), len(ranges)))
        ends = np.array(list(itertools.product((0.0, 1.0), repeat=len(ranges))))
        points = low + np.concatenate([share, ends]) * (high - low)
        margins = dict.fromkeys(modes, _SAFETY)
        return cls(
            device, ranges, modes, tolerance, frequencies, products, bases, margins, points, least
        )

    def beginning(self) -> list[Floats]:
        """Return the points that are asked before any bound is looked at.

        Near the corners: of several keys every second one, no two of which have an edge in
        common.
        """
        upper = np.array(list(itertools.product((-1.0, 1.0), repeat=len(self.ranges))))
        if len(self.ranges) > 1:
            upper = upper[upper.prod(axis=1) > 0.0]
        low, high = np.array(list(self.ranges.values())).T
        return list(0.5 * (low + high + _NEAR * upper * (high - low)))

    def ask(self, point: Floats, motions: list[Motion]) -> None:
        """Let a member add to the bases of some classes of motion."""
        member = with_values(self.device, dict(zip(self.ranges, point, strict=True)))
        bricks = stretched(self.products.bricks, member.bimorph)
        system = assemble_bricks(member, bricks, lossy=False)
        scale = self.products.terms.coefficients(member, {}).scale[0]

        def learn(motion: Motion) -> None:
            basis = self.bases[motion]
            before = self._answers(motion, point[None])
            lossy = _with_losses(member, bricks, basis, self.frequencies)
            basis.learn(_in_motion(system, motion), scale, self.least, lossy)
            self._lookouts[motion].forget()
            self._observe(motion, before, self._answers(motion, point[None]))

        _for_each(motions, learn)
        self.asked += 1

    def look_closer(self, at: int) -> None:
        """Leave less out from now on, if this point was asked before and is the worst again."""
        if at in self._seen:
            self.least *= _CLOSER
        self._seen.add(at)

    def worst(self) -> tuple[float, int]:
        """Return the largest relative bound, and at which point; below the tolerance of all."""

        def of(motion: Motion) -> tuple[float, int]:
            margin = self.margins[motion]
            bound, at = self._lookouts[motion].worst(self.tolerance / margin)
            return margin * bound, at

        return max(_for_each(self.modes, of).values())

    def poor(self, at: int) -> list[Motion]:
        """Return the classes of motion that a member at this point is to be asked of."""
        least = 0.3 * self.tolerance
        return [m for m, own in self._lookouts.items() if self.margins[m] * own.at(at) > least]

    def family(self, bound: float) -> ReducedFamily:
        """Return the family as it is."""
        first = next(iter(self.bases.values()))
        return ReducedFamily(
            self.products.terms,
            self.ranges,
            {motion: b.frozen(self.margins[motion]) for motion, b in self.bases.items()},
            bound,
            self.asked,
            first.unknowns,
        )

    @cached_property
    def _lookouts(self) -> dict[Motion, Lookout]:
        """Bounds without their margins at the points of the range."""

        def over(motion: Motion) -> Lookout:
            return Lookout.over(
                self.points.shape[0], lambda some: self._answers(motion, self.points[some]).bound
            )

        return {motion: over(motion) for motion in self.modes}

    def _answers(self, motion: Motion, points: Floats) -> Answers:
        """Return what is looked at, with bounds without their margin."""
        values = dict(zip(self.ranges, points.T, strict=True))
        terms, basis = self.products.terms, self.bases[motion].frozen(1.0)
        members = basis.members(terms, terms.coefficients(self.device, values))
        found = at_rest(members, self.modes[motion])
        if self.frequencies.size and basis.has_ports:
            lossy = terms.coefficients(self.device, values, lossy=True)
            found = found.beside(response(basis.members(terms, lossy), found, self.frequencies))
        return found

    def _observe(self, motion: Motion, before: Answers, after: Answers) -> None:
        """Widen the margin if more was missing than the bound said, without its margin."""
        # below, rounding
        worth = (before.bars > 1e-3 * self.tolerance) & (before.bars < _OBSERVED)
        if worth.any():
            missed = np.abs(before.values - after.values)
            ratio = float((missed[worth] / before.missing[worth]).max())
            self.margins[motion] = max(self.margins[motion], _SAFETY * ratio)


def _for_each(motions: Iterable[Motion], work: Callable[[Motion], T]) -> dict[Motion, T]:
    """Return what is worked out for each class of motion; they know nothing of one another."""
    asked = list(motions)
    return dict(zip(asked, side_by_side(work, asked), strict=True))


def _looked_at_too(frequencies: Sequence[float]) -> Floats:
    """Return where a response is looked at: in the middle, and where inertia counts most."""
    found = np.sort(np.asarray(frequencies, dtype=float))
    return np.unique(found[[found.size // 2, -1]]) if found.size else found


def _with_losses(
    member: Device, bricks: Bricks, basis: GrowingBasis, frequencies: Floats
) -> SolidSystem | None:
    """Return a member with losses, if responses of this class of motion are wanted."""
    if not (frequencies.size and basis.has_ports):
        return None
    return assemble_bricks(member, bricks, lossy=True)


def _in_motion(system: SolidSystem, motion: Motion) -> SolidSystem:
    """Return a member in one class of motion."""
    if motion == system.motion:
        return system
    assert system.related is not None
    return system.related(motion)
