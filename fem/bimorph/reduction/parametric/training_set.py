"""What a basis is trained on: members of a family, what is looked at in them, where it is worst."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from tactgen.fem.bimorph.reduction.parametric.answers import family_modes, family_statics
from tactgen.fem.bimorph.reduction.parametric.harmonic import family_harmonic
from tactgen.fem.bimorph.reduction.parametric.reduced import Members
from tactgen.geometry.arrays import Bools, Floats, Ints, Numbers
from tactgen.geometry.bimorph.ends import Ends

#: Points that are looked at together: their small systems fit the cache.
_TOGETHER = 16


@dataclass(frozen=True)
class Answers:
    """Numbers of n members, what of them the basis may miss, and what that is counted against.

    Attributes
    ----------
    values : (n, m) array
        Real at rest, complex over frequency.
    missing : (n, m) array
        Bounds of their errors, in their own units, 0 where none is known, …
    sizes : (n, m) array
        … and what makes these bounds relative ones.
    """

    values: Numbers
    missing: Floats
    sizes: Floats

    @property
    def bars(self) -> Floats:
        """The relative bounds (n, m)."""
        return self.missing / self.sizes

    @property
    def bound(self) -> Floats:
        """The largest relative bound (n,) of each member."""
        return np.asarray(self.bars.max(axis=1))

    def beside(self, others: Answers) -> Answers:
        """Return these and other numbers of the same members."""
        return Answers(
            np.concatenate([self.values, others.values], axis=1),
            np.concatenate([self.missing, others.missing], axis=1),
            np.concatenate([self.sizes, others.sizes], axis=1),
        )


def at_rest(members: Members, modes: int) -> Answers:
    """Return frequencies and, of a body with ports, compliance, deflection and capacitance."""
    found = [family_modes(members, Ends(), modes, open_circuit=False)]
    if members.ports is not None:
        found.append(family_modes(members, Ends(), modes, open_circuit=True))
    values, missing = [one.frequencies for one in found], [one.bars for one in found]
    if members.ports is not None:
        statics = family_statics(members)
        volt, force = statics.missing[:, 0], statics.missing[:, 1]
        compliance = statics.compliance[:, 0, 0].real
        moved, charge = statics.follows[:, 0, 2].real, statics.held[:, 2, 2].real
        values.append(np.column_stack([compliance, moved, charge]))
        missing.append(np.column_stack([force**2, force * volt, volt**2]))
    every = np.concatenate(values, axis=1)
    return Answers(every, np.concatenate(missing, axis=1), np.abs(every))


def response(members: Members, rest: Answers, frequencies: Floats) -> Answers:
    """Return compliance, deflection and charge at frequencies, their bounds in shares of `rest`.

    What is magnified by a resonance is magnified in the answer, too, and counts by as much less.
    """
    found = family_harmonic(members, frequencies)
    volt, force = found.missing[:, :, 2], found.missing[:, :, 3]
    missing = np.stack([force**2, force * volt, volt**2], axis=2)
    served = np.where(np.isfinite(found.magnified), found.magnified, 1.0)
    values = np.stack(
        [found.compliance[:, :, 0, 0], found.follows[:, :, 0, 2], found.held[:, :, 2, 2]], axis=2
    )
    missing = np.where(np.isfinite(missing), missing, 0.0)
    sizes = served[:, :, None] * rest.sizes[:, None, -3:]
    n = values.shape[0]
    return Answers(values.reshape(n, -1), missing.reshape(n, -1), sizes.reshape(n, -1))


@dataclass(frozen=True)
class TrainingSet:
    """Bounds at n training points, worked out anew only where they may be the largest.

    A basis that grows lowers nearly all of them: what they were says where to look first.

    Attributes
    ----------
    work : callable
        Gives the bounds (m,) at some points (m,) by their numbers.
    known : (n,) array
        The bounds as last worked out, and …
    fresh : (n,) bool array
        … whether the basis is still the same.
    """

    work: Callable[[Ints], Floats]
    known: Floats
    fresh: Bools

    @classmethod
    def over(cls, count: int, work: Callable[[Ints], Floats]) -> TrainingSet:
        """Return one over as many points."""
        return cls(work, np.full(count, np.inf), np.zeros(count, dtype=bool))

    def forget(self) -> None:
        """Take note that the basis has grown."""
        self.fresh[:] = False

    def at(self, point: int) -> float:
        """Return the bound at one point."""
        if not self.fresh[point]:
            self._look(np.array([point]))
        return float(self.known[point])

    def worst(self, enough: float) -> tuple[float, int]:
        """Return the largest bound and its point, or, if it is no more than `enough`, a large one.

        That none is larger than `enough` is found by looking at every point.
        """
        while True:
            point = int(np.argmax(self.known))
            stale = np.flatnonzero(~self.fresh)
            if not stale.size or (self.fresh[point] and self.known[point] > enough):
                return float(self.known[point]), point
            self._look(stale[np.argsort(-self.known[stale])[:_TOGETHER]])

    def _look(self, points: Ints) -> None:
        self.known[points], self.fresh[points] = self.work(points), True
