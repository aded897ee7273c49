"""The bases of a family while they grow: what members add, and how much the bounds are missed by.

How much was really missing where a member was asked sets the bound's margin: the largest share
of a bound, in whichever answer, that the member then showed to have been missing.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from functools import cached_property
from typing import TypeVar

import numpy as np

from tactgen.fem.bimorph.reduction.parametric.expansion import expansion, with_values
from tactgen.fem.bimorph.reduction.parametric.growing import GrowingBasis
from tactgen.fem.bimorph.reduction.parametric.products import TermProducts
from tactgen.fem.bimorph.reduction.parametric.reduced import ReducedMotion
from tactgen.fem.bimorph.reduction.parametric.training_set import (
    Answers,
    TrainingSet,
    at_rest,
    response,
)
from tactgen.fem.piezo.bricks import assemble_bricks
from tactgen.fem.piezo.symmetry import Motion
from tactgen.fem.piezo.system import SolidSystem, materials
from tactgen.fem.solvers.pardiso import side_by_side
from tactgen.geometry.arrays import Floats
from tactgen.geometry.bimorph.bimorph_bricks import BrickMeshing
from tactgen.geometry.bimorph.bricks import Bricks
from tactgen.geometry.bimorph.stretching import dividing, stretched
from tactgen.geometry.device.parameters import Device

T = TypeVar("T")

#: Points of the range that are looked at, for each key that varies.
_LOOKED_AT = 64
#: Where the first members lie, as a share of the way from the middle to the corners: what the
#: basis misses is then about as much at the ends of a range as within.
_NEAR = 0.93
#: Safety on what was observed to be missing per squared norm of a residual, where the bound
#: without it was no more than this: beyond, neighbours that bounds rest on are far off themselves.
_SAFETY, _OBSERVED = 2.0, 1e-2
#: How much less is left out of the basis where a point that was asked is the worst again.
_CLOSER = 0.2
#: A member is asked of every class of motion whose bound is above this share of the tolerance; what
#: bounds were is worth learning from above that one.
_POOR, _WORTH = 0.3, 1e-3
#: Energy left out of the basis counts by its root, and this share of the tolerance's.
_LEFT_OUT = 0.1


@dataclass
class FamilyBuilder:
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
    ) -> FamilyBuilder:
        """Return one that knows the middle of the range; arguments as of `build_family`."""
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
            self._training[motion].forget()
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
            bound, at = self._training[motion].worst(self.tolerance / margin)
            return margin * bound, at

        return max(_for_each(self.modes, of).values())

    def poor(self, at: int) -> list[Motion]:
        """Return the classes of motion that a member at this point is to be asked of."""
        least = _POOR * self.tolerance
        return [m for m, own in self._training.items() if self.margins[m] * own.at(at) > least]

    def frozen(self) -> dict[Motion, ReducedMotion]:
        """Return each class of motion on its basis as it is."""
        return {motion: b.frozen(self.margins[motion]) for motion, b in self.bases.items()}

    @property
    def unknowns(self) -> int:
        """Number of unknowns of a member in the first class of motion."""
        return next(iter(self.bases.values())).unknowns

    @cached_property
    def _training(self) -> dict[Motion, TrainingSet]:
        """Bounds without their margins at the points of the range."""

        def over(motion: Motion) -> TrainingSet:
            return TrainingSet.over(
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
        worth = (before.bars > _WORTH * self.tolerance) & (before.bars < _OBSERVED)
        if worth.any():
            missed = np.abs(before.values - after.values)
            ratio = float((missed[worth] / before.missing[worth]).max())
            self.margins[motion] = max(self.margins[motion], _SAFETY * ratio)


def _for_each(motions: Iterable[Motion], work: Callable[[Motion], T]) -> dict[Motion, T]:
    """Return what is worked out for each class of motion; they know nothing of one another."""
    asked = list(motions)
    return dict(zip(asked, side_by_side(work, asked), strict=True))


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
