"""The points that a search has tried, and how it goes on from one of them."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import numpy as np

from tactgen.geometry.arrays import Floats
from tactgen.validation.studies.whatif.aim.best import Judged, felt_at, judged
from tactgen.validation.studies.whatif.aim.expression import Aim
from tactgen.validation.studies.whatif.asked.statement import Statement
from tactgen.validation.studies.whatif.run import StudySolver
from tactgen.validation.studies.whatif.search.found import Tried
from tactgen.validation.studies.whatif.search.ranges import Range

#: Most points, for each range, that a search takes from one start.
_STEPS = 40
#: Share of the ranges to which the place is found.
_FINE = 1e-5


@dataclass
class Points:
    """All points that were tried, by their shares of the ranges."""

    statement: Statement
    ranges: tuple[Range, ...]
    aims: tuple[Aim, ...]
    here: Floats
    announce: Callable[[str], None]
    tried: dict[tuple[float, ...], Tried] = field(default_factory=dict)

    def __post_init__(self) -> None:
        box = {r.key: (r.low, r.high) for r in self.ranges}
        self.solver = StudySolver(self.statement, announce=self._announced, ranges=box)

    def ask(self, shares: Floats) -> list[Tried]:
        """Return points (n, ranges), asking for what is new."""
        places = [tuple(float(v) for v in row) for row in np.clip(shares, 0.0, 1.0)]
        new = [place for place in dict.fromkeys(places) if place not in self.tried]
        if new:
            values = [
                {r.key: r.at(v) for r, v in zip(self.ranges, place, strict=True)} for place in new
            ]
            answers = self.solver.answers(values)
            for place, at, given in zip(new, values, answers, strict=True):
                found = judged(0, given, self.aims, felt_at(self.statement, at))
                reason = "; ".join(a.reason for a in given.values() if a.reason)
                self.tried[place] = Tried(
                    at, found[0] if found else None, reason or "a quantity has no value there"
                )
        return [self.tried[place] for place in places]

    def scales(self) -> Floats:
        """Return by how much each aim's margin differs over the points, 1 if it does not."""
        margins = np.array(
            [[m for m, _ in one.judged.margins] for one in self.tried.values() if one.judged]
        )
        over = np.ptp(margins, axis=0)
        return np.where(over > 0.0, over, 1.0)

    def shortfall(self, found: Judged, scales: Floats) -> float:
        """Return by how much the conditions are missed, in scales, 0 if all are met."""
        return sum(max(-margin, 0.0) for margin in self._conditions(found, scales))

    def best(self, scales: Floats) -> list[tuple[float, ...]]:
        """Return the places of all points that have answers, the best first."""

        def order(place: tuple[float, ...]) -> tuple[float, float]:
            found = self.tried[place].judged
            assert found is not None
            return self.shortfall(found, scales), -self._worth(place, found, scales)

        return sorted((p for p, one in self.tried.items() if one.judged), key=order)

    def go_on(self, start: tuple[float, ...], scales: Floats) -> None:
        """Search on from a point."""
        from scipy.optimize import NonlinearConstraint, minimize

        conditions = sum(aim.kind == "condition" for aim in self.aims)

        def at(shares: Floats) -> tuple[tuple[float, ...], Judged | None]:
            one = self.ask(shares[None])[0]
            return tuple(float(v) for v in np.clip(shares, 0.0, 1.0)), one.judged

        def cost(shares: Floats) -> float:
            place, found = at(shares)
            return -self._worth(place, found, scales) if found else 1.0

        def margins(shares: Floats) -> Sequence[float]:
            _, found = at(shares)
            return self._conditions(found, scales) if found else [-1.0] * conditions

        held = [NonlinearConstraint(margins, 0.0, np.inf)] if conditions else []
        minimize(
            cost,
            np.array(start),
            method="COBYQA",
            bounds=[(0.0, 1.0)] * len(self.ranges),
            constraints=held,
            options={
                "maxfev": _STEPS * len(self.ranges),
                "initial_tr_radius": 0.05,
                "final_tr_radius": _FINE,
            },
        )

    def _conditions(self, found: Judged, scales: Floats) -> list[float]:
        """Return the margins of the conditions in scales."""
        each = zip(self.aims, found.margins, scales, strict=True)
        return [m / float(scale) for aim, (m, _), scale in each if aim.kind == "condition"]

    def _worth(self, place: tuple[float, ...], found: Judged, scales: Floats) -> float:
        """Return how good a point is: by the goal, or by its nearness to the scene's own."""
        each = zip(self.aims, found.margins, scales, strict=True)
        goals = [m / float(scale) for aim, (m, _), scale in each if aim.kind == "goal"]
        if goals:
            return goals[0]
        return -float(((np.array(place) - self.here) ** 2).sum())

    def _announced(self, text: str) -> None:
        self.announce(f"{len(self.tried)} points tried: {text}")
